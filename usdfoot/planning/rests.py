"""Rests: when agents that follow a trajectory stand still, and when they leave."""

from __future__ import annotations

import numpy as np

from usdfoot.engine.follow_options import FollowOptions
from usdfoot.maths import planar
from usdfoot.maths.planar import GROUND_AXES
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.planning.predictions import Gaits
from usdfoot.planning.root_curves import SPACING, RootCurves
from usdfoot.planning.strides import Stances, seen_from_left

__all__ = ["find_rests", "leave_times", "wait_times"]

UNEVEN_STANCE = 0.1
"""Feet this much farther apart or ahead of each other than in a stand are not left so [m]."""


def find_rests(gaits: Gaits, curves: RootCurves, stances: Stances, *, options: FollowOptions) -> BoolArray:
    """Whether N bodies are where they shall be a step later, with their feet as one stands, shape (N,)."""
    places, yaws = curves.at(stances.agents, stances.times + stances.durations)
    headings = stances.headings
    away = np.linalg.norm((places - stances.roots)[:, [0, 2]], axis=1)
    turned = np.abs(planar.wrap_angle(yaws - headings))
    between = planar.rotate(-headings, (stances.supports - stances.others)[:, [0, 2]])
    width = seen_from_left(between[:, 0], stances.sides)
    uneven = np.hypot(width - gaits.stance_width, between[:, 1])
    splayed = np.abs(planar.wrap_angle(stances.support_yaws - stances.other_yaws))
    return np.asarray(
        (away <= options.still_distance)
        & (turned <= options.still_turn)
        & (uneven <= UNEVEN_STANCE)
        & (splayed <= options.leave_turn)
    )


def leave_times(curves: RootCurves, stances: Stances, *, options: FollowOptions) -> FloatArray:
    """When the curves leave N standing bodies for good enough to step [s]; infinite where they do not, shape (N,)."""
    own = curves[stances.agents]
    times = own.starts[:, None] + SPACING * np.arange(own.yaws.shape[1])
    away = np.linalg.norm((own.positions - stances.roots[:, None])[..., [0, 2]], axis=-1)
    turned = np.abs(planar.wrap_angle(own.yaws - stances.headings[:, None]))
    left = (away > options.leave_distance) | (turned > options.leave_turn)
    left &= (times > stances.times[:, None]) & (times <= own.ends[:, None])
    return np.asarray(np.where(left.any(axis=1), times[np.arange(len(times)), np.argmax(left, axis=1)], np.inf))


def wait_times(
    curves: RootCurves, stances: Stances, afters: FloatArray, *, strikes: FloatArray, options: FollowOptions
) -> FloatArray:
    """When N steps shall strike that would take the root farther from where it shall be than it is [s], shape (N,).

    That is when the curve has come nearer to the root after the step, infinite if it never does. Steps that do not
    lead away strike when they did. Clips without short steps leave no other way to stop.

    Args:
        curves: Of all agents.
        stances: Where the agents stand.
        afters: Roots after the steps [m], shape (N, 3).
        strikes: When the steps strike if nobody waits [s], shape (N,).
        options: Of following.
    """
    wanted, _ = curves.at(stances.agents, strikes)
    gains = np.linalg.norm((stances.roots - wanted)[:, GROUND_AXES], axis=1)
    gains -= np.linalg.norm((afters - wanted)[:, GROUND_AXES], axis=1)
    times = strikes.copy()
    rows = np.flatnonzero(gains < -options.leave_distance)
    own = curves[stances.agents[rows]]
    grid = own.starts[:, None] + SPACING * np.arange(own.yaws.shape[1])
    places = own.positions[..., GROUND_AXES]
    before = np.linalg.norm(places - stances.roots[rows][:, None, GROUND_AXES], axis=-1)
    after = np.linalg.norm(places - afters[rows][:, None, GROUND_AXES], axis=-1)
    helps = (after < before) & (grid > strikes[rows, None]) & (grid <= own.ends[:, None])
    found = grid[np.arange(len(rows)), np.argmax(helps, axis=1)]
    times[rows] = np.where(helps.any(axis=1), found, np.inf)
    return times
