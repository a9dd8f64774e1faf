"""Motions below the transforms that artists authored, so that both together are where the agent walks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usdfoot.bridge.placements import AgentOps, planar_matrix
from usdfoot.bridge.similarity import Similarity
from usdfoot.bridge.units import StageUnits
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.motion import Motion
from usdfoot.writers.poses import RestingCharacter

__all__ = ["hold_root", "own_root"]


def hold_root(motion: Motion, resting: RestingCharacter, ops: AgentOps | None) -> RestingCharacter:
    """The character of an agent as a prim has it that artists keep where it is: its root joints go from there.

    Below such a prim the Skeleton moves against where the agent walks, as below a transform that moves.
    """
    if ops is None or ops.held is None:
        return resting
    undo = quaternion.yaw_quaternion(-motion.root_yaws)
    to_agent = Similarity(
        scale=1.0,
        rotation=quaternion.compose(undo, quaternion.yaw_quaternion(np.array(ops.held.yaw))),
        translation=quaternion.rotate(undo, ops.held.translation - motion.root_positions),
    )
    skeleton_to_agent = to_agent.after(resting.character.skeleton_to_agent)
    return replace(resting, character=replace(resting.character, skeleton_to_agent=skeleton_to_agent))


def own_root(motion: Motion, ops: AgentOps | None, units: StageUnits) -> tuple[FloatArray, FloatArray]:
    """Translations [stage units] (F, 3) and turns [rad] (F,) that the artists' transforms take to the motion's root."""
    places = units.points_to_stage(motion.root_positions)
    if ops is None:
        return places, motion.root_yaws
    if ops.held is not None:
        start = units.points_to_stage(ops.start.translation)
        return np.tile(start, (len(places), 1)), np.full(len(places), ops.start.yaw)
    yaws = motion.root_yaws - sum(planar_matrix(own, units).yaw for own in (ops.before, ops.between, ops.after))
    origin = units.points_to_canonical(ops.after[3, :3])
    inner = units.points_to_stage(quaternion.rotate(quaternion.yaw_quaternion(yaws), origin))
    inner = inner @ ops.between[:3, :3] + ops.between[3, :3]
    outer = np.linalg.inv(ops.before)
    return places @ outer[:3, :3] + outer[3, :3] - inner, yaws
