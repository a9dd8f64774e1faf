"""Poses as they are written: the root's way, and the pelvis relative to it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.engine.frames import Frames
from usdfoot.engine.given_roots import given_roots
from usdfoot.engine.pose_source import Layout, Poses
from usdfoot.engine.root import root_at
from usdfoot.maths import quaternion
from usdfoot.maths.planar import GROUND_AXES
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Agent

__all__ = ["RootedPoses", "root_poses"]


@dataclass(frozen=True, kw_only=True)
class RootedPoses:
    """F samples of all agents."""

    roots: FloatArray
    """Position on the ground [m] and heading [rad], world, shape (F, 4)."""
    pelvis_positions: FloatArray
    """In the agent's space [m], shape (F, 3)."""
    pelvis_rotations: FloatArray
    """In the agent's space, xyzw, shape (F, 4)."""
    rotations: wp.array
    """Joint-local quatf, shape (F, J)."""


def root_poses(layout: Layout, frames: Frames, poses: Poses, *, agents: Sequence[Agent]) -> RootedPoses:
    """Poses seen from the agents' roots, which go along the footsteps or where they are told to."""
    roots = root_at(layout.path, frames.segments, frames.times)
    wanted = given_roots(agents)
    given, places = wanted.positions(frames.agents, frames.times)
    roots[np.flatnonzero(given)[:, None], GROUND_AXES] = places[:, GROUND_AXES]
    given, yaws = wanted.yaws(frames.agents, frames.times)
    roots[given, 3] = yaws
    turn = quaternion.yaw_quaternion(-roots[:, 3])
    offsets = layout.origins[frames.agents] - roots[:, :3]
    return RootedPoses(
        roots=roots,
        pelvis_positions=quaternion.rotate(turn, poses.pelvis_positions.numpy() + offsets),
        pelvis_rotations=quaternion.compose(turn, poses.pelvis_rotations.numpy()),
        rotations=poses.rotations,
    )
