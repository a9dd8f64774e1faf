"""Walkable: terrain without obstacles as areas of one or more levels (shapely comes with the extra `crowd`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.model.terrain import Terrain
from usdfoot.planning.levels import extend_level, split_levels
from usdfoot.planning.spots import Spots, build_spots
from usdfoot.planning.world import Obstacle, box_outline, is_beside

__all__ = ["Area", "move_inside", "walkable_areas"]

SEAM = 1e-3
"""Gaps between faces narrower than twice this are closed [m]."""
AROUND = 10.0
"""Ground around everyone where there is no terrain [m]."""
CELL, MOST_CELLS = 0.1, 250_000
"""Width of the cells in which levels are told apart [m]; more than so many are made wider."""
LEAST = 0.2
"""Smaller levels are none [m2]."""
WALL = 0.02
"""Width of the gap where ground breaks off beside lower ground [m]."""
RIM = 0.02
"""Half width of what is left of ground along the cells taken out of it, and taken away too [m]."""


@dataclass(frozen=True, kw_only=True)
class Area:
    """Ground on which one can walk from anywhere to anywhere: levels that have aprons in common where they join."""

    levels: tuple[shapely.Polygon, ...]
    """(x, z) [m], L of them, aprons included."""
    spots: Spots | None
    """Of all the terrain; None where there is none, and a single level."""
    heights: FloatArray
    """Of each level in each cell of the spots, not a number where it has none [m], shape (L, X * Z)."""

    def height_at(self, levels: IntArray, points: FloatArray) -> FloatArray:
        """Height [m] of levels (N,) at points (N, 2), of a neighbouring cell at edges; not a number off them."""
        found = np.full(len(points), np.nan)
        if self.spots is None:
            return found
        own = np.rint((points - self.spots.corner) / self.spots.cell).astype(np.intp)
        for offset in sorted(np.ndindex(3, 3), key=lambda index: abs(index[0] - 1) + abs(index[1] - 1)):
            if not np.isnan(found).any():
                break
            index = own + np.array(offset) - 1
            inside = np.all((index >= 0) & (index < self.spots.shape), axis=1) & np.isnan(found)
            column = np.where(inside, index[:, 0] * self.spots.shape[1] + index[:, 1], 0)
            found = np.where(inside, self.heights[levels, column], found)
        return found


def walkable_areas(
    terrain: Terrain, obstacles: Sequence[Obstacle], *, bounds: FloatArray | None, places: FloatArray, headroom: float
) -> list[Area]:
    """Areas where feet may stand, each connected, the largest first.

    Args:
        terrain: Meshes; without any the ground is everywhere.
        obstacles: Cut out with their margins, of the levels on which they stand in the way.
        bounds: Outline to stay in, shape (K, 2), or None.
        places: Where people are or go (x, z) [m], shape (P, 2); without terrain and bounds the ground ends around them.
        headroom: Free height above the ground that they need [m].
    """
    floor = _floor(terrain)
    if bounds is not None:
        outline = shapely.Polygon(bounds)
        floor = outline if floor is None else floor.intersection(outline)
    if floor is None or not terrain.meshes:
        around = np.concatenate([places, *(obstacle.outline for obstacle in obstacles)])
        floor = floor or shapely.Polygon(box_outline(around.min(axis=0) - AROUND, around.max(axis=0) + AROUND))
        parts = _parts(_without(floor, obstacles))
        return [Area(levels=(part,), spots=None, heights=np.zeros((1, 0))) for part in parts]
    if floor.is_empty:
        return []
    spots = _spots(floor, Ground(terrain), headroom)
    pieces, masks = [], []
    labels = split_levels(spots)
    for label in np.flatnonzero(np.bincount(labels, minlength=1) * spots.cell**2 >= LEAST).tolist():
        reached = extend_level(spots, labels, label)
        heights = np.full(spots.shape, np.nan)
        heights.flat[spots.columns[reached]] = spots.heights[reached]
        beside = [one for one in obstacles if _stands_on(one, spots, heights)]
        for part in _parts(_without(_outline(floor, spots, reached), beside)):
            covered = reached & shapely.contains_xy(part, spots.points[:, 0], spots.points[:, 1])
            if np.any(covered & (labels == label)):
                pieces.append(part)
                masks.append(covered)
    return _joined(spots, pieces, masks)


def move_inside(room: shapely.Geometry, points: FloatArray) -> FloatArray:
    """The points (N, 2), those outside a room moved to where it is nearest."""
    shapely.prepare(room)
    outside = ~shapely.intersects_xy(room, points[:, 0], points[:, 1])
    if room.is_empty or not outside.any():
        return points
    moved = points.copy()
    lines = shapely.shortest_line(room, shapely.points(points[outside]))
    moved[outside] = shapely.get_coordinates(lines)[::2]
    return moved


def _floor(terrain: Terrain) -> shapely.Geometry | None:
    """The union of all walkable faces seen from above; None without terrain."""
    if not terrain.meshes:
        return None
    corners = terrain.points[terrain.triangles][np.asarray(terrain.walkable, dtype=bool)[terrain.mesh_indices]]
    faces = shapely.polygons(corners[:, :, [0, 2]])
    union = shapely.union_all(faces[shapely.area(faces) > 0.0])
    return union.buffer(SEAM, join_style="mitre").buffer(-SEAM, join_style="mitre")


def _spots(floor: shapely.Geometry, ground: Ground, headroom: float) -> Spots:
    """Spots of all the terrain below the floor."""
    lowest, highest = np.array(floor.bounds[:2]), np.array(floor.bounds[2:])
    cell = max(CELL, float(np.sqrt(np.prod(highest - lowest) / MOST_CELLS)))
    counts = np.ceil((highest - lowest) / cell).astype(int)
    corner = 0.5 * (lowest + highest) - 0.5 * cell * (counts - 1)
    return build_spots(ground, corner, (int(counts[0]), int(counts[1])), cell=cell, headroom=headroom)


def _outline(floor: shapely.Geometry, spots: Spots, reached: BoolArray) -> shapely.Geometry:
    """The floor without the cells that have ground, but not of this level, and with gaps where it breaks off."""
    others = spots.ground.copy()
    others[spots.columns[reached]] = False
    if others.any():
        floor = floor.difference(_boxes(spots, others))
        floor = floor.buffer(-RIM, join_style="mitre").buffer(RIM, join_style="mitre")
    breaks = _breaks(spots, reached)
    return floor.difference(breaks) if breaks is not None else floor


def _boxes(spots: Spots, cells: BoolArray) -> shapely.Geometry:
    """The cells (X * Z,) as one shape, made of a box for each run of them along z."""
    grid = np.pad(cells.reshape(spots.shape).astype(np.int8), ((0, 0), (1, 1)))
    changes = np.diff(grid, axis=1)
    row, begin = np.nonzero(changes == 1)
    _, end = np.nonzero(changes == -1)
    low = spots.corner + spots.cell * (np.stack([row, begin], axis=1) - 0.5)
    high = spots.corner + spots.cell * (np.stack([row + 1, end], axis=1) - 0.5)
    return shapely.union_all(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))


def _breaks(spots: Spots, reached: BoolArray) -> shapely.Geometry | None:
    """Where cells of a level lie beside each other but one cannot step from one to the other."""
    heights = np.full(spots.shape[0] * spots.shape[1], -1)
    rows = np.flatnonzero(reached)
    heights[spots.columns[rows]] = rows
    grid = heights.reshape(spots.shape)
    lines = []
    for axis in (0, 1):
        one, other = (grid[:-1], grid[1:]) if axis == 0 else (grid[:, :-1], grid[:, 1:])
        index = np.argwhere((one >= 0) & (other >= 0))
        pairs = one[tuple(index.T)], other[tuple(index.T)]
        apart = np.asarray(spots.links[pairs]).ravel() == 0.0
        along = np.eye(2)[axis]
        middle = spots.corner + spots.cell * (index[apart] + 0.5 * along)
        half = 0.5 * spots.cell * along[::-1]
        lines.append(np.stack([middle - half, middle + half], axis=1))
    ends = np.concatenate(lines)
    if not len(ends):
        return None
    whole = shapely.line_merge(shapely.union_all(shapely.linestrings(ends))).simplify(1e-6)
    return whole.buffer(0.5 * WALL, cap_style="square", join_style="mitre")


def _stands_on(obstacle: Obstacle, spots: Spots, heights: FloatArray) -> bool:
    """Whether an obstacle is in the way on a level, of heights [m] in the cells of the spots, NaN off it, (X, Z)."""
    near = shapely.Polygon(obstacle.outline).buffer(obstacle.margin + spots.cell)
    low, high = (np.reshape(near.bounds, (2, 2)) - spots.corner) / spots.cell
    first, last = np.maximum(np.ceil(low), 0.0).astype(int), np.maximum(np.floor(high) + 1.0, 0.0).astype(int)
    window = heights[first[0] : last[0], first[1] : last[1]]
    cells = np.argwhere(~np.isnan(window))
    points = spots.corner + spots.cell * (first + cells)
    inside = shapely.contains_xy(near, points[:, 0], points[:, 1])
    return bool(np.any(is_beside(obstacle, window[tuple(cells[inside].T)])))


def _without(floor: shapely.Geometry, obstacles: Sequence[Obstacle]) -> shapely.Geometry:
    shapes = [shapely.Polygon(obstacle.outline).buffer(obstacle.margin) for obstacle in obstacles]
    return floor.difference(shapely.union_all(shapes)) if shapes else floor


def _parts(floor: shapely.Geometry) -> list[shapely.Polygon]:
    """Its polygons, the largest first."""
    parts = [part for part in shapely.get_parts(floor) if part.geom_type == "Polygon" and part.area > 0.0]
    return sorted(parts, key=lambda part: -part.area)


def _joined(spots: Spots, pieces: list[shapely.Polygon], masks: list[BoolArray]) -> list[Area]:
    """Areas of the pieces, with their spots (S,), that have spots in common."""
    covers = coo_array(np.array(masks, dtype=float).reshape(len(pieces), len(spots.columns)))
    _, groups = connected_components((covers @ covers.T).tocsr(), directed=False)
    areas = []
    for group in np.unique(groups):
        own = np.flatnonzero(groups == group)
        heights = np.full((len(own), spots.shape[0] * spots.shape[1]), np.nan)
        for row, piece in enumerate(own):
            heights[row, spots.columns[masks[piece]]] = spots.heights[masks[piece]]
        areas.append(Area(levels=tuple(pieces[piece] for piece in own), spots=spots, heights=heights))
    return sorted(areas, key=lambda area: -sum(level.area for level in area.levels))
