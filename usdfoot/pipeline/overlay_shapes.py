"""Shapes of an overlay's marks: prints, columns, bars and webs, one metre large or one metre long."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.overlay import Shape
from usdfoot.writers.prints import print_outline

__all__ = ["bar", "column", "footprint", "web"]

SIDES_OF_COLUMN = 16
BOX_CORNERS = np.array([[x, y, z] for x in (0.0, 1.0) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
BOX_FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


def footprint(name: str, side: int, color: tuple[float, float, float]) -> Shape:
    """A print with the ball one metre from the ankle, flat on the ground."""
    points = print_outline(side, 1.0) * (1.0, 0.0, 1.0)
    count = len(points)
    return Shape(name=name, points=points, counts=np.array([count]), indices=np.arange(count), color=color)


def column(name: str, color: tuple[float, float, float]) -> Shape:
    """An upright cylinder of radius and height one, standing on the ground."""
    angles = np.arange(SIDES_OF_COLUMN) * (2.0 * np.pi / SIDES_OF_COLUMN)
    ring = np.stack([np.sin(angles), np.zeros_like(angles), np.cos(angles)], axis=1)
    around = np.arange(SIDES_OF_COLUMN)
    after = np.roll(around, -1)
    walls = np.stack([around, after, after + SIDES_OF_COLUMN, around + SIDES_OF_COLUMN], axis=1)
    caps = np.concatenate([around[::-1], around + SIDES_OF_COLUMN])
    return Shape(
        name=name,
        points=np.concatenate([ring, ring + (0.0, 1.0, 0.0)]),
        counts=np.array([4] * SIDES_OF_COLUMN + [SIDES_OF_COLUMN] * 2),
        indices=np.concatenate([walls.ravel(), caps]),
        color=color,
    )


def bar(name: str, color: tuple[float, float, float]) -> Shape:
    """A box along +X from the origin, one long and one thick."""
    return Shape(
        name=name,
        points=BOX_CORNERS,
        counts=np.full(len(BOX_FACES), 4),
        indices=np.array(BOX_FACES).ravel(),
        color=color,
    )


def web(
    name: str, vertices: FloatArray, edges: IntArray, *, color: tuple[float, float, float], width: float, dot: float
) -> Shape:
    """Flat ribbons along edges, and a square on each vertex.

    Args:
        name: Of the shape.
        vertices: On the ground, (x, z) [m], shape (V, 2).
        edges: Vertices that a ribbon joins, shape (E, 2).
        color: Linear RGB.
        width: Of the ribbons [m].
        dot: Of the squares [m].
    """
    starts, ends = vertices[edges[:, 0]], vertices[edges[:, 1]]
    along = ends - starts
    along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
    across = 0.5 * width * np.stack([along[:, 1], -along[:, 0]], axis=1)
    ribbons = np.stack([starts - across, ends - across, ends + across, starts + across], axis=1)
    square = 0.5 * dot * np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]])
    corners = np.concatenate([ribbons, vertices[:, None] + square]).reshape(-1, 2)
    count = len(corners) // 4
    return Shape(
        name=name,
        points=np.insert(corners, 1, 0.0, axis=1),
        counts=np.full(count, 4),
        indices=np.arange(4 * count),
        color=color,
    )
