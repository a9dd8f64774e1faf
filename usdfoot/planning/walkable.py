"""Walkable: terrain without obstacles as areas on the ground (shapely comes with the extra `crowd`)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from usdfoot.maths.types import FloatArray
from usdfoot.model.terrain import Terrain
from usdfoot.planning.world import Obstacle, box_outline

__all__ = ["walkable_areas"]

STEEPEST = np.radians(35.0)
"""Ground steeper than this is not walked on."""
SEAM = 1e-3
"""Gaps between faces narrower than twice this are closed [m]."""
AROUND = 10.0
"""Ground around everyone where there is no terrain [m]."""


def walkable_areas(
    terrain: Terrain, obstacles: Sequence[Obstacle], *, bounds: FloatArray | None, places: FloatArray
) -> list[shapely.Polygon]:
    """Areas (x, z) [m] where feet may stand, each connected, the largest first.

    Levels above one another count as one area.

    Args:
        terrain: Meshes; without any the ground is everywhere.
        obstacles: Cut out with their margins.
        bounds: Outline to stay in, shape (K, 2), or None.
        places: Where people are or go (x, z) [m], shape (P, 2); without terrain and bounds the ground ends around them.
    """
    floor = _floor(terrain)
    if bounds is not None:
        outline = shapely.Polygon(bounds)
        floor = outline if floor is None else floor.intersection(outline)
    if floor is None:
        around = np.concatenate([places, *(obstacle.outline for obstacle in obstacles)])
        floor = shapely.Polygon(box_outline(around.min(axis=0) - AROUND, around.max(axis=0) + AROUND))
    shapes = [shapely.Polygon(obstacle.outline).buffer(obstacle.margin) for obstacle in obstacles]
    free = floor.difference(shapely.union_all(shapes)) if shapes else floor
    parts = [part for part in shapely.get_parts(free) if part.geom_type == "Polygon" and part.area > 0.0]
    return sorted(parts, key=lambda part: -part.area)


def _floor(terrain: Terrain) -> shapely.Geometry | None:
    """The union of all walkable faces seen from above; None without terrain."""
    if not terrain.meshes:
        return None
    corners = terrain.points[terrain.triangles]  # (T, 3, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    level = np.abs(normals[:, 1]) >= np.cos(STEEPEST) * np.linalg.norm(normals, axis=1)
    level &= np.asarray(terrain.walkable, dtype=bool)[terrain.mesh_indices]
    faces = shapely.polygons(corners[level][:, :, [0, 2]])
    return shapely.union_all(faces).buffer(SEAM, join_style="mitre").buffer(-SEAM, join_style="mitre")
