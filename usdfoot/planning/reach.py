"""Reach: where a swing foot can and likes to come down, from the clips' landings or from the legs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from usdfoot.analysis.gaits import has_flight
from usdfoot.errors import ClipError
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.examples import Examples
from usdfoot.spaces.landings import end_landings, left_landings

__all__ = ["Reach", "reach_of_biped", "reach_of_examples"]

CIRCLE = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
"""Corners of outlines that stand for circles and ellipses [rad]."""


@dataclass(frozen=True, kw_only=True)
class Reach:
    """What one step may be. Landings are of the left foot, from the support ball, in the heading at the step's end.

    Those of the right foot are the mirror image.
    """

    outline: FloatArray
    """Convex outline of possible landings (x, z) [m], counter-clockwise with x to the right and z up, shape (K, 2)."""
    comfortable: FloatArray
    """Landing that costs least (x, z) [m], shape (2,)."""
    spread: FloatArray
    """Difference from it in x and z [m] that costs as much as a step, shape (2,)."""
    rise: float
    """Highest step up or down [m]."""
    turn: float
    """Largest change of heading in a step [rad]."""
    apart: float
    """Least distance between the balls of both feet [m]."""
    leaps: bool = False
    """Whether a step may have a flight."""

    @property
    def farthest(self) -> float:
        """Length of the longest step seen from above [m]."""
        return float(np.linalg.norm(self.outline, axis=1).max())


def reach_of_examples(examples: Examples, biped: Biped, *, stretch: float = 0.05, leaps: bool) -> Reach:
    """Reach of a library's clips: the hull of their landings.

    Args:
        examples: The library's steps.
        biped: Legs of the character; how high it steps follows from them, as the engine bends them to any height.
        stretch: How far outside the landings a footstep may be [m]; IK takes the rest.
        leaps: Whether steps with a flight count too.

    Raises:
        ClipError: If no step is left.
    """
    chosen = np.ones(len(examples), dtype=bool)
    if not leaps:
        chosen = ~has_flight(
            examples.durations, examples.support_liftoffs, examples.landings, leg_length=biped.maximal_leg_length
        )
    if not chosen.any():
        raise ClipError("clips", "show no step" + ("" if leaps else " without a flight"), "add walking clips")
    landings = left_landings(end_landings(examples), examples.swing_sides)[chosen]
    forward = landings[landings[:, 1] > np.median(np.abs(landings[:, 1])) * 0.5]
    around = stretch * np.stack([np.sin(CIRCLE), np.cos(CIRCLE)], axis=1)
    return _reach(
        _hull((landings[:, None] + around).reshape(-1, 2)),
        np.median(forward if len(forward) else landings, axis=0),
        biped,
        leaps=leaps,
    )


def reach_of_biped(biped: Biped, *, hip_width: float | None = None) -> Reach:
    """Reach of a biped without clips ([P] 2.2), from its virtual legs.

    Both feet are reached with straight legs when the pelvis sinks to 0.8 of the nominal leg length: half a step is the
    other side of that triangle. Sideways half of it is comfortable, backward half.

    Args:
        biped: Leg lengths.
        hip_width: Between the hips [m]; None = 0.2 of the leg length.
    """
    leg = biped.nominal_leg_length
    width = 0.2 * leg if hip_width is None else hip_width
    longest = 2.0 * float(np.sqrt(max(biped.maximal_leg_length**2 - (0.8 * leg) ** 2, (0.2 * leg) ** 2)))
    angle = CIRCLE
    forward = np.where(np.cos(angle) > 0.0, longest, 0.5 * longest) * np.cos(angle)
    sideways = np.where(np.sin(angle) > 0.0, 0.5 * longest, 0.5 * width) * np.sin(angle) + 0.5 * width
    return _reach(_hull(np.stack([sideways, forward], axis=1)), np.array([0.7 * width, 0.65 * longest]), biped)


def _reach(outline: FloatArray, comfortable: FloatArray, biped: Biped, *, leaps: bool = False) -> Reach:
    leg = biped.nominal_leg_length
    return Reach(
        outline=outline,
        comfortable=comfortable,
        spread=np.array([0.2, 0.4]) * leg,
        rise=0.45 * leg,
        turn=np.radians(45.0),
        apart=0.1 * leg,
        leaps=leaps,
    )


def _hull(points: FloatArray) -> FloatArray:
    """Corners of the convex hull, counter-clockwise."""
    try:
        return points[ConvexHull(points).vertices]
    except QhullError as error:
        raise ClipError("clips", "land all on one line", "let the reach be stretched, or use the biped's") from error
