"""Rests: when agents that follow a trajectory stand still, and when they leave."""

from __future__ import annotations

import numpy as np

from usdfoot.engine.follow_options import FollowOptions
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.planning.predictions import Gaits
from usdfoot.planning.root_curves import SPACING, RootCurves
from usdfoot.planning.strides import Stances, seen_from_left

__all__ = ["find_rests", "leave_times"]

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
