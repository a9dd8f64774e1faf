"""Following: agents with a trajectory get footsteps before they are animated ([B] 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from usdfoot.engine.animate import prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
from usdfoot.model.agent import Agent, Crowd, Follower
from usdfoot.model.ground import Ground
from usdfoot.model.motion import Motion
from usdfoot.model.report import Problem
from usdfoot.model.trajectory import sample_trajectory
from usdfoot.planning.follow import Following, follow_trajectories
from usdfoot.planning.follow_options import FollowOptions

__all__ = ["following_figures", "plan_followers"]


def plan_followers(
    crowd: Crowd, *, options: EngineOptions | None = None, follow: FollowOptions | None = None
) -> tuple[Crowd, dict[str, Following]]:
    """The crowd with a footstep plan for every agent that follows a trajectory, and how near each plan keeps to it.

    An agent whose trajectory cannot be followed becomes a problem of the crowd.

    Args:
        crowd: As read.
        options: Of the engine.
        follow: How trajectories are walked.

    Returns:
        The crowd without followers, and what was planned by agent name.
    """
    agents: list[Agent] = list(crowd.agents)
    followings: dict[str, Following] = {}
    problems: list[Problem] = []
    for index in sorted({follower.performer.library for follower in crowd.followers}):
        own = [follower for follower in crowd.followers if follower.performer.library == index]
        try:
            planned = _plan(crowd, own, index, options or EngineOptions(), follow or FollowOptions())
        except UsdfootError as error:
            planned = [error] * len(own)
        for follower, found in zip(own, planned, strict=True):
            performer = follower.performer
            if isinstance(found, Following):
                followings[performer.name] = found
                agents.append(follower.walking(found.plan))
            else:
                message = f"{performer.source}: {found}"
                problems.append(Problem(severity="error", where=performer.source, message=message))
    whole = replace(crowd, agents=tuple(agents), followers=(), problems=(*crowd.problems, *problems))
    return whole, followings


def _plan(
    crowd: Crowd, followers: Sequence[Follower], library: int, options: EngineOptions, follow: FollowOptions
) -> Sequence[Following | UsdfootError]:
    """What becomes of followers of one library."""
    prepared = prepare_library(crowd.libraries[library], options)
    trajectories = [follower.trajectory for follower in followers]
    lowest = min(float(trajectory.positions[:, 1].min()) for trajectory in trajectories)
    return follow_trajectories(
        prepared.examples,
        prepared.spaces,
        trajectories,
        style=prepared.style,
        leg_length=prepared.source.biped.maximal_leg_length,
        ground=Ground(crowd.terrain, fallback_height=lowest),
        options=follow,
    )


def following_figures(following: Following, motion: Motion) -> dict[str, Any]:
    """What report.json says of an agent that follows a trajectory, in metres and seconds.

    The root's distance is from the trajectory as given, over all frames.
    """
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
