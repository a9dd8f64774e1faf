"""Crossing graph: which footholds are within a step of which, and the best ways over them, turns and all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.device import start_warp
from usdfoot.planning.crossing_kernel import Footing, Searches, StepRules, find_ways
from usdfoot.planning.crossings import Stance, Stones
from usdfoot.planning.reach import Reach

__all__ = ["HEADINGS", "ROUNDED", "CrossingGraph", "Way", "build_graph"]

HEADINGS = 24
"""Headings the search tells apart."""
ROUNDED = 1e-9
"""Feet one behind the other do not cross [m]."""
TURNED = 1e-9
"""Turns may be larger than the largest by rounding [rad]."""
EAGER = 1.4
"""How much what is ahead counts in the search for some way, which bounds what the best one costs."""
MOST_NODES = 4_000_000
"""Of all searches at once at most, for memory's sake."""


@dataclass(frozen=True, kw_only=True)
class Way:
    """The best way of one search, S steps from its start to its goal."""

    positions: FloatArray
    """Of all places: two of the start, two of the goal, N footholds [m], shape (4 + N, 3)."""
    yaws: FloatArray
    """Of all headings [rad], from the start's on, shape (K,)."""
    places: IntArray
    """Stood on one after the other, shape (S + 1,); none where no way leads to the goal."""
    sides: IntArray
    """Of the feet there, shape (S + 1,)."""
    headings: IntArray
    """Shape (S + 1,)."""
    cost: float
    """Of the way, infinite where there is none."""
    reached: BoolArray
    """Whether a way leads there, of places looked at before the goal, shape (4 + N,)."""


@dataclass(frozen=True, kw_only=True)
class CrossingGraph:
    """N footholds and which of them are within a step of each other, for any number of searches."""

    stones: Stones
    reach: Reach
    first: IntArray
    """First of each foothold's neighbours, shape (N + 1,)."""
    beside: IntArray
    """Neighbours of all, those of each by their bearing, shape (E,)."""
    offsets: FloatArray
    """To them [m], shape (E, 3)."""
    least: FloatArray
    """What a step there costs at least, shape (E,)."""

    def search(self, starts: Sequence[Stance], goals: Sequence[Stance]) -> list[Way]:
        """The best ways from stances to stances, M of each: a turn, then a step.

        A* over (place, foot, heading), led by what the steps to the goal cost at least: too much at first, for some way
        soon, then among those that cost no more.
        """
        nodes = 2 * HEADINGS * (4 + len(self.stones.positions))
        parts = -(-len(starts) * nodes // MOST_NODES)
        rows = np.array_split(np.arange(len(starts)), parts) if len(starts) else []
        return [
            way
            for own in rows
            for way in self._search_some([starts[int(row)] for row in own], [goals[int(row)] for row in own])
        ]

    def _search_some(self, starts: Sequence[Stance], goals: Sequence[Stance]) -> list[Way]:
        count, nodes = len(starts), 2 * HEADINGS * (4 + len(self.stones.positions))
        stances = np.stack([np.stack([stance.positions for stance in ends]) for ends in (starts, goals)], axis=1)
        stances = stances.reshape(count, 4, 3)
        yaws, goal_headings = _headings(starts, goals)
        start_warp()
        footing: Any = Footing()
        for name, values, dtype in (
            ("stances", stances, wp.vec3d),
            ("stones", self.stones.positions, wp.vec3d),
            ("discomforts", self.stones.costs, wp.float64),
            ("first", self.first.astype(np.int32), wp.int32),
            ("beside", self.beside.astype(np.int32), wp.int32),
            ("offsets", self.offsets, wp.vec3d),
            ("least", self.least, wp.float64),
            *_turn_tables(yaws, self.reach),
            ("goal_headings", goal_headings.astype(np.int32), wp.int32),
            ("ahead", self._ahead(stances[:, 2:]), wp.float64),
        ):
            setattr(footing, name, wp.array(values, dtype=dtype, device="cpu"))
        searches = _begin((count, nodes))
        arrived = _find(footing, _rules(self.reach), searches)
        found = zip(stances, yaws, searches.costs.numpy(), searches.before.numpy(), arrived, strict=True)
        return [self._way(*own) for own in found]

    def _ahead(self, goals: FloatArray) -> FloatArray:
        """What the steps from each foothold to each goal (M, 2, 3) cost at least, 0 where there is no way, (M, N)."""
        places, count = self.stones.positions, len(goals)
        tree = cKDTree(places[:, [0, 2]])
        near = tree.query_ball_point(goals[:, :, [0, 2]].reshape(-1, 2), self.reach.farthest)
        owners = np.repeat(np.arange(2 * count), [len(own) for own in near])
        stones = np.array([stone for own in near for stone in own], dtype=np.intp)
        costs = _least_costs(goals.reshape(-1, 3)[owners] - places[stones], self.reach)
        rows = np.full((count, len(places)), np.inf)
        np.minimum.at(rows, (owners // 2, stones), costs)
        goal, stone = np.nonzero(np.isfinite(rows))
        size = len(places) + count
        entries = np.concatenate([self.least, rows[goal, stone]])
        froms = np.repeat(np.arange(len(places)), np.diff(self.first))
        pairs = np.concatenate([self.beside, len(places) + goal]), np.concatenate([froms, stone])
        links = csr_array((entries, pairs), shape=(size, size))
        found = dijkstra(links, indices=len(places) + np.arange(count))[:, : len(places)]
        return np.where(np.isfinite(found), found, 0.0)

    def _way(self, stances: FloatArray, yaws: FloatArray, costs: FloatArray, before: IntArray, arrived: int) -> Way:
        """The way to a node, from what a search found of all nodes."""
        nodes = []
        while arrived >= 0:
            nodes.append(arrived)
            arrived = int(before[arrived])
        standing = np.array(nodes[::-1], dtype=int)
        feet, headings = np.divmod(standing, HEADINGS)
        return Way(
            positions=np.concatenate([stances, self.stones.positions]),
            yaws=yaws,
            places=feet // 2,
            sides=feet % 2,
            headings=headings,
            cost=float(costs[standing[-1]]) if nodes else np.inf,
            reached=np.asarray(np.isfinite(costs).reshape(-1, 2 * HEADINGS).any(axis=1)),
        )


def build_graph(stones: Stones, *, reach: Reach) -> CrossingGraph:
    """The graph of footholds for steps of a reach."""
    tree = cKDTree(stones.positions[:, [0, 2]])
    pairs = tree.query_pairs(reach.farthest, output_type="ndarray").astype(np.intp)
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    offsets = stones.positions[pairs[:, 1]] - stones.positions[pairs[:, 0]]
    least = _least_costs(offsets, reach)
    possible = np.isfinite(least)
    pairs, offsets, least = pairs[possible], offsets[possible], least[possible]
    bearings = planar.yaw_of(offsets[:, [0, 2]])  # those within reach of a heading are beside each other
    order = np.lexsort((pairs[:, 1], bearings, pairs[:, 0]))
    beside = pairs[order, 1]
    return CrossingGraph(
        stones=stones,
        reach=reach,
        first=np.searchsorted(pairs[order, 0], np.arange(len(stones.positions) + 1)),
        beside=beside,
        offsets=offsets[order],
        least=least[order] + stones.costs[beside],
    )


def _least_costs(offsets: FloatArray, reach: Reach) -> FloatArray:
    """What steps by offsets (E, 3) cost at least, whatever the heading, infinite where none is, shape (E,)."""
    lengths = np.hypot(offsets[:, 0], offsets[:, 2])
    longer = lengths - np.linalg.norm(reach.comfortable)
    costs = 1.0 + (longer / reach.spread.max()) ** 2 + (offsets[:, 1] / (0.5 * reach.rise)) ** 2
    possible = (lengths <= reach.farthest * (1.0 + 1e-9)) & (np.abs(offsets[:, 1]) <= reach.rise)
    return np.where(possible, costs * (1.0 - 1e-9), np.inf)


def _headings(starts: Sequence[Stance], goals: Sequence[Stance]) -> tuple[FloatArray, IntArray]:
    """Headings (M, K) [rad] from the starts' on, those nearest to the goals' as these are, and which they are (M,)."""
    begins, ends = (np.array([stance.yaw for stance in stances]) for stances in (starts, goals))
    yaws = begins[:, None] + np.arange(HEADINGS) * (2.0 * np.pi / HEADINGS)
    nearest = np.argmin(np.abs(planar.wrap_angle(yaws - ends[:, None])), axis=1)
    yaws[np.arange(len(yaws)), nearest] = np.where(nearest > 0, ends, begins)
    return yaws, nearest


def _turn_tables(yaws: FloatArray, reach: Reach) -> list[tuple[str, Any, Any]]:
    """What kernels ask of headings (M, K) [rad] and the turns between them, by name with types."""
    turns = planar.wrap_angle(yaws[:, :, None] - yaws[:, None])  # (M, K, K)
    turns = np.where(np.abs(turns) <= reach.turn + TURNED, turns, np.inf)
    most = int(np.isfinite(turns).sum(axis=2).max(initial=1))
    befores = np.argsort(turns, axis=2, kind="stable")[..., :most]
    turns = np.take_along_axis(turns, befores, axis=2)
    midways = planar.direction(yaws[..., None] - 0.5 * np.where(np.isfinite(turns), turns, 0.0))
    return [
        ("forward", planar.direction(yaws), wp.vec2d),
        ("befores", befores.astype(np.int32), wp.int32),
        ("turns", turns, wp.float64),
        ("midways", midways, wp.vec2d),
    ]


def _find(footing: Any, rules: Any, searches: Any) -> IntArray:
    """The nodes at which the best ways of searches arrive, -1 where there is none, shape (M,).

    Searches that are led too strongly find some way soon; those that found one then look for none that costs more.
    """
    arrived = np.full(searches.costs.shape[0], -1, dtype=np.int32)
    rows = np.arange(len(arrived), dtype=np.int32)
    for searches.eagerness in (EAGER, 1.0):
        inputs = [wp.array(values, dtype=wp.int32, device="cpu", copy=False) for values in (rows, arrived)]
        wp.launch(find_ways, dim=len(rows), inputs=[footing, rules, searches, *inputs], device="cpu")
        rows = np.flatnonzero(arrived >= 0).astype(np.int32)
        searches.most.numpy()[rows] = searches.costs.numpy()[rows, arrived[rows]] * (1.0 + 1e-9)
    return arrived


def _begin(shape: tuple[int, int]) -> Any:
    """Room for searches over nodes (M, 2 P K), whose ways may cost anything."""
    searches: Any = Searches()
    searches.costs = wp.empty(shape, dtype=wp.float64, device="cpu")
    searches.keys = wp.empty(shape, dtype=wp.float64, device="cpu")
    for name in ("before", "slots", "heap"):
        setattr(searches, name, wp.empty(shape, dtype=wp.int32, device="cpu"))
    searches.most = wp.full(shape[0], np.inf, dtype=wp.float64, device="cpu")
    return searches


def _rules(reach: Reach) -> Any:
    """What kernels ask of a reach."""
    edges = np.roll(reach.outline, -1, axis=0) - reach.outline
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1)  # outward
    rules: Any = StepRules()
    rules.normals = wp.array(normals, dtype=wp.vec2d, device="cpu")
    rules.rims = wp.array(np.sum(reach.outline * normals, axis=1) + 1e-9, dtype=wp.float64, device="cpu")
    lowest, highest = np.maximum(reach.outline.min(axis=0), (0.0, -np.inf)), reach.outline.max(axis=0)
    rules.lowest, rules.highest = wp.vec2d(*lowest), wp.vec2d(*highest)  # legs do not cross
    rules.comfortable, rules.spread = wp.vec2d(*reach.comfortable), wp.vec2d(*reach.spread)
    rules.rise, rules.turn, rules.apart, rules.rounded = reach.rise, reach.turn, reach.apart, ROUNDED
    return rules
