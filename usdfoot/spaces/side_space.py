"""The space of one style, kind of gait and swing side: its examples by landing, by features and by root velocity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.spaces.footsteps import FootstepSpace, build_footstep_space
from usdfoot.spaces.neighbours import NeighbourSpace, build_neighbour_space, solve_neighbours
from usdfoot.spaces.root_velocity import RootVelocitySpace, build_root_velocity_space
from usdfoot.spaces.tetrahedra import TetrahedronSpace, build_tetrahedron_space

__all__ = ["SideSpace", "blend_doubts", "build_side_space"]


@dataclass(frozen=True, kw_only=True)
class SideSpace:
    """The space of one style, gait and swing side, in left-swing coordinates; its examples count from 0."""

    footsteps: FootstepSpace
    """Examples by landing."""
    neighbours: NeighbourSpace
    """Examples by landing and features."""
    roots: RootVelocitySpace
    """Examples by root velocity."""
    tetrahedra: TetrahedronSpace
    """Examples by landing and root speed."""
    examples: IntArray
    """Index into the library's examples of each example of the space, shape (E',)."""


def build_side_space(
    members: IntArray,
    *,
    landings: FloatArray,
    coordinates: FloatArray,
    velocities: FloatArray,
    polar: bool,
    root_merge_distance: float,
) -> SideSpace:
    """The space of some examples of a library.

    Args:
        members: The examples, E' of the library's E.
        landings: Of all in left-swing coordinates, (x, z) [m], shape (E, 2).
        coordinates: Their scaled landings and features, likewise, shape (E, D).
        velocities: Their root velocities, likewise, (x, z) [m/s], shape (E, 2).
        polar: Root velocities are weighted by polar gradient bands; else by Cartesian ones.
        root_merge_distance: Root velocities at most this far apart [m/s] share one example.
    """
    own, speeds = landings[members], np.linalg.norm(velocities[members], axis=1)
    footsteps = build_footstep_space(own)
    return SideSpace(
        footsteps=footsteps,
        neighbours=build_neighbour_space(footsteps, own, coordinates[members]),
        roots=build_root_velocity_space(velocities[members], polar=polar, merge_distance=root_merge_distance),
        tetrahedra=build_tetrahedron_space(footsteps, own, speeds),
        examples=members,
    )


def blend_doubts(landings: FloatArray, coordinates: FloatArray, synthetic: BoolArray) -> FloatArray:
    """How far off the recorded examples are that would be blended into each synthetic one, scaled, shape (E',).

    To any wanted step the mean square distance of examples is that of their mean and their own spread about it. With
    the spread a blend seems no nearer than what it is blended from.
    """
    doubts = np.zeros(len(landings))
    recorded, made = np.flatnonzero(~synthetic), np.flatnonzero(synthetic)
    if recorded.size and made.size:
        known = build_neighbour_space(
            build_footstep_space(landings[recorded]), landings[recorded], coordinates[recorded]
        )
        solved = solve_neighbours(known, landings[made], coordinates[made])
        apart = coordinates[recorded[solved.examples]] - coordinates[made, None]
        doubts[made] = np.sqrt(np.sum(solved.weights * np.sum(apart**2, axis=-1), axis=1))
    return doubts
