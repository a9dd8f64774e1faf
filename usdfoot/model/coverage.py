"""Coverage: where the steps of one style, gait and foot land, and how well."""

from __future__ import annotations

from dataclasses import dataclass

from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["EmptyCircle", "SpaceCoverage"]


@dataclass(frozen=True, kw_only=True)
class EmptyCircle:
    """A place around which no step lands."""

    place: FloatArray
    """(x, z) from the support ball in the heading at the step's end [m], shape (2,)."""
    radius: float
    """Distance of the nearest landing [m]."""
    inside: bool
    """Whether it lies in the hull of the landings, so that steps are blended there."""
    expected_error: float
    """Mean distance of the joints from a recorded step's [m]; NaN outside the hull."""


@dataclass(frozen=True, kw_only=True)
class SpaceCoverage:
    """The landings of one style, gait and swing foot of a skeleton's clips."""

    skeleton: str
    """Prim path."""
    style: str
    flight: bool
    side: int
    """Foot that lands: 0 = left, 1 = right."""
    steps: int
    """Examples, mirror images included."""
    landings: FloatArray
    """(x, z) from the support ball in the heading at the step's end [m], shape (V, 2)."""
    triangles: IntArray
    """Counter-clockwise in (x, z) for the left foot, clockwise for the right, shape (T, 3)."""
    hull: IntArray
    """Edges of the hull, shape (H, 2)."""
    errors: FloatArray
    """Mean distance of the joints to expect there [m], NaN where one clip is all there is, shape (V,)."""
    empty_circles: tuple[EmptyCircle, ...]
    """Largest first."""
