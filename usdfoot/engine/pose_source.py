"""What moves bodies, be it clips or physics: poses at any instant over where and when feet stand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import warp as wp

from usdfoot.engine.options import EngineOptions
from usdfoot.engine.plant import measure_legs
from usdfoot.engine.rig import Rig
from usdfoot.engine.root import RootPath
from usdfoot.engine.segments import Segments
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.model.skeleton import Skeleton

__all__ = ["Feet", "Layout", "PoseSource", "Poses", "pose_feet"]


@dataclass(frozen=True, kw_only=True)
class Poses:
    """Sampled frames on the device, positions from the agents' origins."""

    pelvis_positions: wp.array
    """vec3f, shape (F,)."""
    pelvis_rotations: wp.array
    """quatf, shape (F,)."""
    rotations: wp.array
    """Joint-local quatf, shape (F, J)."""


@dataclass(frozen=True, kw_only=True)
class Feet:
    """Feet of sampled frames, positions from the agents' origins [m]."""

    ankles: FloatArray
    """Shape (F, 2, 3)."""
    rotations: FloatArray
    """Ankle joints, shape (F, 2, 4)."""
    balls: FloatArray
    """Shape (F, 2, 3)."""
    raises: FloatArray
    """Pitch against flat, heel up > 0 [rad], shape (F, 2)."""
    hips: FloatArray
    """Shape (F, 2, 3)."""
    longest: FloatArray
    """Distance from hip to ankle that the leg may be stretched to [m], shape (F, 2)."""

    def __getitem__(self, rows: IntArray) -> Feet:
        return Feet(**{name: values[rows] for name, values in vars(self).items()})


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Where and when the feet of all agents of one character stand, whatever moves the body."""

    skeleton: Skeleton
    pelvis: int
    """Joint index of the pelvis."""
    rig: Rig
    contacts: ContactTable
    segments: Segments
    path: RootPath
    origins: FloatArray
    """Each agent's origin: its first contact [m], world, shape (A, 3)."""
    options: EngineOptions


class PoseSource(Protocol):
    """What moves the body: poses for any instant, feet not yet planted."""

    def pose(self, rows: IntArray, times: FloatArray, *, joints: IntArray) -> Poses:
        """Poses of segments `rows` (F,) at `times` [s] (F,); other `joints` than those given may be left unset."""
        ...


def pose_feet(rig: Rig, poses: Poses) -> Feet:
    """Ankles and balls of sampled poses."""
    count = poses.pelvis_positions.shape[0]
    vectors = {name: wp.empty((count, 2), dtype=wp.vec3f) for name in ("ankles", "balls", "hips")}
    numbers = {name: wp.empty((count, 2), dtype=wp.float32) for name in ("raises", "longest")}
    measured = {**vectors, **numbers, "rotations": wp.empty((count, 2), dtype=wp.quatf)}
    order = ("ankles", "rotations", "balls", "raises", "hips", "longest")
    wp.launch(
        measure_legs,
        dim=(count, 2),
        inputs=[rig.arrays, poses.pelvis_positions, poses.pelvis_rotations, poses.rotations],
        outputs=[measured[name] for name in order],
    )
    return Feet(**{name: values.numpy().astype(float) for name, values in measured.items()})
