"""Holes: landings that no example of a library is near, inside the hull and in directions nobody stepped."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.errors import UsdfootError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import LEFT, RIGHT
from usdfoot.spaces.footsteps import build_footstep_space, solve_footsteps
from usdfoot.spaces.library import FootstepSpaces
from usdfoot.spaces.side_space import SideSpace
from usdfoot.spaces.triangulation import signed_areas

__all__ = ["Hole", "HoleOptions", "find_holes", "triangle_gaps"]


@dataclass(frozen=True, kw_only=True)
class HoleOptions:
    """What counts as a hole.

    Raises:
        UsdfootError: If an option is not possible.
    """

    gap: float = 0.2
    """Longest altitude of a triangle of landings that needs no step of its own, and twice the distance from the hull at
    which a landing needs none [m]."""
    most: int = 40
    """Most holes of one style, gait and side."""

    def __post_init__(self) -> None:
        if not 0.02 <= self.gap < np.inf:
            raise UsdfootError("gap", f"is {self.gap:g} m", "0.02 m or more is possible")
        if self.most < 1:
            raise UsdfootError("most", f"is {self.most}", "1 or more is possible")


@dataclass(frozen=True, kw_only=True)
class Hole:
    """A landing without examples."""

    style: str
    flight: bool
    """Whether it belongs to runs."""
    side: int
    """Foot that swings, 0 = left, 1 = right."""
    mirrored: bool
    """Whether the other foot's space is its mirror image, so that a step and its image fill both."""
    landing: FloatArray
    """From the support ball in the heading at the step's end, as if the left foot swung, (x, z) [m], shape (2,)."""


def find_holes(spaces: FootstepSpaces, outline: FloatArray, options: HoleOptions | None = None) -> list[Hole]:
    """Holes of all spaces of a library, one after the other where each leaves the largest gap.

    Inside the hull a hole is the middle of the triangle with the longest altitude, as far as that exceeds the gap: so
    far apart are the steps that are blended there. Outside, it is the landing farthest from the hull of those that
    walking legs reach. Each hole counts as filled when the next is looked for.

    Args:
        spaces: Of the library.
        outline: Landings that the legs reach without a flight, in left-swing coordinates: convex, counter-clockwise
            with x to the right and z up [m], shape (K, 2).
        options: What a hole is.
    """
    options = options or HoleOptions()
    holes: list[Hole] = []
    for (style, flight, side), space in spaces.spaces.items():
        other = spaces.spaces.get((style, flight, LEFT if side == RIGHT else RIGHT))
        mirrored = other is not None and other.footsteps is space.footsteps
        if mirrored and side == RIGHT:
            continue
        wanted = np.zeros((0, 2)) if flight else _lattice(outline, 0.5 * options.gap)
        holes += [
            Hole(style=style, flight=flight, side=side, mirrored=mirrored, landing=landing)
            for landing in _holes_of(space, wanted, options)
        ]
    return holes


def triangle_gaps(vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """Longest altitude of each triangle [m], shape (T,)."""
    corners = vertices[triangles]
    areas = np.abs(signed_areas(corners, corners[:, 0]).sum(axis=1))
    return areas / np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).min(axis=1)


def _holes_of(space: SideSpace, wanted: FloatArray, options: HoleOptions) -> FloatArray:
    """Landings to be filled, shape (H, 2)."""
    known = space.footsteps.vertices
    count = len(known)
    while len(known) < count + options.most:
        landing = _largest_hole(known, wanted, options.gap)
        if landing is None:
            break
        known = np.vstack([known, landing])
    return known[count:]


def _largest_hole(landings: FloatArray, wanted: FloatArray, gap: float) -> FloatArray | None:
    """The next hole among landings (V, 2), those inside the hull first; None if no gap is too large."""
    space = build_footstep_space(landings)
    if len(space.triangles):
        gaps = triangle_gaps(space.vertices, space.triangles)
        if gaps.max() > gap:
            return np.asarray(space.vertices[space.triangles[np.argmax(gaps)]].mean(axis=0))
    if len(wanted):
        distances = solve_footsteps(space, wanted).hull_distances
        if distances.max() > 0.5 * gap:
            return np.asarray(wanted[np.argmax(distances)])
    return None


def _lattice(outline: FloatArray, spacing: float) -> FloatArray:
    """Points of a square lattice within a convex outline, shape (L, 2)."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    axes = [
        np.arange(np.ceil(a / spacing), np.floor(b / spacing) + 1) * spacing for a, b in zip(low, high, strict=True)
    ]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return points[_inside(outline, points)]


def _inside(outline: FloatArray, points: FloatArray) -> BoolArray:
    edges = np.roll(outline, -1, axis=0) - outline
    apart = points[:, None] - outline
    return np.all(edges[:, 0] * apart[..., 1] - edges[:, 1] * apart[..., 0] >= 0.0, axis=1)
