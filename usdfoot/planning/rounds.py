"""Rounds: followers step along their curves, everybody one step a round."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usdfoot.engine.follow_options import FollowOptions
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import LEFT
from usdfoot.model.ground import Ground
from usdfoot.planning.predictions import Gaits, choose_gaits, predict_steps
from usdfoot.planning.prints import put_on_ground, settle_landings
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.rests import find_rests, leave_times, wait_times
from usdfoot.planning.root_curves import RootCurves
from usdfoot.planning.strides import Stances, next_steps
from usdfoot.planning.tracks import Tracks

__all__ = ["LONGEST_STEP", "walk_rounds"]

LONGEST_STEP = 1.4
"""Longest walking step in lengths of the leg."""
GLANCE = 0.3
"""Time over which the start of a trajectory says how it begins: one that stays near it begins standing [s]."""
SHORTEST_STAND = 0.1
"""Least time from the start of a stand to the first liftoff [s]."""
SHORTEST_REST = 0.6
"""A body does not stand still for less than this between two steps [s]."""


def walk_rounds(
    gaits: Gaits, curves: RootCurves, sides: IntArray, *, ground: Ground, body: Proportions, options: FollowOptions
) -> Tracks:
    """All steps of all agents along their curves, in rounds of one step each.

    Args:
        gaits: How the clips step.
        curves: Where the roots are to be.
        sides: Each agent's first foot, 0 = left, 1 = right, shape (A,).
        ground: That feet land on.
        body: Who walks.
        options: How near they keep to the curves.
    """
    stances, standing = _first_stances(gaits, curves, sides, ground, body, options)
    longest = LONGEST_STEP * body.leg_length
    tracks = Tracks(len(stances))
    starts = np.where(standing, stances.times, np.nan)
    tracks.add(stances.agents, 1 - stances.sides, positions=stances.others, yaws=stances.other_yaws, strikes=starts)
    tracks.add(
        stances.agents,
        stances.sides,
        positions=stances.supports,
        yaws=stances.support_yaws,
        strikes=stances.times,
    )
    while len(stances):
        rests = standing | find_rests(gaits, curves, stances, options=options)
        begins, rested, stays = _begins(curves, stances, rests, standing, options)
        for back in (0, 1):
            tracks.release(stances.agents[stays], curves.ends[stances.agents[stays]], back=back)
        stances, begins, rested = stances[~stays], begins[~stays], rested[~stays]
        steps = next_steps(gaits, curves, stances, begins=begins, rested=rested, longest=longest, options=options)
        waits = wait_times(
            curves, stances, 0.5 * (steps.positions + stances.supports), strikes=steps.strikes, options=options
        )
        if np.any(waits != steps.strikes):
            stays, waiting = np.isinf(waits), waits > steps.strikes
            for back in (0, 1):
                tracks.release(stances.agents[stays], curves.ends[stances.agents[stays]], back=back)
            later = np.maximum(waits - steps.durations, stances.times + SHORTEST_REST)
            stances, begins, rested = (
                stances[~stays],
                np.where(waiting, later, begins)[~stays],
                (rested | waiting)[~stays],
            )
            steps = next_steps(gaits, curves, stances, begins=begins, rested=rested, longest=longest, options=options)
        positions = settle_landings(ground, stances.supports, steps.positions, yaws=steps.yaws, body=body)
        tracks.release(stances.agents, steps.liftoffs, back=1)
        tracks.release(stances.agents, steps.support_liftoffs, back=0)
        tracks.add(stances.agents, steps.sides, positions=positions, yaws=steps.yaws, strikes=steps.strikes)
        on = steps.strikes < curves.ends[stances.agents]
        stances = Stances(
            agents=stances.agents,
            times=steps.strikes,
            sides=steps.sides,
            supports=positions,
            support_yaws=steps.yaws,
            others=stances.supports,
            other_yaws=stances.support_yaws,
            runs=steps.runs,
            durations=steps.durations,
        )[on]
        standing = np.zeros(len(stances), dtype=bool)
    return tracks


def _first_stances(
    gaits: Gaits, curves: RootCurves, sides: IntArray, ground: Ground, body: Proportions, options: FollowOptions
) -> tuple[Stances, BoolArray]:
    """Where the agents stand at their first strike, the foot of `sides` (A,) just planted, and who starts standing.

    Flat trajectories may lie below the ground, and nobody stands under what is no higher than the legs: they start
    on top of it.
    """
    agents, times = np.arange(len(sides)), curves.starts
    places, yaws = curves.at(agents, times)
    later, _ = curves.at(agents, times + GLANCE)
    velocities = planar.rotate(-yaws, (later - places)[:, [0, 2]]) / GLANCE
    runs = choose_gaits(gaits, velocities[:, 1], np.zeros(len(agents), dtype=bool))
    steps = predict_steps(gaits, velocities, swing_sides=sides, runs=runs, hurry=options.hurry)
    apart = np.where(sides == LEFT, 0.5, -0.5) * gaits.stance_width
    ahead, turned = curves.at(agents, times + 0.5 * steps.durations)
    still = Stances(
        agents=agents,
        times=times,
        sides=sides,
        supports=places,
        support_yaws=yaws,
        others=places,
        other_yaws=yaws,
        runs=runs,
        durations=steps.durations,
    )
    standing = leave_times(curves, still, options=options) > times + GLANCE
    halves = np.where(standing[:, None], np.stack([apart, 0.0 * apart], axis=1), steps.offsets)
    ahead = np.where(standing[:, None], places, ahead) + np.insert(planar.rotate(yaws, halves), 1, 0.0, axis=1)
    turned = np.where(standing, yaws, turned) + steps.foot_yaws
    feet, foot_yaws = np.concatenate([ahead, 2.0 * places - ahead]), np.concatenate([turned, 2.0 * yaws - turned])
    start = put_on_ground(ground, places, places[:, 1], step_up=body.leg_length)
    feet = settle_landings(ground, np.tile(start, (2, 1)), feet, yaws=foot_yaws, body=body)
    return replace(
        still,
        supports=feet[: len(sides)],
        others=feet[len(sides) :],
        support_yaws=foot_yaws[: len(sides)],
        other_yaws=foot_yaws[len(sides) :],
        runs=runs & ~standing,
    ), standing


def _begins(
    curves: RootCurves, stances: Stances, rests: BoolArray, standing: BoolArray, options: FollowOptions
) -> tuple[FloatArray, BoolArray, BoolArray]:
    """When the next steps begin [s], which bodies stand until then, and which for good; shape (N,) each.

    A body leaves in time to land when its trajectory is about to be too far away. It does not stop for less than
    SHORTEST_REST.
    """
    begins = stances.times.copy()
    leaves = np.full(len(stances), np.inf)
    rows = np.flatnonzero(rests)
    if rows.size:
        leaves[rows] = leave_times(curves, stances[rows], options=options)
    stays = rests & np.isinf(leaves)
    lifts = np.where(rests & ~stays, leaves - stances.durations, begins)
    lifts = np.where(standing, np.maximum(lifts, begins + SHORTEST_STAND), lifts)
    rested = rests & ~stays & (standing | (lifts - begins > SHORTEST_REST))
    return np.where(rested, lifts, begins), rested, stays
