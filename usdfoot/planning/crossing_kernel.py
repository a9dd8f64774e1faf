"""The search for the best way over footholds as a Warp kernel, one thread a start and goal."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.planning.heap_kernel import climb, sink

__all__ = ["Footing", "Searches", "StepRules", "find_ways"]

NONE = wp.constant(wp.int32(-1))
TURNED = wp.constant(wp.float64(1.0e-9))
"""Turns may be larger than the largest by rounding [rad]."""


@wp.struct
class StepRules:
    """What a step may be and costs; see `planning/reach.py`."""

    normals: wp.array(dtype=wp.vec2d)  # of the outline's edges, outward
    rims: wp.array(dtype=wp.float64)  # how far along those it reaches
    lowest: wp.vec2d  # of the box around all landings of the left foot
    highest: wp.vec2d
    comfortable: wp.vec2d
    spread: wp.vec2d
    rise: wp.float64
    turn: wp.float64
    apart: wp.float64
    rounded: wp.float64


@wp.struct
class Footing:
    """Where feet may stand: four places of each search, of its start and goal, then footholds of all; P in all."""

    stances: wp.array(dtype=wp.vec3d, ndim=2)  # (M, 4)
    stones: wp.array(dtype=wp.vec3d)
    discomforts: wp.array(dtype=wp.float64)
    first: wp.array(dtype=wp.int32)  # neighbour of each foothold
    beside: wp.array(dtype=wp.int32)
    forward: wp.array(dtype=wp.vec2d, ndim=2)  # of each heading (x, z), (M, K)
    befores: wp.array(dtype=wp.int32, ndim=3)  # headings from which one turns into each, (M, K, T)
    turns: wp.array(dtype=wp.float64, ndim=3)  # by how much [rad], ascending; those too large stand for none, (M, K, T)
    midways: wp.array(dtype=wp.vec2d, ndim=3)  # halfway through them (x, z), (M, K, T)
    goal_headings: wp.array(dtype=wp.int32)
    ahead: wp.array(dtype=wp.float64, ndim=2)  # least cost from each foothold to the goal, (M, N)


@wp.struct
class Searches:
    """What the searches know of each node, (M, 2 P K)."""

    costs: wp.array(dtype=wp.float64, ndim=2)  # of the best way there
    keys: wp.array(dtype=wp.float64, ndim=2)  # the same and what at least is ahead
    before: wp.array(dtype=wp.int32, ndim=2)
    slots: wp.array(dtype=wp.int32, ndim=2)  # where in the heap, -1 = not yet
    heap: wp.array(dtype=wp.int32, ndim=2)


@wp.func
def place_at(footing: Footing, search: int, place: int):
    """Where a place is [m]."""
    point = footing.stones[wp.max(place - 4, 0)]
    if place < 4:
        point = footing.stances[search, place]
    return point


@wp.func
def step_cost(rules: StepRules, landing: wp.vec2d, rise: wp.float64, most: wp.float64):
    """What a step of the left foot costs that lands in the box around all landings.

    That is `most` if it is more, or cannot be made.
    """
    x = (landing[0] - rules.comfortable[0]) / rules.spread[0]
    z = (landing[1] - rules.comfortable[1]) / rules.spread[1]
    height = rise / (wp.float64(0.5) * rules.rise)
    cost = wp.float64(1.0) + x * x + z * z + height * height
    possible = cost < most and wp.dot(landing, landing) >= rules.apart * rules.apart
    edge = wp.int32(0)
    while possible and edge < rules.rims.shape[0]:
        possible = wp.dot(landing, rules.normals[edge]) <= rules.rims[edge]
        edge += 1
    if not possible:
        cost = most
    return cost


@wp.func
def is_uncrossed(
    footing: Footing, rules: StepRules, search: int, offset: wp.vec3d, side: int, heading: int, turn: wp.float64
):
    """Whether a step keeps the legs uncrossed midway through its turn, and through all that lead more to its side."""
    sign = wp.float64(2 * side - 1)
    uncrossed = bool(True)
    for number in range(footing.turns.shape[2]):
        own = footing.turns[search, heading, number]
        if own <= rules.turn + TURNED and sign * own <= sign * turn + TURNED:
            midway = footing.midways[search, heading, number]
            across = midway[1] * offset[0] - midway[0] * offset[2]
            uncrossed = uncrossed and -sign * across >= -rules.rounded
    return uncrossed


@wp.func
def offer_step(
    footing: Footing,
    rules: StepRules,
    searches: Searches,
    search: int,
    node: int,
    target: int,
    heading: int,
    turn: wp.float64,
    count: int,
):
    """Writes the step from a node to a place if it leads there better than known; gives back the heap's new count."""
    headings = footing.forward.shape[1]
    side = 1 - (node / headings) % 2
    offset = place_at(footing, search, target) - place_at(footing, search, node / headings / 2)
    forward = footing.forward[search, heading]
    x = forward[1] * offset[0] - forward[0] * offset[2]
    z = forward[1] * offset[2] + forward[0] * offset[0]
    if side == 1:
        x = -x
    inside = x >= rules.lowest[0] and x <= rules.highest[0] and z >= rules.lowest[1] and z <= rules.highest[1]
    other = (2 * target + side) * headings + heading
    total = searches.costs[search, node]
    ahead = wp.float64(0.0)
    better = bool(False)
    if inside and wp.abs(offset[1]) <= rules.rise:
        share = turn / rules.turn
        total += share * share
        if target >= 4:
            total += footing.discomforts[target - 4]
            ahead = footing.ahead[search, target - 4]
        most = searches.costs[search, other] - total
        cost = step_cost(rules, wp.vec2d(x, z), offset[1], most)
        total += cost
        better = cost < most
        if better:
            better = is_uncrossed(footing, rules, search, offset, side, heading, turn)
    if better:
        searches.costs[search, other] = total
        searches.keys[search, other] = total + ahead
        searches.before[search, other] = node
        if searches.slots[search, other] == NONE:
            searches.heap[search, count] = other
            searches.slots[search, other] = count
            count += 1
        climb(searches.heap, searches.slots, searches.keys, search, searches.slots[search, other])
    return count


@wp.kernel(enable_backward=False)
def find_ways(footing: Footing, rules: StepRules, searches: Searches, arrived: wp.array(dtype=wp.int32)):
    """The cheapest way of each search by A*, over nodes (place, foot, heading) of (M, 2 P K): a turn, then a step.

    Writes the node at the goal, -1 where none is reached, and of every node looked at its cost and the one before.
    """
    search = wp.tid()
    headings = footing.forward.shape[1]
    count = wp.int32(0)
    for side in range(2):
        node = (2 * side + side) * headings
        searches.costs[search, node] = wp.float64(0.0)
        searches.keys[search, node] = wp.float64(0.0)
        searches.heap[search, count] = node
        searches.slots[search, node] = count
        count += 1
    found = wp.int32(-1)
    while count > 0 and found < 0:
        node = searches.heap[search, 0]
        count -= 1
        if count > 0:
            searches.heap[search, 0] = searches.heap[search, count]
            sink(searches.heap, searches.slots, searches.keys, search, count)
        place = node / headings / 2
        if place == 2 or place == 3:
            found = node
        else:
            begin = wp.int32(0)
            end = footing.stones.shape[0]
            if place >= 4:
                begin = footing.first[place - 4]
                end = footing.first[place - 3]
            for number in range(footing.turns.shape[2]):
                turn = -footing.turns[search, node % headings, number]
                if turn >= -rules.turn - TURNED:
                    heading = footing.befores[search, node % headings, number]
                    for neighbour in range(begin, end):
                        target = neighbour + 4
                        if place >= 4:
                            target = footing.beside[neighbour] + 4
                        count = offer_step(footing, rules, searches, search, node, target, heading, turn, count)
                    if heading == footing.goal_headings[search]:  # its own foot at the goal
                        target = 2 + 1 - (node / headings) % 2
                        count = offer_step(footing, rules, searches, search, node, target, heading, turn, count)
    arrived[search] = found
