"""Libraries of any number of joints, and plans to walk with them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import IntArray
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.biped import Biped
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.skeleton import Skeleton
from usdfoot.model.terrain import Terrain

__all__ = ["straight_plan", "walking_crowd", "with_joints"]


def with_joints(library: ClipLibrary, count: int) -> ClipLibrary:
    """The library with `count` joints: leaves off the legs dropped, or copies of joints hung onto the first one."""
    skeleton = library.skeleton
    while len(skeleton.joints) > count:
        kept = np.delete(np.arange(len(skeleton.joints)), _spare_leaf(skeleton, library.biped))
        library = _kept(library, kept)
        skeleton = library.skeleton
    extra = count - len(skeleton.joints)
    joints = skeleton.joints + tuple(f"{skeleton.joints[0]}/Extra{number}" for number in range(extra))
    sources = np.concatenate([np.arange(len(skeleton.joints)), 1 + np.arange(extra) % (len(skeleton.joints) - 1)])
    parents = skeleton.parents[sources]
    parents[len(skeleton.joints) :] = 0
    return replace(
        library,
        skeleton=Skeleton(
            name=skeleton.name,
            joints=joints,
            parents=parents,
            rest_translations=skeleton.rest_translations[sources],
            rest_rotations=skeleton.rest_rotations[sources],
        ),
        clips=tuple(
            replace(clip, translations=clip.translations[:, sources], rotations=clip.rotations[:, sources])
            for clip in library.clips
        ),
    )


def _spare_leaf(skeleton: Skeleton, biped: Biped) -> int:
    """The last joint without children that is no ball."""
    joints = np.arange(len(skeleton.joints))
    return int(np.setdiff1d(joints, [*skeleton.parents, *biped.balls])[-1])


def _kept(library: ClipLibrary, kept: IntArray) -> ClipLibrary:
    """The library with the joints `kept` only, in order."""
    skeleton, biped = library.skeleton, library.biped
    number = np.full(len(skeleton.joints) + 1, -1)
    number[kept] = np.arange(len(kept))

    def pair(joints: tuple[int, int]) -> tuple[int, int]:
        return int(number[joints[0]]), int(number[joints[1]])

    moved = replace(
        biped,
        pelvis=int(number[biped.pelvis]),
        hips=pair(biped.hips),
        knees=pair(biped.knees),
        ankles=pair(biped.ankles),
        balls=pair(biped.balls),
    )
    return ClipLibrary(
        skeleton=Skeleton(
            name=skeleton.name,
            joints=tuple(skeleton.joints[joint] for joint in kept),
            parents=number[skeleton.parents[kept]],
            rest_translations=skeleton.rest_translations[kept],
            rest_rotations=skeleton.rest_rotations[kept],
        ),
        biped=moved,
        clips=tuple(
            replace(clip, translations=clip.translations[:, kept], rotations=clip.rotations[:, kept])
            for clip in library.clips
        ),
    )


def straight_plan(number: int, duration: float) -> FootstepPlan:
    """A walk of `duration` seconds beside those of other numbers; its pace and turn depend on the number."""
    step_time = 0.5 + 0.02 * (number % 5)
    count = int((duration - 1.24 * step_time) / step_time) + 1
    steps = np.arange(count)
    sides = (steps + number) % 2
    yaws = 0.03 * (number % 3 - 1) * steps
    length = 0.5 + 0.03 * (number % 7)
    ahead = np.concatenate([[[0.0, 0.0]], length * np.stack([np.sin(yaws), np.cos(yaws)], axis=1)[1:]]).cumsum(axis=0)
    across = np.where(sides == 0, 0.08, -0.08)[:, None] * np.stack([np.cos(yaws), -np.sin(yaws)], axis=1)
    ground = ahead + across + [2.0 * number, 0.0]
    strikes = step_time * steps
    return FootstepPlan(
        name=f"/World/Plans/Walk_{number}",
        sides=sides,
        positions=np.stack([ground[:, 0], np.zeros(count), ground[:, 1]], axis=1),
        orientations=quaternion.yaw_quaternion(yaws),
        strike_times=strikes,
        liftoff_times=strikes + 1.24 * step_time,
        root_weights=np.zeros(count),
    )


def walking_crowd(library: ClipLibrary, *, agents: int, frames: int, rate: float = 30.0) -> Crowd:
    """Agents that walk for `frames` samples on a plane."""
    none = np.zeros(0, dtype=int)
    return Crowd(
        agents=tuple(
            Agent(
                name=f"Agent_{number}",
                source=f"/World/Agent_{number}",
                plan=straight_plan(number, frames / rate),
                library=0,
                character=0,
            )
            for number in range(agents)
        ),
        libraries=(library,),
        terrain=Terrain(
            meshes=(),
            points=np.zeros((0, 3)),
            triangles=none.reshape(0, 3),
            mesh_indices=none,
            walkable=none.astype(bool),
        ),
        frame_times=np.arange(frames) / rate,
        frame_rate=rate,
    )
