"""Bodies: agents evaluated at an instant from what is prepared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.engine.animate import PreparedLibrary
from usdfoot.engine.plant import plant_feet
from usdfoot.engine.pose_source import Poses, pose_feet
from usdfoot.engine.poses import blend_frames
from usdfoot.engine.root import root_at
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.realtime.nudges import Nudges, Snapshot
from usdfoot.realtime.rows import Rows

__all__ = ["Bodies"]


@dataclass(frozen=True, kw_only=True)
class Bodies:
    """Agents, and what their poses are made from."""

    agents: IntArray
    """Shape (N,)."""
    time: float
    """[s]"""
    origins: FloatArray
    """The agents' [m], shape (N, 3)."""
    clock: FloatArray
    """Time on the agents' clocks [s], shape (N,)."""
    segments: IntArray
    """Row of each agent's segment, shape (N,)."""
    contacts: IntArray
    """Rows of the latest contacts of both feet, shape (N, 2)."""
    numbers: IntArray
    """Number of the later one, shape (N,)."""
    library: PreparedLibrary
    rows: Rows
    nudges: Nudges | None
    """None = as prepared."""

    def pose(self) -> Poses:
        """Blended poses, feet not yet planted."""
        library = self.library
        joints = np.delete(np.arange(len(library.source.skeleton.joints)), library.source.biped.pelvis)
        poses = blend_frames(library.device, self.rows.segments, rows=self.segments, clock=self.clock, joints=joints)
        if self.nudges is not None:
            bodies = poses.pelvis_positions, poses.pelvis_rotations, poses.rotations
            self.nudges.move_bodies(self.agents, self.time, bodies)
        return poses

    def plant(self, poses: Poses) -> None:
        """Plants the feet of poses, in place."""
        shifts = turns = np.zeros((0, 2, 3), dtype=np.float32)
        if self.nudges is not None:
            shifts, turns = self.nudges.feet(self.agents, self.time)
        wp.launch(
            plant_feet,
            dim=len(self.agents),
            inputs=[
                self.library.rig.arrays,
                self.rows.feet,
                wp.array(self.contacts.astype(np.int32), dtype=wp.int32, copy=False),
                wp.array(self.clock.astype(np.float32), dtype=wp.float32, copy=False),
                wp.array(shifts, dtype=wp.vec3f, copy=False),
                wp.array(turns, dtype=wp.vec3f, copy=False),
                poses.pelvis_positions,
                poses.pelvis_rotations,
                poses.rotations,
            ],
        )

    def roots(self) -> FloatArray:
        """x, ground height, z [m] and yaw [rad] of the roots, shape (N, 4)."""
        path = self.rows.path(self.segments)
        roots = root_at(path, np.arange(len(self.agents)), np.full(len(self.agents), self.time))[:, :4]
        return roots if self.nudges is None else roots + self.nudges.roots(self.agents, self.time)

    def snapshot(self) -> Snapshot:
        """The bodies in the world."""
        poses = self.pose()
        positions, rotations = poses.pelvis_positions.numpy() + self.origins, poses.rotations.numpy().copy()
        rotations[:, self.library.source.biped.pelvis] = poses.pelvis_rotations.numpy()
        self.plant(poses)
        feet = pose_feet(self.library.rig, poses)
        return Snapshot(
            pelvis_positions=positions,
            rotations=rotations.astype(float),
            balls=feet.balls + self.origins[:, None],
            ankles=feet.rotations,
            roots=self.roots(),
        )

    def landings(self) -> FloatArray:
        """When feet in the air strike [s], infinite for those that stand, shape (N, 2)."""
        feet = self.rows.feet.rows.numpy()
        own = feet[self.contacts]
        swings = own["liftoff"] <= self.clock[:, None]
        lands = feet["strike"][own["following"]] - self.clock[:, None]
        return np.where(swings, self.time + lands, np.inf)
