"""Followers: everyone with a trajectory gets footsteps before they are animated ([B] 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from usdfoot.engine.animate import PreparedLibraries
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
from usdfoot.model.agent import Crowd, Follower
from usdfoot.model.ground import Ground
from usdfoot.model.motion import Motion
from usdfoot.model.report import Problem
from usdfoot.model.trajectory import sample_trajectory
from usdfoot.planning.follow import Following, follow_trajectories, followed
from usdfoot.planning.proportions import proportions_of
from usdfoot.planning.trajectories import TrajectoryOptions, plan_trajectories

__all__ = ["following_figures", "plan_followers"]

PHYSICS = "physics"
"""The source of motion that needs no clips."""


def plan_followers(
    crowd: Crowd, *, options: EngineOptions, libraries: PreparedLibraries
) -> tuple[Crowd, dict[str, Following], list[Problem]]:
    """The crowd with a footstep plan for everyone who follows a trajectory.

    Args:
        crowd: As read.
        options: Of the engine, with those of following.
        libraries: Of the crowd.

    Returns:
        The crowd without followers; what was planned, by agent name; and whose trajectory cannot be followed.
    """
    agents, problems = list(crowd.agents), []
    followings: dict[str, Following] = {}
    for index, has_clips in sorted({(follower.library, follower.motion != PHYSICS) for follower in crowd.followers}):
        own = [f for f in crowd.followers if (f.library, f.motion != PHYSICS) == (index, has_clips)]
        plan = _step_like_clips if has_clips else _step_like_people
        for follower, found in zip(own, plan(crowd, own, libraries, options), strict=True):
            if isinstance(found, Following):
                followings[follower.name] = found
                agents.append(follower.walking(found.plan))
            else:
                message = f"{follower.source}: {found}"
                problems.append(Problem(severity="error", where=follower.source, message=message))
    return replace(crowd, agents=tuple(agents), followers=()), followings, problems


def _step_like_clips(
    crowd: Crowd, followers: Sequence[Follower], libraries: PreparedLibraries, options: EngineOptions
) -> Sequence[Following | UsdfootError]:
    """What becomes of followers of one library, whose steps are those of its clips."""
    try:
        prepared = libraries.prepared(crowd, followers[0].library)
        return follow_trajectories(
            prepared.examples,
            prepared.spaces,
            [follower.trajectory for follower in followers],
            style=prepared.style,
            body=proportions_of(prepared.source.skeleton, prepared.source.biped, prepared.source.bind_pose),
            ground=Ground(crowd.terrain),
            options=options.follow,
        )
    except UsdfootError as error:
        return [error] * len(followers)


def _step_like_people(
    crowd: Crowd, followers: Sequence[Follower], libraries: PreparedLibraries, options: EngineOptions
) -> Sequence[Following | UsdfootError]:
    """What becomes of followers whose steps no clip shows: as long and quick as people's of their size."""
    source = crowd.libraries[followers[0].library]
    body = proportions_of(source.skeleton, source.biped, source.bind_pose)
    terrain = Ground(crowd.terrain)
    found: list[Following | UsdfootError] = []
    for follower in followers:
        trajectory = follower.trajectory
        ground = terrain.falling_back(float(trajectory.positions[:, 1].min()))
        walk = TrajectoryOptions(smoothing_time=options.follow.smoothing_time, apart=False)
        try:
            (plan,) = plan_trajectories([trajectory], ground, proportions=body, options=walk)
        except UsdfootError as error:
            found.append(error)
            continue
        found.append(followed(trajectory, plan, smoothing_time=walk.smoothing_time))
    return found


def following_figures(following: Following, motion: Motion) -> dict[str, Any]:
    """How near a motion keeps to the trajectory it follows, as given, over all frames; metres and seconds."""
    trajectory = following.trajectory
    inside = (motion.times >= trajectory.start) & (motion.times <= trajectory.end)
    wanted = sample_trajectory(trajectory, motion.times[inside])
    distances = np.linalg.norm((motion.root_positions[inside] - wanted)[:, [0, 2]], axis=1)
    return {
        "rootDistanceMean": float(distances.mean()) if distances.size else None,
        "rootDistanceMax": float(distances.max()) if distances.size else None,
        "smoothingMean": following.smoothing[0],
        "smoothingMax": following.smoothing[1],
        "velocityError": [float(f"{error:.7g}") for error in following.velocity_errors.tolist()],
    }
