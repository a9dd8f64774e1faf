"""Clip: one recorded skeletal animation; ClipLibrary: those that fit one skeleton."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from usdfoot.errors import ClipError
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Pose, Skeleton

__all__ = ["AuthoredEvents", "Clip", "ClipLibrary", "ShapeTrack"]


@dataclass(frozen=True, kw_only=True)
class AuthoredEvents:
    """Contact events an artist authored for one foot; None where the attribute is not authored."""

    strike_times: FloatArray | None = None
    """First contact of heel or ball [s], shape (K,), increasing."""
    flat_times: FloatArray | None = None
    """Foot flat [s], shape (K,)."""
    liftoff_times: FloatArray | None = None
    """Ball leaves the ground [s], shape (K,)."""


@dataclass(frozen=True, kw_only=True)
class ShapeTrack:
    """Weights of blend shapes over the samples of a clip."""

    names: tuple[str, ...]
    """Of B blend shapes."""
    weights: FloatArray
    """Shape (T, B)."""


@dataclass(frozen=True, kw_only=True)
class Clip:
    """Joint-local samples at a constant rate, joints in the skeleton's order.

    Raises:
        ClipError: If the arrays are not consistent, too short or not finite.
    """

    name: str
    """Prim path of the SkelAnimation, for messages and results."""
    rate: float
    """Samples a second [Hz]."""
    start_time: float
    """Time of the first sample [s], on the stage's clock (time code / timeCodesPerSecond)."""
    translations: FloatArray
    """Joint-local translations in the clip's own proportions [m], shape (T, J, 3)."""
    rotations: FloatArray
    """Joint-local unit quaternions xyzw, continuous in sign, shape (T, J, 4)."""
    style: str = "default"
    """Clips of one style share parametric spaces."""
    root_motion: str = "auto"
    """auto | travel | inPlace."""
    cyclic: bool | None = None
    """Whether the last sample continues with the first; None = find out."""
    range_start: float | None = None
    range_end: float | None = None
    """Range of the clip to cut steps from [s]; None = from the first, to the last sample."""
    mirror: bool = True
    """Also use the left/right mirror image."""
    events: tuple[AuthoredEvents, AuthoredEvents] = field(default=(AuthoredEvents(), AuthoredEvents()))
    """Authored contact events of the left and right foot."""
    synthetic: bool = False
    """Made by a program rather than recorded."""
    shapes: ShapeTrack | None = None
    """Blend shapes that go with it."""

    def __post_init__(self) -> None:
        frames, joints = self.rotations.shape[:2]
        if self.translations.shape != (frames, joints, 3) or self.rotations.shape != (frames, joints, 4):
            what = f"translations {self.translations.shape} do not match rotations {self.rotations.shape}"
            raise ClipError(self.name, what, "give one of each a joint in every sample")
        if frames < 2:
            raise ClipError(self.name, f"has {frames} sample(s)", "a clip needs at least two")
        if not (np.isfinite(self.translations).all() and np.isfinite(self.rotations).all()):
            raise ClipError(self.name, "has values that are not finite", "author numbers")

    @property
    def times(self) -> FloatArray:
        """Sample times [s], shape (T,)."""
        return self.start_time + np.arange(len(self.rotations)) / self.rate


@dataclass(frozen=True, kw_only=True)
class ClipLibrary:
    """A character's skeleton and biped with the clips that fit it."""

    skeleton: Skeleton
    biped: Biped
    clips: tuple[Clip, ...]
    bind_pose: Pose | None = None
    """The pose the character was rigged in, where it has one."""
