"""Joint tracks: where UsdSkel has the joints of a written agent, back in canonical space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Usd, UsdGeom

from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.readers.skeleton import split_matrices
from usdfoot.readers.written import WrittenAgent

__all__ = ["JointTracks", "read_joint_positions", "read_joint_tracks"]


@dataclass(frozen=True, kw_only=True)
class JointTracks:
    """Joints of one agent as UsdSkel evaluates them, canonical."""

    times: FloatArray
    """[s], shape (F,)."""
    positions: FloatArray
    """In the world [m], shape (F, J, 3)."""
    local: FloatArray
    """Joint-local matrices (row vectors), shape (F, J, 4, 4)."""
    world: FloatArray
    """Matrices to the stage's world (row vectors), in its units, shape (F, J, 4, 4)."""
    units: StageUnits
    """Of the stage."""

    def turns(self, joints: Sequence[int]) -> FloatArray:
        """Rotations of some joints (K,) in the world, xyzw, shape (F, K, 4)."""
        _, turns, _ = split_matrices(self.world[:, list(joints)].reshape(-1, 4, 4))
        return self.units.frames_to_canonical(turns.reshape(len(self.times), -1, 4))

    def rotations(self) -> FloatArray:
        """Joint-local rotations, xyzw, continuous, shape (F, J, 4)."""
        _, rotations, _ = split_matrices(self.local.reshape(-1, 4, 4))
        return quaternion.continuous(rotations.reshape(*self.local.shape[:2], 4))


def read_joint_tracks(agent: WrittenAgent, units: StageUnits, codes: FloatArray) -> JointTracks:
    """Joints at time codes (F,), whole or not, interpolated as any USD program does.

    Raises:
        SceneError: If there are no time codes, or a joint is nowhere: not finite.
    """
    if not len(codes):
        raise SceneError(agent.animation, "has no samples", "animate the crowd again")
    local = np.empty((len(codes), len(agent.skeleton.joints), 4, 4))
    for frame, code in enumerate(codes.tolist()):
        local[frame] = agent.query.ComputeJointLocalTransforms(Usd.TimeCode(code))
    world = _world_matrices(agent, codes, slice(None))
    return JointTracks(
        times=units.codes_to_times(codes),
        positions=units.points_to_canonical(world[..., 3, :3]),
        local=local,
        world=world,
        units=units,
    )


def read_joint_positions(
    agent: WrittenAgent, units: StageUnits, codes: FloatArray, *, joints: Sequence[int]
) -> FloatArray:
    """Where some joints (K,) are at time codes (F,), whole or not, as in `read_joint_tracks` [m], shape (F, K, 3).

    Raises:
        SceneError: If a joint is nowhere: not finite.
    """
    return units.points_to_canonical(_world_matrices(agent, codes, list(joints))[..., 3, :3])


def _world_matrices(agent: WrittenAgent, codes: FloatArray, joints: slice | list[int]) -> FloatArray:
    """Matrices (row vectors) of K joints to the stage's world at time codes (F,), shape (F, K, 4, 4)."""
    skel: FloatArray = np.empty((len(codes), len(np.arange(len(agent.skeleton.joints))[joints]), 4, 4))
    above = np.empty((len(codes), 4, 4))
    xforms = UsdGeom.XformCache()
    for frame, code in enumerate(codes.tolist()):
        time = Usd.TimeCode(code)
        xforms.SetTime(time)
        skel[frame] = np.asarray(agent.query.ComputeJointSkelTransforms(time))[joints]
        above[frame] = xforms.GetLocalToWorldTransform(agent.skeleton_prim)
    world = (skel.reshape(len(codes), -1, 4) @ above).reshape(skel.shape)
    nowhere = np.flatnonzero(~np.isfinite(world).all(axis=(1, 2, 3)))
    if nowhere.size:
        raise SceneError(agent.animation, f"moves joints to nowhere at {codes[nowhere[0]]:g}", "author finite values")
    return world
