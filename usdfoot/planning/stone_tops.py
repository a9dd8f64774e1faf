"""Stone tops: places on meshes where a foot can stand."""

from __future__ import annotations

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.ground import Ground
from usdfoot.model.terrain import Terrain
from usdfoot.planning.crossings import Stones
from usdfoot.planning.proportions import Proportions

__all__ = ["given_stones", "stones_on"]

STEEPEST = np.radians(35.0)
"""Tops steeper than this are nothing to stand on."""
LEVEL = 0.03
"""How much the top may fall away under the foot [m]."""
ON_GROUND = 0.05
"""A foothold given so near above or below the terrain is on it [m]."""
UPWARD = 0.5
"""Normals given that point less upward than that are no ground's."""
AVOIDED = 4.0
"""So many comfortable steps more are taken rather than standing on a foothold given in the air or beside an edge."""
MOST_PLACES = 1_000_000
"""Places looked at on one mesh at most."""


def stones_on(terrain: Terrain, *, body: Proportions, spacing: float = 0.12) -> Stones:
    """Footholds on the tops of all walkable meshes of a terrain: a grid on each, its middle at the middle of the mesh.

    Under the whole foot's width around the ball the top is level but for its slope; a stone too small for that gives
    its middle.

    Args:
        terrain: Meshes; each is a stone, whose top is what is seen of it from above.
        body: Whose feet.
        spacing: Of the grid [m].

    Raises:
        PlanError: If there is no walkable mesh, or one is too large for the spacing.
    """
    ground = Ground(terrain)
    ceiling = float(terrain.points[:, 1].max(initial=0.0))
    positions, normals = [np.zeros((0, 3))], [np.zeros((0, 3))]
    for index in np.flatnonzero(terrain.walkable):
        corners = terrain.points[terrain.triangles[terrain.mesh_indices == index]].reshape(-1, 3)
        lowest, highest = corners.min(axis=0), corners.max(axis=0)
        half = np.floor(0.5 * (highest - lowest)[[0, 2]] / spacing)
        if not np.prod(2 * half + 1) <= MOST_PLACES:
            size = (highest - lowest)[[0, 2]]
            what = f"is {size[0]:.1f} m by {size[1]:.1f} m, too large to look for footholds every {spacing:g} m"
            raise PlanError(terrain.meshes[index], what, "name the stones, or give a wider spacing")
        x, z = np.meshgrid(*(np.arange(-count, count + 1) * spacing for count in half.astype(int)), indexing="ij")
        points = 0.5 * (lowest + highest)[[0, 2]] + np.stack([x.ravel(), z.ravel()], axis=1)
        own = Ground(_only(terrain, int(index)))
        tops = own.heights(points, np.full(len(points), highest[1]))
        seen = ground.heights(points, np.full(len(points), ceiling))
        top = tops.hit & (np.abs(seen.heights - tops.heights) < 1e-3) & (tops.normals[:, 1] >= np.cos(STEEPEST))
        firm = top & _is_level(own, points, tops.heights, tops.normals, body.half_width)
        if not firm.any() and top.any():
            firm = np.arange(len(points)) == np.flatnonzero(top)[len(np.flatnonzero(top)) // 2]
        positions.append(np.column_stack([points[:, 0], tops.heights, points[:, 1]])[firm])
        normals.append(tops.normals[firm])
    return Stones(
        name=", ".join(terrain.meshes[:3]) or "stones",
        positions=np.concatenate(positions),
        normals=np.concatenate(normals),
    )


def given_stones(
    name: str, positions: FloatArray, normals: FloatArray | None, *, terrain: Terrain, body: Proportions
) -> Stones:
    """Footholds that somebody has placed; where a foot does not stand on the terrain there, they are avoided.

    Args:
        name: Of where they come from.
        positions: [m], shape (N, 3).
        normals: Of the ground, upward instead where too steep, shape (N, 3); None = the terrain's, upward off it.
        terrain: Below them.
        body: Whose feet.

    Raises:
        PlanError: If there is none, or one is not finite.
    """
    upward = np.tile([0.0, 1.0, 0.0], (len(positions), 1))
    own = upward if normals is None else np.where(normals[:, [1]] > UPWARD, normals, upward)
    given, ground = Stones(name=name, positions=positions, normals=own), Ground(terrain)
    if not ground.has_terrain:
        return given
    places = positions[:, [0, 2]]
    under = ground.heights(places, positions[:, 1], step_up=ON_GROUND)
    on = under.hit & (np.abs(under.heights - positions[:, 1]) <= ON_GROUND)
    firm = on & under.walkable & _is_level(ground, places, under.heights, under.normals, body.half_width)
    laid = np.where(on[:, None], under.normals, upward) if normals is None else own
    return Stones(name=name, positions=positions, normals=laid, discomforts=np.where(firm, 0.0, AVOIDED))


def _is_level(ground: Ground, points: FloatArray, heights: FloatArray, normals: FloatArray, radius: float) -> BoolArray:
    """Whether the ground goes on in its plane at four places around each point, shape (N,)."""
    level = np.ones(len(points), dtype=bool)
    for offset in radius * np.array([(1, 0), (-1, 0), (0, 1), (0, -1)]):
        around = ground.heights(points + offset, heights)
        plane = heights - (normals[:, [0, 2]] @ offset) / normals[:, 1]
        level &= around.hit & (np.abs(around.heights - plane) <= LEVEL)
    return level


def _only(terrain: Terrain, index: int) -> Terrain:
    """One mesh of a terrain."""
    own = terrain.mesh_indices == index
    return Terrain(
        meshes=(terrain.meshes[index],),
        points=terrain.points,
        triangles=terrain.triangles[own],
        mesh_indices=np.zeros(int(own.sum()), dtype=int),
        walkable=terrain.walkable[[index]],
    )
