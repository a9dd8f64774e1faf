"""Terrains with several levels, and others with known heights."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.model.terrain import Terrain


def terrain_of(quads: Sequence[FloatArray], *, walkable: Sequence[bool] | None = None) -> Terrain:
    """One mesh a quad (4, 3) [m], counter-clockwise from above."""
    corners = np.array(quads, dtype=float)
    starts = 4 * np.arange(len(corners))
    triangles = np.concatenate([np.array([[0, 1, 2], [0, 2, 3]]) + start for start in starts])
    return Terrain(
        meshes=tuple(f"/Ground_{i}" for i in range(len(corners))),
        points=corners.reshape(-1, 3),
        triangles=triangles,
        mesh_indices=np.repeat(np.arange(len(corners)), 2),
        walkable=np.array([True] * len(corners) if walkable is None else walkable),
    )


def slab(x: tuple[float, float], z: tuple[float, float], heights: tuple[float, float]) -> FloatArray:
    """A quad between x and z limits that rises from heights[0] at z[0] to heights[1] at z[1]."""
    return np.array(
        [
            (x[0], heights[0], z[0]),
            (x[0], heights[1], z[1]),
            (x[1], heights[1], z[1]),
            (x[1], heights[0], z[0]),
        ]
    )


def bridge() -> Terrain:
    """Level ground; over it, along z, a ramp from 0 to 2 m, a deck, and a ramp down again."""
    return terrain_of(
        [
            slab((-10.0, 10.0), (-10.0, 20.0), (0.0, 0.0)),
            slab((-1.0, 1.0), (0.0, 4.0), (0.0, 2.0)),
            slab((-1.0, 1.0), (4.0, 8.0), (2.0, 2.0)),
            slab((-1.0, 1.0), (8.0, 12.0), (2.0, 0.0)),
        ]
    )


def spiral(*, turns: float = 2.5, radius: float = 1.5, rise: float = 0.18, steps: int = 12) -> Terrain:
    """A spiral stair around the y axis, anticlockwise from +Z to +X, `steps` treads a turn of `rise` [m] each."""
    count = round(turns * steps)
    edges = 2.0 * np.pi * np.arange(count + 1) / steps
    inner, outer = 0.4 * radius, 1.6 * radius
    treads = []
    for i in range(count):
        a, b = edges[i], edges[i + 1]
        ring = [(inner, a), (outer, a), (outer, b), (inner, b)]
        treads.append(np.array([(r * np.sin(angle), rise * i, r * np.cos(angle)) for r, angle in ring]))
    return terrain_of(treads)


def storeys() -> Terrain:
    """Two floors of 8 m by 6 m, 2.7 m above one another, and stairs of 15 treads that join them along x = 9 m."""
    rise, run = 2.7 / 15, 0.3
    treads = [slab((8.0, 10.0), (i * run, (i + 1) * run), ((i + 1) * rise,) * 2) for i in range(15)]
    end = 15 * run
    return terrain_of(
        [
            slab((0.0, 8.0), (-1.0, 6.0), (0.0, 0.0)),
            slab((8.0, 10.0), (-1.0, 0.0), (0.0, 0.0)),
            *treads,
            slab((8.0, 10.0), (end, 6.0), (2.7, 2.7)),
            slab((0.0, 8.0), (-1.0, 6.0), (2.7, 2.7)),
        ]
    )
