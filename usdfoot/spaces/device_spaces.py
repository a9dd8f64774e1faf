"""Footstep spaces as device arrays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.device import start_warp
from usdfoot.spaces.corner_kernel import SpaceArrays
from usdfoot.spaces.root_choice_kernel import VelocityArrays
from usdfoot.spaces.root_velocity import device_bands
from usdfoot.spaces.side_space import SideSpace
from usdfoot.spaces.tetrahedra import SPEED_SCALE, device_solids

__all__ = ["device_spaces", "device_velocities"]


def device_spaces(
    spaces: Sequence[SideSpace], *, landings: FloatArray, velocities: FloatArray, coordinates: FloatArray
) -> SpaceArrays:
    """All spaces of a library end to end.

    Args:
        spaces: Of each style, gait and swing side.
        landings: Of all the library's examples in left-swing coordinates, (x, z) [m], shape (E, 2).
        velocities: Their root velocities, likewise, (x, z) [m/s], shape (E, 2).
        coordinates: What neighbours are chosen by, shape (E, D).
    """
    start_warp()
    neighbours, triangles, edges = [], [], []
    for space in spaces:
        own, footsteps = space.examples, space.footsteps
        vertices = own[footsteps.members[:, 0]]
        neighbours.append(own[space.neighbours.examples])
        triangles.append(vertices[footsteps.triangles])
        edges.append(vertices[footsteps.edges[:, [0, 1, 1]]])
    members = np.concatenate(neighbours)
    arrays = SpaceArrays()
    arrays.landings = wp.array(landings, dtype=wp.vec2d)
    arrays.neighbour_begins = _begins(neighbours)
    arrays.neighbours = wp.array(members, dtype=wp.int32)
    arrays.neighbour_landings = wp.array(landings[members], dtype=wp.vec2d)
    arrays.coordinates = wp.array(coordinates[members], dtype=wp.float64)
    arrays.triangle_begins, arrays.triangles = _begins(triangles), _triples(triangles)
    arrays.edge_begins, arrays.edges = _begins(edges), _triples(edges)
    known = np.column_stack([landings, SPEED_SCALE * np.linalg.norm(velocities, axis=1)])
    solids = [space.tetrahedra for space in spaces]
    arrays.solids = device_solids(solids, [space.examples for space in spaces], known)
    return arrays


def device_velocities(
    spaces: Sequence[SideSpace], *, velocities: FloatArray, coordinates: FloatArray
) -> list[VelocityArrays]:
    """The vertices of each space's root velocities, members among all examples; arguments as of `device_spaces`."""
    start_warp()
    examples = wp.array(velocities, dtype=wp.vec2d)
    known = wp.array(coordinates, dtype=wp.float64)
    found = []
    for space in spaces:
        roots, arrays = space.roots, VelocityArrays()
        members = np.where(roots.members >= 0, space.examples[roots.members], -1)
        arrays.velocities = wp.array(roots.velocities[roots.vertices], dtype=wp.vec2d)
        arrays.members = wp.array(members, dtype=wp.int32)
        arrays.triangles = wp.array(roots.triangles.reshape(-1, 3), dtype=wp.vec3i)
        arrays.edges = wp.array(roots.edges[:, [0, 1, 1]], dtype=wp.vec3i)
        arrays.bands = device_bands(roots)
        arrays.example_velocities, arrays.example_coordinates = examples, known
        found.append(arrays)
    return found


def _begins(parts: Sequence[IntArray]) -> wp.array:
    return wp.array(np.cumsum([0, *map(len, parts)]), dtype=wp.int32)


def _triples(parts: Sequence[IntArray]) -> wp.array:
    return wp.array(np.concatenate(parts).reshape(-1, 3), dtype=wp.vec3i)
