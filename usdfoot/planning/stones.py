"""Stepping stones: a feasible, comfortable way over given footholds ([P] Figure 13)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from usdfoot.analysis.timing import STAND_TIME, time_footsteps
from usdfoot.errors import PlanError
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import LEFT, RIGHT
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.crossed import apart_midway
from usdfoot.planning.prints import print_orientations
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.reach import Reach, step_costs

__all__ = ["Crossing", "Stance", "Stones", "find_crossing", "plan_stones", "stance_at"]

HEADINGS = 24
"""Headings the search tells apart."""
ROUNDED = 1e-9
"""Feet one behind the other do not cross [m]."""
MOST_PAIRS = 2_000_000
"""Pairs of footholds within reach of each other that are searched at most, for memory's sake."""


@dataclass(frozen=True, kw_only=True)
class Stones:
    """Places a foot may stand, N of them.

    Raises:
        PlanError: If there is none, or a position is not finite.
    """

    name: str
    """Prim paths they come from, for messages."""
    positions: FloatArray
    """Point of the ground under the ball [m], shape (N, 3)."""
    normals: FloatArray
    """Of the ground, shape (N, 3)."""

    def __post_init__(self) -> None:
        if not len(self.positions):
            raise PlanError(self.name, "has no footholds", "give points, or meshes with level places for a foot")
        stray = np.flatnonzero(~np.isfinite(np.hstack([self.positions, self.normals])).all(axis=1))
        if stray.size:
            raise PlanError(self.name, f"foothold {stray[0]} is not finite", "repair its position")


@dataclass(frozen=True, kw_only=True)
class Stance:
    """Both feet side by side, where a crossing starts or ends."""

    positions: FloatArray
    """Of the left and right foot [m], shape (2, 3)."""
    yaw: float
    """[rad]"""


@dataclass(frozen=True, kw_only=True)
class Crossing:
    """Footsteps from stance to stance, S of them, the first two and the last two side by side."""

    footholds: IntArray
    """Index of each footstep's foothold, -1 for the stances, shape (S,)."""
    sides: IntArray
    """0 = left, 1 = right, shape (S,)."""
    positions: FloatArray
    """[m], shape (S, 3)."""
    normals: FloatArray
    """Of the ground, shape (S, 3)."""
    yaws: FloatArray
    """Heading at the end of each step [rad], shape (S,)."""
    cost: float
    """Sum over all steps of how uncomfortable they are."""


def stance_at(position: FloatArray, yaw: float, reach: Reach) -> Stance:
    """Feet as far apart as is comfortable, around a point (3,) [m]."""
    across = 0.5 * float(reach.comfortable[0]) * planar.direction(np.array([yaw + 0.5 * np.pi, yaw - 0.5 * np.pi]))
    return Stance(positions=np.asarray(position, dtype=float) + np.insert(across, 1, 0.0, axis=1), yaw=yaw)


def plan_stones(
    stones: Stones,
    start: Stance,
    goal: Stance,
    *,
    reach: Reach,
    body: Proportions | None = None,
    speed: float = 0.0,
    start_time: float = 0.0,
    stand_time: float = STAND_TIME,
    name: str = "stones",
) -> FootstepPlan:
    """The plan of the most comfortable way over stones, standing at both ends, timed by its steps ([P] 4.1).

    Args:
        stones: Where feet may stand besides the stances.
        start: Where both feet are.
        goal: Where both feet shall be.
        reach: Of the character.
        body: Its legs and habits time the steps; None = a person's.
        speed: Mean of all steps [m/s]; 0 = as fast as such steps of the body are.
        start_time: When it begins [s].
        stand_time: How long it stands there, as along paths [s].
        name: Of the plan.

    Raises:
        PlanError: As `find_crossing`.
    """
    crossing = find_crossing(stones, start, goal, reach=reach)
    flight_distance = 0.0 if reach.leaps else float(np.hypot(reach.farthest, reach.rise))  # beyond all steps: no flight
    times = time_footsteps(
        crossing.positions,
        replace((body or Proportions()).timing, flight_distance=flight_distance),
        speed=speed,
        start_time=start_time,
        starts_standing=True,
        ends_standing=True,
        stand_time=stand_time,
    )
    return FootstepPlan(
        name=name,
        sides=crossing.sides,
        positions=crossing.positions,
        orientations=print_orientations(crossing.yaws, crossing.normals),
        strike_times=times.strike_times,
        liftoff_times=times.liftoff_times,
        root_weights=np.zeros(len(crossing.sides)),
    )


def find_crossing(stones: Stones, start: Stance, goal: Stance, *, reach: Reach) -> Crossing:
    """The most comfortable way from stance to stance over footholds.

    Dijkstra over (foothold, foot on it, heading): a turn, then a step. A step costs 1 when it is comfortable, and more
    with the square of its difference from that, of its rise and of its turn (`planning/reach.py`). Legs cross neither
    at its end nor midway through its turn.

    Args:
        stones: Where feet may stand besides the stances.
        start: Where both feet are.
        goal: Where both feet shall be.
        reach: Of the character.

    Raises:
        PlanError: If no way leads to the goal (it says how far one leads), or the footholds are too dense.
    """
    graph = _build_graph(stones, start, goal, reach)
    nodes = graph.nodes(np.array([0, 1]), np.array([LEFT, RIGHT]), np.zeros(2, dtype=int))
    costs, before, _ = dijkstra(graph.edges, indices=nodes, min_only=True, return_predecessors=True)
    arrived = graph.nodes(np.array([2, 3]), np.array([LEFT, RIGHT]), np.full(2, graph.goal_heading))
    best = int(arrived[np.argmin(costs[arrived])])
    if not np.isfinite(costs[best]):
        raise _unreachable(stones, graph, costs, goal, reach)
    places, sides, headings = graph.steps(_way_to(before, best))
    return _crossing(graph, stones, start, goal, (places, sides, headings), float(costs[best]))


@dataclass(frozen=True, kw_only=True)
class _Graph:
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


def _build_graph(stones: Stones, start: Stance, goal: Stance, reach: Reach) -> _Graph:
    positions = np.concatenate([start.positions, goal.positions, stones.positions])
    yaws = start.yaw + np.arange(HEADINGS) * (2.0 * np.pi / HEADINGS)
    goal_heading = int(np.argmin(np.abs(planar.wrap_angle(yaws - goal.yaw))))
    yaws[goal_heading] = goal.yaw if goal_heading else start.yaw
    turns = [[_turns_into(yaws, heading, side, reach) for side in (LEFT, RIGHT)] for heading in range(HEADINGS)]
    layers = 1 + max(len(befores) for both in turns for befores, _ in both)
    rows, columns, costs = (
        np.concatenate(part)
        for part in zip(
            *_step_edges(stones.name, positions, yaws, goal_heading, reach, turns, layers),
            *_turn_edges(len(positions), turns, layers, reach),
            strict=True,
        )
    )
    size = 2 * HEADINGS * layers * len(positions)
    edges = csr_array((costs, (rows, columns)), shape=(size, size))
    return _Graph(positions=positions, yaws=yaws, goal_heading=goal_heading, layers=layers, edges=edges)


def _turns_into(yaws: FloatArray, heading: int, side: int, reach: Reach) -> tuple[IntArray, FloatArray]:
    """Headings from which one can turn into a heading, and the turns [rad], those to the side of a swing foot first."""
    turns = planar.wrap_angle(yaws[heading] - yaws)
    befores = np.flatnonzero(np.abs(turns) <= reach.turn + 1e-9)
    befores = befores[np.argsort(turns[befores] * (1.0 if side == RIGHT else -1.0))]
    return befores, turns[befores]


def _step_edges(
    name: str,
    positions: FloatArray,
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
    count = tree.count_neighbors(tree, reach.farthest)
    if count > MOST_PAIRS:
        raise PlanError(
            name,
            f"has {count} pairs of footholds within a step, more than the {MOST_PAIRS} that are searched",
            "name fewer meshes with --on, or widen --spacing",
        )
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
            parts.append((rows, columns, costs[possible] - 0.5))
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


def _way_to(before: IntArray, node: int) -> IntArray:
    """Nodes from a source to a node."""
    way = [node]
    while before[way[-1]] >= 0:
        way.append(int(before[way[-1]]))
    return np.array(way[::-1])


def _crossing(
    graph: _Graph,
    stones: Stones,
    start: Stance,
    goal: Stance,
    steps: tuple[IntArray, IntArray, IntArray],
    cost: float,
) -> Crossing:
    """Adds the foot that stands beside the first and the one that closes up to the last."""
    places, sides, headings = steps
    first, last = 1 - sides[0], 1 - sides[-1]
    normals = np.concatenate([np.tile([0.0, 1.0, 0.0], (4, 1)), stones.normals])
    yaws = np.concatenate([[start.yaw], graph.yaws[headings], [goal.yaw]])
    places = np.concatenate([[first], places, [2 + last]])
    return Crossing(
        footholds=np.where(places < 4, -1, places - 4),
        sides=np.concatenate([[first], sides, [last]]),
        positions=graph.positions[places],
        normals=normals[places],
        yaws=_smoothed(yaws, np.diff(graph.positions[places][:, [0, 2]], axis=0), np.array([*sides, last])),
        cost=cost,
    )


def _smoothed(yaws: FloatArray, offsets: FloatArray, sides: IntArray) -> FloatArray:
    """Headings averaged with their neighbours, but for the stances, by at most half the search's resolution.

    Those of steps whose legs would cross by that stay; steps go by `offsets` (S - 1, 2) [m] and end on feet `sides`.
    """
    yaws = np.unwrap(yaws)
    means = yaws.copy()
    means[2:-2] = 0.25 * yaws[1:-3] + 0.5 * yaws[2:-2] + 0.25 * yaws[3:-1]
    most = np.pi / HEADINGS
    smooth = yaws + np.clip(means - yaws, -most, most)
    for _ in range(len(yaws)):
        apart = apart_midway(offsets, sides, yaws_before=smooth[:-1], turns=np.diff(smooth))
        crossed = np.flatnonzero(apart < -ROUNDED)
        ends = np.union1d(crossed, crossed + 1)
        if np.array_equal(smooth[ends], yaws[ends]):
            break
        smooth[ends] = yaws[ends]
    return smooth


def _unreachable(stones: Stones, graph: _Graph, costs: FloatArray, goal: Stance, reach: Reach) -> PlanError:
    """The error that says how far the way leads and how far it is from there."""
    reached = np.min(costs.reshape(len(graph.positions), -1), axis=1) < np.inf
    middle = goal.positions.mean(axis=0)
    far = np.linalg.norm(graph.positions - middle, axis=1)
    nearest = int(np.flatnonzero(reached)[np.argmin(far[reached])])
    where = "the start" if nearest < 4 else f"foothold {nearest - 4}"
    x, y, z = graph.positions[nearest]
    left = np.logical_not(reached)
    left[:2] = False
    gap = np.linalg.norm(graph.positions[left] - graph.positions[nearest], axis=1).min()
    return PlanError(
        stones.name,
        f"the goal cannot be reached; the way over {int(reached[4:].sum())} of {len(stones.positions)} footholds "
        f"ends at {where} ({x:.2f}, {y:.2f}, {z:.2f}) m, {far[nearest]:.2f} m before the goal, and the next one not "
        f"reached is {gap:.2f} m from there",
        f"a step reaches {reach.farthest:.2f} m and rises {reach.rise:.2f} m; add footholds"
        + ("" if reach.leaps else ", or let it leap"),
    )
