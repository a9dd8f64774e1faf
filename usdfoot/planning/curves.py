"""Curves: the points along cubic and linear curves of every basis and wrap, as USD defines them."""

from __future__ import annotations

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray

__all__ = ["BASES", "sample_curve", "sample_hermite"]

BASES = {
    "bezier": np.array([[-1, 3, -3, 1], [3, -6, 3, 0], [-3, 3, 0, 0], [1, 0, 0, 0]], dtype=float),
    "bspline": np.array([[-1, 3, -3, 1], [3, -6, 3, 0], [-3, 0, 3, 0], [1, 4, 1, 0]]) / 6.0,
    "catmullRom": np.array([[-1, 3, -3, 1], [2, -5, 4, -1], [-1, 0, 1, 0], [0, 2, 0, 0]]) / 2.0,
    "hermite": np.array([[2, 1, -2, 1], [-3, -2, 3, -1], [0, 1, 0, 0], [1, 0, 0, 0]], dtype=float),
}
"""Rows are the powers u^3 .. 1, columns the four points of a segment; of hermite these are point, tangent, twice."""
STRIDES = {"bezier": 3, "bspline": 1, "catmullRom": 1, "hermite": 2}
"""Points from one segment to the next."""
DENSITY = 0.05
"""Distance between samples along a segment's points [units of the points], at most `MOST` samples."""
LEAST, MOST = 8, 2000


def sample_curve(
    points: FloatArray,
    *,
    basis: str = "bezier",
    wrap: str = "nonperiodic",
    name: str = "curve",
    density: float = DENSITY,
) -> FloatArray:
    """Points along one curve, shape (K, 3).

    Args:
        points: Of the curve, shape (N, 3).
        basis: linear, bezier, bspline, catmullRom or hermite (point and tangent in turn).
        wrap: nonperiodic, periodic (closed) or pinned (a bspline or catmullRom that reaches its end points).
        name: Of the curve, for messages.
        density: Distance between samples, in the units of the points.

    Raises:
        PlanError: If basis or wrap are unknown, the number of points is none of a curve of this kind, or one is not
            finite.
    """
    points = np.asarray(points, dtype=float)
    if not np.isfinite(points).all():
        raise PlanError(name, "has points that are not finite", "repair the curve")
    if wrap not in ("nonperiodic", "periodic", "pinned"):
        raise PlanError(name, f"has wrap {wrap}", "nonperiodic, periodic and pinned are known")
    if basis == "linear":
        if len(points) < 2:
            raise PlanError(name, f"has {len(points)} point(s)", "a linear curve needs two or more")
        return np.concatenate([points, points[:1]]) if wrap == "periodic" else points
    if basis not in BASES:
        raise PlanError(name, f"has basis {basis}", f"linear, {', '.join(BASES)} are known")
    return _evaluate(_segments(points, basis, wrap, name), BASES[basis], density)


def sample_hermite(
    points: FloatArray, tangents: FloatArray, *, name: str = "curve", density: float = DENSITY
) -> FloatArray:
    """Points along a C1 Hermite curve ([P] 2.1), shape (K, 3).

    Args:
        points: That it passes through, shape (N, 3).
        tangents: There, for a parameter that takes 1 from point to point, shape (N, 3).
        name: Of the curve, for messages.
        density: Distance between samples, in the units of the points.

    Raises:
        PlanError: If there are fewer than two points or not one tangent a point.
    """
    if len(points) < 2 or np.shape(points) != np.shape(tangents):
        raise PlanError(
            name, f"has {len(points)} points and {len(tangents)} tangents", "a Hermite curve needs two or more of each"
        )
    both = np.stack([points, tangents], axis=1).reshape(-1, 3)
    return sample_curve(both, basis="hermite", name=name, density=density)


def _segments(points: FloatArray, basis: str, wrap: str, name: str) -> FloatArray:
    """The four points of every segment, shape (S, 4, 3)."""
    count, stride = len(points), STRIDES[basis]
    if wrap == "periodic":
        if count < max(stride, 3) or count % stride:
            raise PlanError(name, f"has {count} points", f"a periodic {basis} curve needs a multiple of {stride}")
        segments = count // stride
        return points[(stride * np.arange(segments)[:, None] + np.arange(4)) % count]
    if wrap == "pinned" and stride == 1:
        if count < 2:
            raise PlanError(name, f"has {count} point(s)", f"a pinned {basis} curve needs two or more")
        points = np.concatenate([[2.0 * points[0] - points[1]], points, [2.0 * points[-1] - points[-2]]])
        count += 2
    if count < 4 or (count - 4) % stride:
        more = "four or more points" if stride == 1 else f"four points and {stride} for each further segment"
        raise PlanError(name, f"has {count} points", f"a {basis} curve needs {more}")
    segments = (count - 4) // stride + 1
    return points[stride * np.arange(segments)[:, None] + np.arange(4)]


def _evaluate(segments: FloatArray, basis: FloatArray, density: float) -> FloatArray:
    """Samples of segments (S, 4, 3), the end of each the start of the next."""
    coefficients = np.einsum("pc,scx->spx", basis, segments)
    chords = np.linalg.norm(coefficients[:, :3], axis=-1) @ np.array([3.0, 2.0, 1.0])  # no less than its length
    counts = np.clip(np.ceil(chords / density), LEAST, MOST).astype(int)
    rows = np.repeat(np.arange(len(segments)), counts)
    fractions = (np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[rows]
    rows, fractions = np.append(rows, len(segments) - 1), np.append(fractions, 1.0)
    powers = fractions[:, None] ** np.array([3, 2, 1, 0])
    return np.einsum("kp,kpx->kx", powers, coefficients[rows])
