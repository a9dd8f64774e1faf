"""What a body does at the ends of examples, so that a step in another style goes on from the one before it ([B] 7)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.model.examples import LIFTOFF_PHASES, Examples, event_knots

__all__ = ["EndPoses", "build_end_poses"]

ANGLE_SCALE = 0.5
"""Joints' angles, root of their summed squares, that count as much as one unit of the other coordinates [rad]."""
RATE_SCALE = 5.0
"""Likewise their rates [rad/s]."""


@dataclass(frozen=True, kw_only=True)
class EndPoses:
    """Scaled joint angles and rates of E examples: distances between rows say how far a body would have to jump."""

    starts: FloatArray
    """When the support foot strikes, shape (E, P)."""
    ends: FloatArray
    """When the swing foot strikes, shape (E, P)."""


def build_end_poses(examples: Examples, pelvis: int) -> EndPoses:
    """Poses at both ends of examples, the `pelvis` left out, whose path the seams carry anyway."""
    rotations = np.delete(examples.rotations, pelvis, axis=2)[:, [0, 1, -2, -1]].astype(float)  # (E, 4, J, 4)
    rotations *= np.where(np.sum(rotations * rotations[:1, :1], axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    durations = np.asarray(examples.durations, dtype=float)
    times, _ = event_knots(durations, examples.swing_liftoffs, examples.support_liftoffs)
    samples = examples.rotations.shape[1] - 1
    first, last = LIFTOFF_PHASES
    before = (times[:, 1] / (first * samples))[:, None, None]
    after = ((durations - times[:, 2]) / ((1.0 - last) * samples))[:, None, None]
    angles = 2.0 / ANGLE_SCALE * rotations
    rates = 2.0 / RATE_SCALE * np.diff(rotations, axis=1)
    return EndPoses(
        starts=_flat(angles[:, 0], rates[:, 0] / before),
        ends=_flat(angles[:, 3], rates[:, 2] / after),
    )


def _flat(angles: FloatArray, rates: FloatArray) -> FloatArray:
    return np.concatenate([angles, rates], axis=1).reshape(len(angles), -1)
