"""Hybrid: the optimised centre of mass carries the pelvis of blended clips, whose posture stays theirs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.engine.pose_source import Poses
from usdfoot.engine.poses import ClipPoses
from usdfoot.maths import quaternion
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.physics.optimise import ComMotion
from usdfoot.physics.pelvis import hung_pelvises
from usdfoot.physics.posture import Posture, lay_posture

__all__ = ["HybridPoses", "carry_pelvis"]


@dataclass(frozen=True, kw_only=True)
class HybridPoses:
    """Poses blended from clips on a pelvis that the optimised centre of mass carries."""

    clips: ClipPoses
    com: ComMotion
    posture: Posture
    """Where the clips hold the pelvis, from where it hangs on the centre of mass in the rest pose, in the body's frame.

    People who stoop have their pelvis behind their centre of mass, which footprints cannot tell.
    """

    def pose(self, rows: IntArray, times: FloatArray, *, joints: IntArray) -> Poses:
        """Poses of segments `rows` (F,) at `times` [s] (F,)."""
        setup = self.clips.setup
        agents = setup.segments.agents[rows]
        poses = self.clips.pose(rows, times, joints=joints)
        pelvis = hung_pelvises(self.com, agents=agents, times=times, offsets=self.posture.at(agents, times))
        positions = wp.array((pelvis - setup.origins[agents]).astype(np.float32), dtype=wp.vec3f)
        return Poses(pelvis_positions=positions, pelvis_rotations=poses.pelvis_rotations, rotations=poses.rotations)


def carry_pelvis(clips: ClipPoses, com: ComMotion) -> HybridPoses:
    """Poses of clips on an optimised centre of mass, with the posture of the clips."""
    setup = clips.setup

    def apart(agents: IntArray, times: FloatArray) -> FloatArray:
        rows = locate(setup.segments.agents, setup.segments.begins, setup.contacts.starts, agents=agents, times=times)
        poses = clips.pose(rows, times, joints=setup.rig.leg_joints)
        blended = poses.pelvis_positions.numpy() + setup.origins[agents]
        turns = com.evaluate(agents, times).orientations
        return quaternion.rotate(
            quaternion.inverse(turns), blended - hung_pelvises(com, agents=agents, times=times, offsets=np.zeros(3))
        )

    return HybridPoses(clips=clips, com=com, posture=lay_posture(setup.contacts, apart))
