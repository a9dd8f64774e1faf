"""Follow: root trajectories become footstep plans, one step of all agents at a time ([B] 5, lambda4 = 1)."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from usdfoot.engine.follow_options import FollowOptions
from usdfoot.errors import PlanError
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import LEFT
from usdfoot.model.examples import Examples
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.trajectory import RootTrajectory, sample_trajectories, sample_trajectory
from usdfoot.planning.predictions import Gaits, build_gaits, choose_gaits, predict_steps
from usdfoot.planning.prints import put_on_ground, settle_landings
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.rests import find_rests, leave_times, wait_times
from usdfoot.planning.root_curves import RootCurves, build_root_curves
from usdfoot.planning.strides import Stances, next_steps
from usdfoot.planning.tracks import Tracks
from usdfoot.spaces.library import FootstepSpaces

__all__ = ["LONGEST_STEP", "Following", "follow_trajectories", "followed"]

LONGEST_STEP = 1.4
"""Longest walking step in lengths of the leg."""
GLANCE = 0.3
"""Time over which the start of a trajectory says how it begins: one that stays near it begins standing [s]."""
SHORTEST_STAND = 0.1
"""Least time from the start of a stand to the first liftoff [s]."""
SHORTEST_REST = 0.6
"""A body does not stand still for less than this between two steps [s]."""


@dataclass(frozen=True, kw_only=True)
class Following:
    """The footsteps one trajectory was turned into, and how near they keep to it."""

    trajectory: RootTrajectory
    """As given."""
    plan: FootstepPlan
    velocity_errors: FloatArray
    """Mean root velocity from the footstep before to this one minus the trajectory's [m/s], shape (N,); 0 for those
    that have no step before them."""
    distances: FloatArray
    """Middle of this footstep and the one before to the trajectory at the strike [m], shape (N,); likewise."""
    smoothing: tuple[float, float]
    """Mean and largest distance of the smoothed trajectory from the given one [m]."""


def follow_trajectories(
    examples: Examples,
    spaces: FootstepSpaces,
    trajectories: Sequence[RootTrajectory],
    *,
    style: str,
    body: Proportions,
    ground: Ground,
    options: FollowOptions | None = None,
) -> list[Following | PlanError]:
    """Footsteps for every trajectory: predict the next landing, lay it on the ground, go on.

    Each trajectory is followed for itself; the same one always becomes the same footsteps.

    Args:
        examples: Steps of the clips.
        spaces: Their footstep spaces.
        trajectories: One an agent.
        style: Of the steps.
        body: Sizes of the character.
        ground: The terrain; without any the footsteps lie at the trajectories' own heights.
        options: Of following.

    Returns:
        For each trajectory what became of it, or why it cannot be followed.

    Raises:
        ClipError: If the clips have no step of a foot in this style.
    """
    options = options or FollowOptions()
    gaits = build_gaits(examples, spaces, style=style, leg_length=body.leg_length)
    curves = build_root_curves(trajectories, smoothing_time=options.smoothing_time)
    tracks = _walk(gaits, curves, _feet_first(trajectories), ground, body, options)
    distances, errors = _measure(tracks, trajectories)
    return [
        _followed(
            tracks,
            curves,
            agent,
            trajectory=trajectory,
            ground=ground,
            distances=distances[:, agent],
            errors=errors[:, agent],
            options=options,
        )
        for agent, trajectory in enumerate(trajectories)
    ]


def followed(trajectory: RootTrajectory, plan: FootstepPlan, *, smoothing_time: float) -> Following:
    """How near a plan that was made for a trajectory keeps to it, feet that stand together left out.

    Args:
        trajectory: As given.
        plan: Made for it.
        smoothing_time: In which the trajectory was smoothed before [s].
    """
    missed = np.zeros((len(plan), 2))
    middles = 0.5 * (plan.positions[1:] + plan.positions[:-1])
    missed[1:] = (middles - sample_trajectory(trajectory, plan.strike_times[1:]))[:, [0, 2]]
    elapsed = np.diff(plan.strike_times)
    errors = np.zeros(len(plan))
    errors[2:] = np.linalg.norm(np.diff(missed[1:], axis=0), axis=1) / elapsed[1:]
    (deviations,) = build_root_curves([trajectory], smoothing_time=smoothing_time).deviations
    return Following(
        trajectory=trajectory,
        plan=plan,
        velocity_errors=errors,
        distances=np.linalg.norm(missed, axis=1),
        smoothing=(float(deviations[0]), float(deviations[1])),
    )


def _feet_first(trajectories: Sequence[RootTrajectory]) -> IntArray:
    """Side of each agent's first foot, by its name, so that a crowd does not march in step, shape (A,)."""
    return np.array([zlib.crc32(trajectory.name.encode()) & 1 for trajectory in trajectories], dtype=np.intp)


def _walk(
    gaits: Gaits, curves: RootCurves, sides: IntArray, ground: Ground, body: Proportions, options: FollowOptions
) -> Tracks:
    """All steps of all agents, in rounds of one step each."""
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


def _measure(tracks: Tracks, trajectories: Sequence[RootTrajectory]) -> tuple[FloatArray, FloatArray]:
    """How far the roots are off their trajectories.

    Returns:
        Distances at the strikes [m], and errors of the mean velocity between them [m/s], shape (S, A) each; 0 where
        there is no step before.
    """
    positions, strikes = tracks.positions, tracks.strikes
    places = np.concatenate([trajectory.positions for trajectory in trajectories])
    agents = np.broadcast_to(np.arange(len(trajectories)), strikes.shape)
    wanted = sample_trajectories(trajectories, agents, strikes, values=places)
    missed = np.zeros_like(positions)
    missed[1:] = 0.5 * (positions[1:] + positions[:-1]) - wanted[1:]
    missed = missed[..., [0, 2]]
    known = np.asarray(np.isfinite(missed[1:]).all(axis=-1) & np.isfinite(missed[:-1]).all(axis=-1))
    known[0] = False
    elapsed = np.diff(strikes, axis=0)
    errors = np.zeros(strikes.shape)
    speeds = np.linalg.norm(np.diff(missed, axis=0), axis=-1)
    errors[1:] = np.where(known, speeds / np.where(elapsed > 0.0, elapsed, 1.0), 0.0)
    return np.nan_to_num(np.linalg.norm(missed, axis=-1)), errors


def _followed(
    tracks: Tracks,
    curves: RootCurves,
    agent: int,
    *,
    trajectory: RootTrajectory,
    ground: Ground,
    distances: FloatArray,
    errors: FloatArray,
    options: FollowOptions,
) -> Following | PlanError:
    """The agent's plan with how near it keeps to its trajectory; an error if it does not."""
    try:
        plan, rounds = tracks.plan(agent, trajectory.end, ground, name=trajectory.name)
    except PlanError as error:
        return error
    waits = np.maximum(plan.strike_times[1:], plan.liftoff_times[:-1])  # until then a standing body stays where it is
    middles = 0.5 * (plan.positions[1:] + plan.positions[:-1])
    missed = np.linalg.norm((middles - sample_trajectory(trajectory, waits))[:, [0, 2]], axis=1)
    lost = np.flatnonzero(missed > options.lost_distance)
    if lost.size:
        return _lost(trajectory, float(waits[lost[0]]), float(missed[lost[0]]))
    return Following(
        trajectory=trajectory,
        plan=plan,
        velocity_errors=errors[rounds],
        distances=distances[rounds],
        smoothing=(float(curves.deviations[agent, 0]), float(curves.deviations[agent, 1])),
    )


def _lost(trajectory: RootTrajectory, time: float, distance: float) -> PlanError:
    """Says where the feet lose a trajectory, and how fast that is."""
    speeds = np.linalg.norm(np.diff(trajectory.positions[:, [0, 2]], axis=0), axis=1) / np.diff(trajectory.times)
    fastest = int(np.argmax(speeds))
    return PlanError(
        trajectory.name,
        f"cannot be followed: at {time:.4g} s the feet are {distance:.2g} m away",
        f"it goes {speeds[fastest]:.3g} m/s at {trajectory.times[fastest]:.4g} s; slow it down, or add clips as fast",
    )
