"""Maps of how exact the interpolators are over their parametric spaces ([B] Figures 3 and 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, Delaunay, QhullError

from usdfoot.engine.animate import PreparedLibrary
from usdfoot.engine.landings import blend_landings
from usdfoot.maths.types import FloatArray
from usdfoot.spaces.footsteps import solve_footsteps
from usdfoot.spaces.landings import left_landings
from usdfoot.spaces.root_velocity import solve_root_velocities
from usdfoot.spaces.side_space import SideSpace

__all__ = ["ErrorMap", "map_landings", "map_velocities"]


@dataclass(frozen=True, kw_only=True)
class ErrorMap:
    """Errors over a grid, NaN outside the examples' hull."""

    x: FloatArray
    """To the left, shape (W,)."""
    z: FloatArray
    """Ahead, shape (H,)."""
    errors: FloatArray
    """Distance from what was asked for to what the blend gives, shape (H, W)."""


def map_landings(library: PreparedLibrary, space: SideSpace, side: int, *, samples: int = 120) -> ErrorMap:
    """Distance from wanted landings to where the blended pose lands, not corrected [m] ([B] Fig. 5)."""
    x, z, queries = _grid(space.footsteps.vertices, samples)
    solved = solve_footsteps(space.footsteps, queries)
    inside = solved.hull_distances <= 0.0
    errors = np.full(len(queries), np.nan)
    order = np.argsort(-solved.weights, axis=1, kind="stable")[inside]
    chosen = np.take_along_axis(space.examples[solved.examples[inside]], order, axis=1)
    weights = np.take_along_axis(solved.weights[inside], order, axis=1)
    sides = np.full(len(chosen), side)
    landed = blend_landings(library.device, sides, examples=chosen, weights=weights)
    errors[inside] = np.linalg.norm(left_landings(landed, sides) - queries[inside], axis=1)
    return ErrorMap(x=x, z=z, errors=errors.reshape(len(z), len(x)))


def map_velocities(space: SideSpace, *, samples: int = 120) -> ErrorMap:
    """Distance from wanted root velocities to those the gradient bands blend [m/s]."""
    velocities = space.roots.velocities
    x, z, queries = _grid(velocities, samples)
    errors = solve_root_velocities(space.roots, queries).errors
    try:
        corners = Delaunay(velocities[ConvexHull(velocities).vertices])
        errors = np.where(corners.find_simplex(queries) >= 0, errors, np.nan)
    except (QhullError, ValueError):  # fewer than three, or on one line: there is no inside
        errors = np.full(len(queries), np.nan)
    return ErrorMap(x=x, z=z, errors=errors.reshape(len(z), len(x)))


def _grid(points: FloatArray, samples: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Both axes and all grid points (N, 2) of a box around points."""
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.05 * max(float((high - low).max()), 0.1)
    x, z = (np.linspace(low[i] - margin, high[i] + margin, samples) for i in (0, 1))
    return x, z, np.stack(np.meshgrid(x, z), axis=-1).reshape(-1, 2)
