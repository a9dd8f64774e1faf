"""Follow: root trajectories become footstep plans, one step of all agents at a time ([B] 5, lambda4 = 1)."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.engine.follow_options import FollowOptions
from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.examples import Examples
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.trajectory import RootTrajectory, sample_trajectories, sample_trajectory
from usdfoot.planning.predictions import build_gaits
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.root_curves import RootCurves, build_root_curves
from usdfoot.planning.rounds import walk_rounds
from usdfoot.planning.tracks import Tracks
from usdfoot.spaces.library import FootstepSpaces

__all__ = ["Following", "follow_trajectories", "followed"]


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
    tracks = walk_rounds(gaits, curves, _feet_first(trajectories), ground=ground, body=body, options=options)
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
