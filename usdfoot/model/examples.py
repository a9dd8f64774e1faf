"""Examples: the steps cut from a clip library, resampled so that their events fall on the same phases."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray

__all__ = ["LIFTOFF_PHASES", "Examples", "event_knots"]

LIFTOFF_PHASES = (0.15, 0.85)
"""Phases at which the swing foot's liftoff (walk) and the support foot's liftoff (flight) are put."""

LIFTOFF_WINDOW = (0.1, 0.45)
"""Parts of a step's duration between which a liftoff is aligned, from either end of the step."""


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
    """Joint-local xyzw, the pelvis's in the support frame, continuous in sign, float32, shape (E, S, J, 4)."""
    pelvis_positions: FloatArray
    """Pelvis joint in the support frame [m], height above the ground line, float32, shape (E, S, 3)."""
    support_balls: FloatArray
    """Support ball joint (FK on the character), support frame, height above the ground line [m], shape (E, S, 3)."""
    swing_balls: FloatArray
    """Swing ball joint, likewise, shape (E, S, 3)."""

    @property
    def default_style(self) -> str:
        """Style of steps that name none: "default" where a clip has it, else that of most examples."""
        return "default" if "default" in self.styles else max(sorted(set(self.styles)), key=self.styles.count)

    def __len__(self) -> int:
        return len(self.durations)


def event_knots(
    durations: FloatArray, swing_liftoffs: FloatArray, support_liftoffs: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Times and phases of the events inside each step; between them the phase of an example runs straight in time.

    An event outside the step, such as the support foot's liftoff in a walk, stays at the edge of the window it may
    move in. So the warp changes gradually from a walk to a run, and a late strike does not move it by much.

    Args:
        durations: Strike to strike [s], shape (N,).
        swing_liftoffs: Liftoff of the swing foot after the support strike [s], shape (N,).
        support_liftoffs: Liftoff of the support foot after its strike [s], shape (N,).

    Returns:
        Times [s] and phases, shape (N, 4) each: start, swing liftoff, support liftoff, end.
    """
    edge, middle = LIFTOFF_WINDOW
    shares = np.stack(
        [
            np.zeros_like(durations),
            np.clip(swing_liftoffs / durations, edge, middle),
            np.clip(support_liftoffs / durations, 1.0 - middle, 1.0 - edge),
            np.ones_like(durations),
        ],
        axis=1,
    )
    phases = np.broadcast_to(np.array([0.0, *LIFTOFF_PHASES, 1.0]), shares.shape)
    return shares * durations[:, None], phases
