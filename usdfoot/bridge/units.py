"""StageUnits: a stage's lengths, axes and times against canonical metres, +Y up and seconds, both ways."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.errors import SceneError
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray

__all__ = ["CANONICAL", "StageUnits"]

_HALF_TURN_ROOT = float(np.sqrt(0.5))
_SMALLEST, _LARGEST = 1e-12, 1e18
"""Lengths that a unit may have [m]: beyond picometres and a hundred light years, numbers run over when multiplied."""


@dataclass(frozen=True, kw_only=True)
class StageUnits:
    """Units of one stage; the defaults are USD's fallbacks.

    Canonical axes of a Z-up stage are (x, z, -y): its -Y, where characters face, becomes +Z.

    Raises:
        SceneError: If a unit is not positive or the up axis is neither Y nor Z.
    """

    meters_per_unit: float = 0.01
    """Length of one stage unit [m]."""
    up_axis: str = "Y"
    """Y or Z."""
    time_codes_per_second: float = 24.0
    """Time codes in one second [1/s]."""

    def __post_init__(self) -> None:
        if self.up_axis not in ("Y", "Z"):
            raise SceneError("upAxis", f"is {self.up_axis}", "author Y or Z")
        for label, value in (
            ("metersPerUnit", self.meters_per_unit),
            ("timeCodesPerSecond", self.time_codes_per_second),
        ):
            if not (np.isfinite(value) and value > 0.0):
                raise SceneError(label, f"is {value}", "author a positive number")
        if not _SMALLEST <= self.meters_per_unit <= _LARGEST:
            remedy = f"author a number between {_SMALLEST:g} and {_LARGEST:g}"
            raise SceneError("metersPerUnit", f"is {self.meters_per_unit:g}", remedy)

    @property
    def axes_to_canonical(self) -> FloatArray:
        """Rotation from the stage's axes to the canonical ones, xyzw, shape (4,)."""
        turn = (-_HALF_TURN_ROOT, 0.0, 0.0, _HALF_TURN_ROOT)
        return np.array(turn if self.up_axis == "Z" else (0.0, 0.0, 0.0, 1.0))

    def directions_to_canonical(self, vectors: FloatArray) -> FloatArray:
        """Vectors (..., 3) in the stage's axes turned to canonical axes, lengths kept."""
        vectors = np.asarray(vectors, dtype=float)
        return vectors[..., [0, 2, 1]] * (1.0, 1.0, -1.0) if self.up_axis == "Z" else vectors

    def directions_to_stage(self, vectors: FloatArray) -> FloatArray:
        """Vectors (..., 3) in canonical axes turned to the stage's axes, lengths kept."""
        vectors = np.asarray(vectors, dtype=float)
        return vectors[..., [0, 2, 1]] * (1.0, -1.0, 1.0) if self.up_axis == "Z" else vectors

    def points_to_canonical(self, points: FloatArray) -> FloatArray:
        """Points (..., 3) of the stage's world in the canonical world [m]."""
        return self.directions_to_canonical(points) * self.meters_per_unit

    def points_to_stage(self, points: FloatArray) -> FloatArray:
        """Canonical points [m] (..., 3) in the stage's world [stage units]."""
        return self.directions_to_stage(points) / self.meters_per_unit

    def rotations_to_canonical(self, rotations: FloatArray) -> FloatArray:
        """Rotations xyzw (..., 4) of the stage's world expressed in canonical axes."""
        vectors = self.directions_to_canonical(rotations[..., :3])
        return np.concatenate([vectors, np.asarray(rotations[..., 3:], dtype=float)], axis=-1)

    def rotations_to_stage(self, rotations: FloatArray) -> FloatArray:
        """Canonical rotations xyzw (..., 4) expressed in the stage's axes."""
        vectors = self.directions_to_stage(rotations[..., :3])
        return np.concatenate([vectors, np.asarray(rotations[..., 3:], dtype=float)], axis=-1)

    def frames_to_canonical(self, rotations: FloatArray) -> FloatArray:
        """Rotations xyzw (..., 4) from some local space to the stage's world, now to the canonical world.

        Unlike `rotations_to_canonical` the local space keeps its own axes: joints and prims do, prints do not.
        """
        return quaternion.compose(self.axes_to_canonical, rotations)

    def frames_to_stage(self, rotations: FloatArray) -> FloatArray:
        """Rotations xyzw (..., 4) from some local space to the canonical world, now to the stage's world."""
        return quaternion.compose(quaternion.inverse(self.axes_to_canonical), rotations)

    def codes_to_times(self, codes: FloatArray) -> FloatArray:
        """Time codes as times [s]."""
        return np.asarray(codes, dtype=float) / self.time_codes_per_second

    def times_to_codes(self, times: FloatArray) -> FloatArray:
        """Times [s] as time codes."""
        return np.asarray(times, dtype=float) * self.time_codes_per_second


CANONICAL = StageUnits(meters_per_unit=1.0, up_axis="Y", time_codes_per_second=24.0)
"""Of layers that are for no scene: metres, +Y up, at USD's own rate."""
