"""Crossing graph: every step between footholds, and every turn before it, with what it costs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import LEFT, RIGHT
from usdfoot.planning.crossed import apart_midway
from usdfoot.planning.crossings import Stance, Stones
from usdfoot.planning.reach import Reach, step_costs

__all__ = ["HEADINGS", "ROUNDED", "CrossingGraph", "build_graph"]

HEADINGS = 24
"""Headings the search tells apart."""
ROUNDED = 1e-9
"""Feet one behind the other do not cross [m]."""


@dataclass(frozen=True, kw_only=True)
class CrossingGraph:
    """Nodes count (place, foot, heading, layer); places: start stance, goal stance, footholds.

    Layer 0 is before the turn, layer n after one of the n turns into the heading that lead most to the side of the foot
    that swings next.
    """

    positions: FloatArray
    """Of all places [m], shape (P, 3)."""
    yaws: FloatArray
    """Of all headings [rad], shape (K,), from the start's on."""
    goal_heading: int
    layers: int
    edges: csr_array
    """Costs, shape (2 P K L, 2 P K L)."""

    def nodes(self, places: IntArray, sides: IntArray, headings: IntArray) -> IntArray:
        """Nodes before the turn."""
        return ((places * 2 + sides) * len(self.yaws) + headings) * self.layers

    def steps(self, nodes: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """Places, sides and headings of the nodes before a turn."""
        standing = nodes[nodes % self.layers == 0] // self.layers
        headings = standing % len(self.yaws)
        feet = standing // len(self.yaws)
        return feet // 2, feet % 2, headings


def build_graph(stones: Stones, start: Stance, goal: Stance, *, reach: Reach) -> CrossingGraph:
    """The graph of all footholds and the stances; the two of a stance come first, then those of the goal."""
    positions = np.concatenate([start.positions, goal.positions, stones.positions])
    discomforts = np.concatenate([np.zeros(4), stones.costs])
    yaws = start.yaw + np.arange(HEADINGS) * (2.0 * np.pi / HEADINGS)
    goal_heading = int(np.argmin(np.abs(planar.wrap_angle(yaws - goal.yaw))))
    yaws[goal_heading] = goal.yaw if goal_heading else start.yaw
    turns = [[_turns_into(yaws, heading, side, reach) for side in (LEFT, RIGHT)] for heading in range(HEADINGS)]
    layers = 1 + max(len(befores) for both in turns for befores, _ in both)
    rows, columns, costs = (
        np.concatenate(part)
        for part in zip(
            *_step_edges(positions, discomforts, yaws, goal_heading, reach, turns, layers),
            *_turn_edges(len(positions), turns, layers, reach),
            strict=True,
        )
    )
    size = 2 * HEADINGS * layers * len(positions)
    edges = csr_array((costs, (rows, columns)), shape=(size, size))
    return CrossingGraph(positions=positions, yaws=yaws, goal_heading=goal_heading, layers=layers, edges=edges)


def _turns_into(yaws: FloatArray, heading: int, side: int, reach: Reach) -> tuple[IntArray, FloatArray]:
    """Headings from which one can turn into a heading, and the turns [rad], those to the side of a swing foot first."""
    turns = planar.wrap_angle(yaws[heading] - yaws)
    befores = np.flatnonzero(np.abs(turns) <= reach.turn + 1e-9)
    befores = befores[np.argsort(turns[befores] * (1.0 if side == RIGHT else -1.0))]
    return befores, turns[befores]


def _step_edges(
    positions: FloatArray,
    discomforts: FloatArray,
    yaws: FloatArray,
    goal_heading: int,
    reach: Reach,
    turns: list[list[tuple[IntArray, FloatArray]]],
    layers: int,
) -> list[tuple[IntArray, IntArray, FloatArray]]:
    """Edges from a foot after the turn to the other foot, half a step's least cost taken off for the turn.

    A step ahead crosses the legs midway if its turn leads too far away from the swing foot's side: it leaves from the
    layer of those that do not. One that crosses them in the turn to that side, going back, is not taken.
    """
    tree = cKDTree(positions[:, [0, 2]])
    pairs = tree.query_pairs(reach.farthest, output_type="ndarray").astype(np.intp)
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    pairs = pairs[(pairs[:, 0] < 2) | (pairs[:, 0] > 3)]  # a foot at the goal has arrived
    pairs = pairs[pairs[:, 1] > 1]  # the start is not come back to
    offsets = positions[pairs[:, 1]] - positions[pairs[:, 0]]
    parts = []
    for heading, yaw in enumerate(yaws):
        landings = planar.rotate(-yaw, offsets[:, [0, 2]])
        for side in (LEFT, RIGHT):
            costs = step_costs(reach, landings, np.full(len(pairs), side), rises=offsets[:, 1])
            possible = np.flatnonzero(np.isfinite(costs) & _may_end(pairs[:, 1], side, heading == goal_heading))
            layer = _uncrossed(offsets[possible][:, [0, 2]], side, yaw, turns[heading][side][1])
            possible, layer = possible[layer > 0], layer[layer > 0]
            source, target = pairs[possible].T
            rows = ((source * 2 + 1 - side) * len(yaws) + heading) * layers + layer
            columns = ((target * 2 + side) * len(yaws) + heading) * layers
            parts.append((rows, columns, costs[possible] - 0.5 + discomforts[target]))
    return parts


def _may_end(places: IntArray, side: int, is_goal_heading: bool) -> BoolArray:
    """Whether a foot may stand at the places: at the goal each has its own, with the goal's heading."""
    at_goal = (places == 2) | (places == 3)
    return ~at_goal | ((places == 2 + side) & is_goal_heading)


def _uncrossed(offsets: FloatArray, side: int, yaw: float, turns: FloatArray) -> IntArray:
    """With how many of the first turns (T,) into a heading [rad] steps (N, 2) [m] do not cross the legs, shape (N,)."""
    apart = apart_midway(offsets[None], np.array(side), yaws_before=(yaw - turns)[:, None], turns=turns[:, None])
    return np.asarray(np.cumprod(apart >= -ROUNDED, axis=0).sum(axis=0))


def _turn_edges(
    count: int, turns: list[list[tuple[IntArray, FloatArray]]], layers: int, reach: Reach
) -> list[tuple[IntArray, IntArray, FloatArray]]:
    """Edges from a foot before the turn to the same after it; the largest turn costs a step.

    The turns are those into each heading, before the left and before the right foot swings.
    """
    parts: list[tuple[IntArray, IntArray, FloatArray]] = []
    for heading, both in enumerate(turns):
        for side, (befores, angles) in enumerate(both):
            feet = ((np.arange(count) * 2 + 1 - side) * len(turns))[:, None]
            rank, layer = np.triu_indices(len(befores))
            rows = (feet + befores[rank]) * layers
            columns = (feet + heading) * layers + layer + 1
            costs = 0.5 + (angles[rank] / reach.turn) ** 2
            parts.append((rows.ravel(), columns.ravel(), np.tile(costs, count)))
    return parts
