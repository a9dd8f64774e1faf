"""Examples: the steps cut from a clip library, resampled so that their events fall on the same phases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray

__all__ = ["LIFTOFF_PHASES", "Examples", "event_knots"]

LIFTOFF_PHASES = (0.2, 0.8)
"""Phases at which the swing foot's liftoff (walk) and the support foot's liftoff (flight) are put."""


@dataclass(frozen=True, kw_only=True)
class Examples:
    """E steps of S samples each: strike of the support foot (phase 0) to strike of the swing foot (phase 1).

    Positions are in the *support frame*: origin at the ground under the planted support ball, +Y up, +Z along the
    heading at the step's start, the mean of both feet's yaws. Mirror images are examples of their own. Lengths are
    those of the character: a clip of other proportions has its pelvis path scaled by leg length. Heights of the
    pelvis and balls are above the *ground line*, which runs straight in phase from the mean height of the previous and
    the support contact to that of the support and the landing contact.
    """

    clip_names: tuple[str, ...]
    """Names of the clips the steps were cut from."""
    clip_indices: IntArray
    """Index into clip_names, shape (E,)."""
    mirrored: BoolArray
    """Whether the example is a mirror image, shape (E,)."""
    styles: tuple[str, ...]
    """Style of each example."""
    swing_sides: IntArray
    """Side of the foot that moves, 0 = left, 1 = right, shape (E,)."""
    start_times: FloatArray
    """Strike of the support foot, on the clip's clock [s], shape (E,)."""
    durations: FloatArray
    """Strike of the support foot to strike of the swing foot [s], shape (E,)."""
    flat_times: FloatArray
    """Support foot flat, after its strike [s], shape (E,)."""
    swing_liftoffs: FloatArray
    """Liftoff of the swing foot after the support strike [s]; negative after a flight, shape (E,)."""
    support_liftoffs: FloatArray
    """Liftoff of the support foot after its strike [s]; less than the duration before a flight, shape (E,)."""
    landings: FloatArray
    """Where the swing ball is planted next, (x, z) [m], shape (E, 2)."""
    landing_heights: FloatArray
    """Height of the landing contact above the support contact [m], shape (E,)."""
    landing_yaws: FloatArray
    """Direction of the landed foot [rad], shape (E,)."""
    departures: FloatArray
    """Where the swing ball was planted before, (x, z) [m], shape (E, 2)."""
    support_yaws: FloatArray
    """Direction of the support foot [rad], shape (E,)."""
    departure_yaws: FloatArray
    """Direction of the swing foot before it lifted [rad], shape (E,)."""
    turns: FloatArray
    """Change of heading over the step [rad], shape (E,)."""
    rotations: FloatArray
    """Joint-local rotations xyzw, the pelvis's in the support frame, continuous in sign, float32, shape (E, S, J, 4)."""
    pelvis_positions: FloatArray
    """Pelvis joint in the support frame [m], height above the ground line, float32, shape (E, S, 3)."""
    support_balls: FloatArray
    """Support ball joint (FK on the character) in the support frame [m], height above the ground line, shape (E, S, 3)."""
    swing_balls: FloatArray
    """Swing ball joint, likewise, shape (E, S, 3)."""

    def __len__(self) -> int:
        return len(self.durations)


def event_knots(
    durations: FloatArray, swing_liftoffs: FloatArray, support_liftoffs: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Times and phases of the events inside each step, for the monotone warp between the two.

    Args:
        durations: Strike to strike [s], shape (N,).
        swing_liftoffs: Liftoff of the swing foot after the support strike [s], shape (N,).
        support_liftoffs: Liftoff of the support foot after its strike [s], shape (N,).

    Returns:
        Times [s] and phases, shape (N, 4) each: start, swing liftoff, support liftoff, end. An event that falls
        outside the step (or out of order) lies on the straight line between its neighbours.
    """
    first, second = LIFTOFF_PHASES
    times = np.stack([np.zeros_like(durations), swing_liftoffs, support_liftoffs, durations], axis=1)
    margin = 0.05 * durations
    has_first = (swing_liftoffs > margin) & (swing_liftoffs < durations - margin)
    has_second = (support_liftoffs > margin) & (support_liftoffs < durations - margin)
    has_second &= ~has_first | (support_liftoffs > swing_liftoffs + margin)
    end_of_first = np.where(has_second, support_liftoffs, durations)
    phase_of_end = np.where(has_second, second, 1.0)
    times[:, 1] = np.where(has_first, swing_liftoffs, end_of_first * first / phase_of_end)
    start_of_second = np.where(has_first, times[:, 1], 0.0)
    phase_of_start = np.where(has_first, first, 0.0)
    fraction = (second - phase_of_start) / (1.0 - phase_of_start)
    times[:, 2] = np.where(has_second, support_liftoffs, start_of_second + fraction * (durations - start_of_second))
    phases = np.broadcast_to(np.array([0.0, first, second, 1.0]), times.shape)
    return times, phases
