"""Terrains: flat, slope, stairs, stepping stones and hills, as polygon surfaces with a height query."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stagecraft.rotation import FloatArray, about_y

Height = Callable[[FloatArray, FloatArray], FloatArray]

RAMP, TOP, RAMP_HEIGHT = 1.74, 1.16, 0.30
"""Length of each ramp, of the top between them, and its height [m]: 9.8 degrees."""
TREAD, RISER, STAIRS, LANDING = 0.30, 0.15, 4, 2.4
"""Depth and height of a stair [m], their number, and the depth of the landing above them [m]."""
SPIRAL_RADIUS, SPIRAL_ANGLE, SPIRAL_RISE, SPIRAL_STAIRS = 3.0, 0.24, 0.18, 18
"""Middle of the spiral staircase [m], angle [rad] and height [m] of a stair, number of stairs."""
EARTH, STONE, WOOD, WATER, GRASS = (
    (0.50, 0.48, 0.44),
    (0.56, 0.55, 0.52),
    (0.55, 0.42, 0.29),
    (0.16, 0.31, 0.40),
    (0.33, 0.42, 0.24),
)


@dataclass(frozen=True, kw_only=True)
class Surface:
    """One polygon mesh; its faces are planar."""

    name: str
    points: FloatArray
    """Vertices [m], shape (N, 3)."""
    counts: NDArray[np.int64]
    """Vertices of each face, shape (F,)."""
    indices: NDArray[np.int64]
    """Faces one after the other, counter-clockwise from outside."""
    colours: FloatArray
    """Linear RGB, one or one a face, shape (1 or F, 3)."""
    walkable: bool = True

    def triangles(self) -> FloatArray:
        """Corners of a fan of triangles of every face, shape (T, 3, 3)."""
        starts = np.concatenate([[0], np.cumsum(self.counts)])
        fans = [
            (self.indices[start], self.indices[start + k], self.indices[start + k + 1])
            for start, count in zip(starts, self.counts, strict=False)
            for k in range(1, count - 1)
        ]
        return self.points[np.array(fans)]

    def face_normals(self) -> FloatArray:
        """Unit normal of each face, shape (F, 3)."""
        starts = np.cumsum(self.counts) - self.counts
        first, second, third = (self.points[self.indices[starts + k]] for k in range(3))
        normals = np.cross(second - first, third - first)
        return normals / np.linalg.norm(normals, axis=1, keepdims=True)

    def placed(self, offset: Sequence[float], yaw: float = 0.0) -> "Surface":
        """The surface turned by `yaw` [rad] about +Y and moved by `offset` [m]."""
        return replace(self, points=self.points @ about_y(yaw).T + np.asarray(offset))


def flat(size: float = 30.0, tile: float = 1.0) -> Surface:
    """A square of tiles in two tones around the origin."""
    count = round(size / tile)
    shade = np.indices((count, count)).sum(axis=0).ravel() % 2
    colours = np.array(EARTH) * np.where(shade, 1.0, 0.93)[:, None]
    return _grid("Ground", np.linspace(-size / 2, size / 2, count + 1), lambda x, z: np.zeros_like(x), colours)


def slope(width: float = 2.0) -> Surface:
    """A ramp up along +Z from the origin, a top, and a ramp down."""
    profile = [(0.0, 0.0), (RAMP, RAMP_HEIGHT), (RAMP + TOP, RAMP_HEIGHT), (2 * RAMP + TOP, 0.0)]
    return _extrusion("Slope", profile, width, WOOD)


def stairs(width: float = 1.8) -> Surface:
    """Stairs up along +Z from the origin, and the landing above them."""
    profile = [(0.0, 0.0)]
    for number in range(STAIRS):
        profile += [(number * TREAD, (number + 1) * RISER), ((number + 1) * TREAD, (number + 1) * RISER)]
    end = STAIRS * TREAD + LANDING
    profile[-1] = (end, STAIRS * RISER)
    return _extrusion("Stairs", [*profile, (end, 0.0)], width, STONE)


def spiral_stairs(width: float = 1.6) -> Surface:
    """Wedges up to the left around the axis at x = SPIRAL_RADIUS, from the origin on; the last is thrice as deep."""
    radius, angle, count = SPIRAL_RADIUS, SPIRAL_ANGLE, SPIRAL_STAIRS
    points: list[tuple[float, float, float]] = []
    indices: list[int] = []
    shades: list[float] = []
    for stair in range(count):
        for part in range(3 if stair == count - 1 else 1):
            ends = angle * (stair + part) + np.array([0.0, angle])
            corners = [
                (radius - reach * np.cos(end), reach * np.sin(end))
                for end, reach in zip(ends.repeat(2), np.tile([radius - width / 2, radius + width / 2], 2), strict=True)
            ]
            start = len(points)
            points += [(x, height, z) for height in (0.0, SPIRAL_RISE * (stair + 1)) for x, z in corners]
            faces = [(4, 5, 7, 6), (0, 2, 3, 1), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
            indices += [start + index for face in faces for index in face]
            shades += [1.0 - 0.08 * (stair % 2), 0.6, 0.8, 0.8, 0.85, 0.85]
    return Surface(
        name="SpiralStairs",
        points=np.array(points),
        counts=np.full(len(shades), 4),
        indices=np.array(indices),
        colours=np.array(STONE) * np.array(shades)[:, None],
    )


def hills(size: float = 16.0, cell: float = 0.32) -> Surface:
    """A smooth patch around the origin with slopes of at most some 12 degrees; faces are triangles."""
    waves = ((0.26, 0.40, 0.25, 0.4), (0.14, -0.36, 0.60, 1.9), (0.05, 0.95, 0.30, 3.1), (0.02, 0.30, -1.20, 5.0))

    def height(x: FloatArray, z: FloatArray) -> FloatArray:
        rises = [tall * np.sin(across * x + along * z + phase) for tall, across, along, phase in waves]
        return np.sum(rises, axis=0)

    axis = np.linspace(-size / 2, size / 2, round(size / cell) + 1)
    surface = _grid("Hills", axis, height, np.array([GRASS]), triangles=True)
    middle = surface.triangles().mean(axis=1)[:, 1]
    tone = 0.85 + 0.3 * (middle - middle.min()) / np.ptp(middle)
    return replace(surface, colours=np.array(GRASS) * tone[:, None])


def stone(
    name: str, centre: Sequence[float], *, yaw: float, radius: float, squash: float, top: float, bottom: float
) -> Surface:
    """A stepping stone: an eight-sided column with a level top."""
    angles = np.radians(22.5 + 45.0 * np.arange(8))
    ragged = 1.0 + 0.05 * np.sin(3.0 * angles + 7.0 * yaw + radius * 50.0)
    rim = np.stack([np.sin(angles) * radius * squash * ragged, np.zeros(8), np.cos(angles) * radius * ragged], axis=1)
    points = np.concatenate([rim * [1.12, 0, 1.12] + [0, bottom, 0], rim + [0, top, 0]])
    sides = [index for k in range(8) for index in (k, (k + 1) % 8, 8 + (k + 1) % 8, 8 + k)]
    indices = [*sides, *range(8, 16), *range(7, -1, -1)]
    shade = np.array(STONE) * (0.92 + 0.12 * np.sin(radius * 90.0 + yaw * 5.0))
    colours = np.concatenate([np.tile(shade * 0.8, (8, 1)), [shade, shade * 0.5]])
    whole = Surface(
        name=name, points=points, counts=np.array([4] * 8 + [8, 8]), indices=np.array(indices), colours=colours
    )
    return whole.placed([centre[0], 0.0, centre[1]], yaw)


def bed(centre: Sequence[float], size: Sequence[float], height: float) -> Surface:
    """The water below the stones: nothing to stand on."""
    x, z = np.asarray(size) / 2
    points = np.array([[-x, 0, -z], [-x, 0, z], [x, 0, z], [x, 0, -z]]) + [centre[0], height, centre[1]]
    return Surface(
        name="Water",
        points=points,
        counts=np.array([4]),
        indices=np.arange(4),
        colours=np.array([WATER]),
        walkable=False,
    )


def ground_under(surfaces: Sequence[Surface], places: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Height [m], shape (N,), and unit normal, shape (N, 3), of the highest surface at `places` (x, z), shape (N, 2).

    Raises:
        ValueError: if there is nothing under a place.
    """
    corners = np.concatenate([surface.triangles() for surface in surfaces])
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    upward = normals[:, 1] > 1e-9
    corners, normals = corners[upward], normals[upward]
    flat_corners = corners[:, :, [0, 2]]
    inside = np.ones((len(places), len(corners)), dtype=bool)
    for k in range(3):
        edge = flat_corners[:, (k + 1) % 3] - flat_corners[:, k]
        offset = places[:, None] - flat_corners[None, :, k]
        inside &= edge[None, :, 1] * offset[..., 0] - edge[None, :, 0] * offset[..., 1] >= -1e-9
    away = places[:, None] - flat_corners[None, :, 0]
    heights = corners[None, :, 0, 1] - np.einsum("ntc,tc->nt", away, normals[:, [0, 2]]) / normals[None, :, 1]
    heights = np.where(inside, heights, -np.inf)
    best = heights.argmax(axis=1)
    found = heights[np.arange(len(places)), best]
    if not np.isfinite(found).all():
        raise ValueError(f"no ground under {places[~np.isfinite(found)].round(2).tolist()}")
    unit = normals[best] / np.linalg.norm(normals[best], axis=1, keepdims=True)
    return found, unit


def _grid(name: str, axis: FloatArray, height: Height, colours: FloatArray, *, triangles: bool = False) -> Surface:
    """A height field over `axis` x `axis`."""
    count = len(axis)
    x, z = np.meshgrid(axis, axis, indexing="ij")
    points = np.stack([x.ravel(), height(x, z).ravel(), z.ravel()], axis=1)
    number = np.arange(count * count).reshape(count, count)
    a, b, c, d = number[:-1, :-1].ravel(), number[:-1, 1:].ravel(), number[1:, 1:].ravel(), number[1:, :-1].ravel()
    faces = np.stack([a, b, c, a, c, d], axis=1).reshape(-1, 3) if triangles else np.stack([a, b, c, d], axis=1)
    return Surface(
        name=name, points=points, counts=np.full(len(faces), faces.shape[1]), indices=faces.ravel(), colours=colours
    )


def _extrusion(
    name: str, profile: Sequence[tuple[float, float]], width: float, colour: tuple[float, float, float]
) -> Surface:
    """A closed body of convex faces: the profile (z, y) along x, walls below it, a level floor at y = 0."""
    faces, shades = [], []
    x = width / 2
    for (near, low), (far, high) in pairwise(profile):
        faces.append([(-x, low, near), (-x, high, far), (x, high, far), (x, low, near)])
        shades.append(1.0 if far > near else 0.8)
        if far > near:
            wall = [(low, near), (0.0, near), (0.0, far), (high, far)]
            faces.append([(-x, 0.0, near), (x, 0.0, near), (x, 0.0, far), (-x, 0.0, far)])
            faces.append([(-x, y, z) for y, z in dict.fromkeys(wall)])
            faces.append([(x, y, z) for y, z in dict.fromkeys(wall[::-1])])
            shades += [0.6, 0.85, 0.85]
    points = list(dict.fromkeys(point for face in faces for point in face))
    return Surface(
        name=name,
        points=np.array(points),
        counts=np.array([len(face) for face in faces]),
        indices=np.array([points.index(point) for face in faces for point in face]),
        colours=np.array(colour) * np.array(shades)[:, None],
    )
