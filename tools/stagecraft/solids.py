"""Signed distances of simple solids and their smooth unions: what the body is modelled from.

A solid is a function from points [m], shape (N, 3), to distances [m], shape (N,), negative inside.
"""

from collections.abc import Callable, Sequence

import numpy as np

from stagecraft.rotation import FloatArray

Place = Sequence[float] | FloatArray
Solid = Callable[[FloatArray], FloatArray]


def ellipsoid(centre: Place, radii: Place) -> Solid:
    """Ellipsoid with axes along x, y and z (distance exact only near the surface)."""
    middle, size = np.asarray(centre), np.asarray(radii)

    def distance(points: FloatArray) -> FloatArray:
        scaled = (points - middle) / size
        length = np.linalg.norm(scaled, axis=1)
        slope = np.linalg.norm(scaled / size, axis=1)
        return length * (length - 1.0) / np.maximum(slope, 1e-9)

    return distance


def limb(start: Place, end: Place, radii: tuple[float, float], *, flat: tuple[Place, float] | None = None) -> Solid:
    """Capsule whose radius goes from `radii[0]` at `start` to `radii[1]` at `end`.

    Args:
        start: one end of the axis [m], shape (3,).
        end: the other end [m], shape (3,).
        radii: at the two ends [m].
        flat: direction in which the limb is thinner, and by which factor.
    """
    base, tip = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    squash = np.eye(3)
    if flat is not None:
        thin = np.asarray(flat[0]) / np.linalg.norm(flat[0])
        squash += (1.0 / flat[1] - 1.0) * np.outer(thin, thin)

    def distance(points: FloatArray) -> FloatArray:
        axis = squash @ (tip - base)
        offset = (points - base) @ squash.T
        along = np.clip(offset @ axis / (axis @ axis), 0.0, 1.0)
        away = np.linalg.norm(offset - along[:, None] * axis, axis=1)
        away = away - (radii[0] + (radii[1] - radii[0]) * along)
        return away * (flat[1] if flat is not None else 1.0)

    return distance


def blend(solids: Sequence[Solid], softness: float) -> Solid:
    """Union of `solids`, joined by fillets of about `softness` [m]."""

    def distance(points: FloatArray) -> FloatArray:
        total = solids[0](points)
        for solid in solids[1:]:
            other = solid(points)
            mix = np.clip(0.5 + 0.5 * (total - other) / softness, 0.0, 1.0)
            total = total + (other - total) * mix - softness * mix * (1.0 - mix)
        return total

    return distance


def cut(solid: Solid, point: Place, normal: Place, softness: float = 0.004) -> Solid:
    """`solid` without what lies beyond the plane through `point` on the side of `normal`."""
    origin = np.asarray(point)
    outward = np.asarray(normal) / np.linalg.norm(normal)

    def distance(points: FloatArray) -> FloatArray:
        inside, beyond = solid(points), (points - origin) @ outward
        mix = np.clip(0.5 - 0.5 * (inside - beyond) / softness, 0.0, 1.0)
        return inside + (beyond - inside) * mix + softness * mix * (1.0 - mix)

    return distance


def mirrored(solid: Solid) -> Solid:
    """`solid` (on the left, x > 0) and its mirror image."""

    def distance(points: FloatArray) -> FloatArray:
        return np.minimum(solid(points), solid(points * [-1.0, 1.0, 1.0]))

    return distance


def gradient(solid: Solid, points: FloatArray, step: float = 1e-4) -> FloatArray:
    """Direction in which the distance grows, shape (N, 3), not normalised."""
    columns = [(solid(points + offset) - solid(points - offset)) / (2.0 * step) for offset in np.eye(3) * step]
    return np.stack(columns, axis=1)
