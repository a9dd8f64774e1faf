"""RootVelocitySpace: examples by their root velocity, and gradient band weights for any velocity ([B] 5, Johansen)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.device import start_warp
from usdfoot.spaces.gradient_band_kernel import BandArrays, find_influences
from usdfoot.spaces.triangulation import boundary_edges, merge_points, polyline, triangulate

__all__ = [
    "RootVelocitySpace",
    "RootVelocityWeights",
    "build_root_velocity_space",
    "device_bands",
    "solve_root_velocities",
]

ANGLE_SCALE = 2.0
"""How much a turn of one radian counts against a relative change of speed by one (Johansen's alpha)."""


@dataclass(frozen=True, kw_only=True)
class RootVelocitySpace:
    """K examples, V of which stand for all.

    The influence of vertex i against vertex j is linear in the query's speed and bearing (polar) or in the query itself
    (Cartesian): a band. Each vertex has V - 1 of them, the nearest vertex's first.
    """

    velocities: FloatArray
    """Root velocity of every example, (x, z) [m/s], shape (K, 2)."""
    vertices: IntArray
    """Examples that take part; the others lie within the merge distance of one of these, shape (V,)."""
    members: IntArray
    """Examples each vertex stands for, its own first, padded with -1, shape (V, most)."""
    polar: bool
    """Bands over bearing and speed; else over x and z."""
    constants: FloatArray
    """Shape (V, V - 1)."""
    slopes: FloatArray
    """Per radian and per m/s (polar), or per m/s along x and z, shape (2, V, V - 1)."""
    bearings: FloatArray
    """A quarter turn beyond the middle of each pair's bearings [rad], -pi..pi, shape (V, V - 1); polar only."""
    triangles: IntArray
    """Vertices of the Delaunay triangles of the velocities, none if these are in line, shape (T, 3)."""
    edges: IntArray
    """Vertices of the edges of their hull, shape (H, 2)."""
    slowest: float
    """Speed of the slowest example that moves [m/s]; below half of it the bearing counts less and less."""


@dataclass(frozen=True, kw_only=True)
class RootVelocityWeights:
    """Blend weights of K examples for N velocities, and how well they meet them."""

    weights: FloatArray
    """Not negative, sum 1, shape (N, K)."""
    velocities: FloatArray
    """Weighted mean of the examples' velocities, (x, z) [m/s], shape (N, 2)."""
    errors: FloatArray
    """Distance of that mean from the query [m/s], shape (N,)."""


def build_root_velocity_space(
    velocities: FloatArray, *, polar: bool = True, merge_distance: float = 0.05, still_speed: float = 0.02
) -> RootVelocitySpace:
    """The parametric space of root velocities.

    Args:
        velocities: Root velocity of each example, (x, z) [m/s], shape (K, 2), K >= 1.
        polar: Bands over bearing and speed, as [B] has them; else Cartesian ones.
        merge_distance: Velocities at most this far apart [m/s] share one example, as the weight would jump from one
            to the other between them.
        still_speed: Examples no faster than this [m/s] stand, all with one vertex; their bearing does not count.
    """
    velocities = np.asarray(velocities, dtype=float)
    speeds = np.linalg.norm(velocities, axis=1)
    moving = speeds > still_speed
    placed = np.where(moving[:, None], velocities, 0.0)
    vertices, members = merge_points(placed, merge_distance)
    constants, slopes, bearings = (_polar_tables if polar else _cartesian_tables)(placed[vertices])
    distances = np.linalg.norm(placed[vertices] - placed[vertices, None], axis=-1)
    edges = polyline(placed[vertices], 0.0)
    triangles = triangulate(placed[vertices]) if edges is None else np.empty((0, 3), dtype=np.intp)
    np.fill_diagonal(distances, -1.0)
    order = np.argsort(distances, axis=1, kind="stable")[:, 1:]
    return RootVelocitySpace(
        velocities=velocities,
        vertices=vertices,
        members=members,
        polar=polar,
        constants=np.take_along_axis(constants, order, axis=1),
        slopes=np.take_along_axis(slopes, order[None], axis=2),
        bearings=np.take_along_axis(bearings, order, axis=1),
        triangles=triangles,
        edges=boundary_edges(triangles) if edges is None else edges,
        slowest=float(speeds[moving].min(initial=np.inf)),
    )


def solve_root_velocities(space: RootVelocitySpace, queries: FloatArray) -> RootVelocityWeights:
    """Gradient band weights: h_i = min over j of [1 - <d(v), d_ij> / |d_ij|^2], clipped at 0, over their sum.

    d are pairs (ANGLE_SCALE angle, speed over the mean speed of i and j), or differences in x and z. They are exact at
    the examples and go on without a jump everywhere, except where every influence is 0: there the nearest example has
    all the weight. The velocity they give is near the query, not equal to it.

    Two things keep the polar bands from jumping. Behind the pair i, j, more than a quarter turn from the middle of
    their bearings, a bearing counts as its mirror image in front; so the weight passes from i to j on the far side
    as well, and for opposite examples both ways round are the same. And below half the slowest speed, where bearings
    lose their meaning, they fade to that middle.

    Args:
        space: From `build_root_velocity_space`.
        queries: Wanted root velocities, (x, z) [m/s], shape (N, 2).
    """
    queries = np.asarray(queries, dtype=float)
    weights = np.zeros((len(queries), len(space.velocities)))
    weights[:, space.vertices] = _vertex_influences(space, queries)
    totals = weights.sum(axis=1)
    lost = np.flatnonzero(totals <= 0.0)
    if lost.size:
        distances = np.linalg.norm(queries[lost, None] - space.velocities[space.vertices], axis=-1)
        weights[lost, space.vertices[np.argmin(distances, axis=1)]] = 1.0
        totals[lost] = 1.0
    weights /= totals[:, None]
    blended = weights @ space.velocities
    return RootVelocityWeights(weights=weights, velocities=blended, errors=np.linalg.norm(blended - queries, axis=1))


def _vertex_influences(space: RootVelocitySpace, queries: FloatArray) -> FloatArray:
    """H of every vertex, not normalised, shape (N, V)."""
    bands = device_bands(space)
    influences = wp.empty((len(queries), len(space.vertices)), dtype=wp.float64)
    inputs = [bands, wp.array(queries, dtype=wp.vec2d)]
    wp.launch(find_influences, dim=len(queries), inputs=inputs, outputs=[influences])
    return influences.numpy()


def device_bands(space: RootVelocitySpace) -> BandArrays:
    """The bands as device arrays."""
    start_warp()
    bands = BandArrays()
    bands.constants = wp.array(space.constants, dtype=wp.float64)
    bands.slopes = wp.array(space.slopes, dtype=wp.float64)
    bands.bearings = wp.array(space.bearings, dtype=wp.float64)
    bands.polar, bands.slowest = space.polar, space.slowest
    return bands


def _polar_tables(velocities: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Constants, slopes and bearings of pairs of vertices (V, 2); the angle is dropped where one of them stands."""
    speeds, yaws = np.linalg.norm(velocities, axis=1), planar.yaw_of(velocities)
    angles = planar.wrap_angle(yaws - yaws[:, None])  # from i (rows) to j (columns)
    moving = speeds > 0.0
    scaled = np.where(moving & moving[:, None], ANGLE_SCALE * angles, 0.0)
    means = 0.5 * (speeds + speeds[:, None])
    means[means == 0.0] = 1.0
    differences = (speeds - speeds[:, None]) / means
    squares = scaled**2 + differences**2
    squares[squares == 0.0] = 1.0
    by_angle = -ANGLE_SCALE * scaled / squares
    by_speed = -differences / means / squares
    constants = 1.0 - 0.5 * scaled**2 / squares - by_speed * speeds[:, None]
    middles = yaws[:, None] + 0.5 * angles
    return constants, np.stack([by_angle, by_speed]), planar.wrap_angle(middles + 0.5 * np.pi)


def _cartesian_tables(velocities: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    differences = velocities - velocities[:, None]  # from i (rows) to j (columns)
    squares = np.sum(differences**2, axis=-1)
    squares[squares == 0.0] = 1.0
    slopes = -differences / squares[..., None]
    constants = 1.0 - np.sum(slopes * velocities[:, None], axis=-1)
    return constants, np.moveaxis(slopes, -1, 0), np.zeros_like(constants)
