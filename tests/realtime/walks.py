"""Plans fed to a controller footstep by footstep, and what its poses do in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tests.engine.plans import way
from usdfoot.engine.animate import PreparedLibrary
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.realtime.controller import Controller
from usdfoot.realtime.crowd_pose import CrowdPose
from usdfoot.realtime.footsteps import Footsteps

RATE = 25.0


def footsteps(plan: FootstepPlan, rows: Sequence[int]) -> Footsteps:
    """Some footsteps of a plan."""
    own = np.array(rows, dtype=int)
    return Footsteps(
        sides=plan.sides[own],
        positions=plan.positions[own],
        yaws=plan.yaws[own],
        strike_times=plan.strike_times[own],
        liftoff_times=plan.liftoff_times[own],
    )


def from_stand(controller: Controller, count: int, **about: float) -> FootstepPlan:
    """A way whose first two footsteps are where a controller's agents stand, left and lifted off as it would."""
    plan = way(count, stand_first=0.8, stand_last=1.0, **about)
    half = 0.5 * controller.stance_width
    positions = plan.positions - plan.positions[:2].mean(axis=0)
    orientations, liftoffs = plan.orientations.copy(), plan.liftoff_times.copy()
    positions[:2] = [[half, 0.0, 0.0], [-half, 0.0, 0.0]]
    orientations[:2] = [0.0, 0.0, 0.0, 1.0]
    liftoffs[0] = plan.strike_times[2] - controller.usual_swing
    liftoffs[1] = plan.strike_times[2] + 0.12
    return replace(plan, positions=positions, orientations=orientations, liftoff_times=liftoffs)


def times_of(plan: FootstepPlan, *, until: float = np.inf) -> FloatArray:
    """Frames from a plan's start to its end."""
    return np.arange(plan.start, min(plan.end, until), 1.0 / RATE)


def walk(
    controller: Controller, plans: Sequence[FootstepPlan], times: FloatArray, *, ahead: int
) -> tuple[list[CrowdPose], list[Problem]]:
    """Poses at `times` of agents that are told footstep k when footstep k - `ahead` strikes."""
    given, poses, problems = [2] * len(plans), [], []
    for time in times:
        for agent, plan in enumerate(plans):
            while given[agent] < len(plan) and plan.strike_times[max(given[agent] - ahead, 0)] <= time + 1e-9:
                problems += controller.plan(np.array([agent]), footsteps(plan, [given[agent]]))
                given[agent] += 1
        poses.append(controller.pose(float(time)))
    return poses, problems


@dataclass(frozen=True, kw_only=True)
class Seen:
    """Joints of one agent in the world."""

    joints: FloatArray  # [m], (F, J, 3)
    balls: FloatArray  # [m], (F, 2, 3)
    rotations: FloatArray  # world, (F, J, 4)


def see(library: PreparedLibrary, poses: Sequence[CrowdPose], agent: int = 0) -> Seen:
    """One agent's joints by forward kinematics."""
    skeleton, biped = library.source.skeleton, library.source.biped
    translations = np.array([pose.translations[agent] for pose in poses], dtype=float)
    rotations = np.array([pose.rotations[agent] for pose in poses], dtype=float)
    places, turns = forward_kinematics(skeleton.parents, translations, rotations)
    yaws = quaternion.yaw_quaternion(np.array([pose.root_yaws[agent] for pose in poses]))[:, None]
    roots = np.array([pose.root_positions[agent] for pose in poses])[:, None]
    joints = quaternion.rotate(yaws, places) + roots
    return Seen(joints=joints, balls=joints[:, list(biped.balls)], rotations=quaternion.compose(yaws, turns))


def off_footsteps(seen: Seen, times: FloatArray, plan: FootstepPlan, rows: Sequence[int]) -> FloatArray:
    """Largest horizontal distance of the planted balls to the footsteps `rows` from flat to liftoff [m]."""
    worst = []
    for row in rows:
        planted = (times >= plan.strike_times[row] + 0.125) & (times <= plan.liftoff_times[row])
        apart = seen.balls[planted, plan.sides[row]] - plan.positions[row]
        worst.append(np.linalg.norm(apart[:, [0, 2]], axis=1).max())
    return np.array(worst)
