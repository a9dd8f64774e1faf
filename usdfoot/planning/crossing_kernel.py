"""The search for the best way over footholds as a Warp kernel, one thread a start and goal."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.planning.heap_kernel import CLOSED, climb, sink

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
    offsets: wp.array(dtype=wp.vec3d)  # to it
    least: wp.array(dtype=wp.float64)  # cost of a step there
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
    slots: wp.array(dtype=wp.int32, ndim=2)  # where in the heap, -1 = not yet, -2 = no longer
    heap: wp.array(dtype=wp.int32, ndim=2)
    most: wp.array(dtype=wp.float64)  # a way may cost, (M,)
    eagerness: wp.float64  # how much what is ahead counts in keys; above 1, ways are found sooner but not the best


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
def write_step(searches: Searches, search: int, node: int, other: int, cost: wp.float64, ahead: wp.float64, count: int):
    """Writes that a node is reached from another at a cost; gives back the heap's new count."""
    slot = searches.slots[search, other]
    if slot != CLOSED:
        searches.costs[search, other] = cost
        searches.keys[search, other] = cost + searches.eagerness * ahead
        searches.before[search, other] = node
        if slot == NONE:
            slot = count
            searches.heap[search, slot] = other
            count += 1
        climb(searches.heap, searches.slots, searches.keys, search, slot)
    return count


@wp.func
def offer_steps(
    footing: Footing,
    rules: StepRules,
    searches: Searches,
    search: int,
    node: int,
    target: int,
    offset: wp.vec3d,
    only: int,
    ahead: wp.float64,
    count: int,
):
    """Writes the steps from a node to a place, one for each turn, that lead there better than known.

    `only` is the one heading to arrive in, or -1; `ahead` what at least is left from there. Gives back the heap's new
    count.
    """
    headings = footing.forward.shape[1]
    before = node % headings
    side = 1 - (node / headings) % 2
    for number in range(footing.turns.shape[2]):
        turn = -footing.turns[search, before, number]
        heading = footing.befores[search, before, number]
        if (only < 0 or heading == only) and turn >= -rules.turn - TURNED:
            forward = footing.forward[search, heading]
            x = forward[1] * offset[0] - forward[0] * offset[2]
            z = forward[1] * offset[2] + forward[0] * offset[0]
            if side == 1:
                x = -x
            inside = x >= rules.lowest[0] and x <= rules.highest[0] and z >= rules.lowest[1] and z <= rules.highest[1]
            if inside and wp.abs(offset[1]) <= rules.rise:
                other = (2 * target + side) * headings + heading
                share = turn / rules.turn
                total = searches.costs[search, node] + share * share
                if target >= 4:
                    total += footing.discomforts[target - 4]
                most = wp.min(searches.costs[search, other], searches.most[search] - ahead) - total
                cost = step_cost(rules, wp.vec2d(x, z), offset[1], most)
                if cost < most and is_uncrossed(footing, rules, search, offset, side, heading, turn):
                    count = write_step(searches, search, node, other, total + cost, ahead, count)
    return count


@wp.func
def leave(footing: Footing, rules: StepRules, searches: Searches, search: int, node: int, count: int):
    """Writes all steps from a node that a way may cost; gives back the heap's new count."""
    headings = footing.forward.shape[1]
    place = node / headings / 2
    own = 3 - (node / headings) % 2  # place of the swing foot at the goal
    cost = searches.costs[search, node]
    if place >= 4:
        for link in range(footing.first[place - 4], footing.first[place - 3]):
            stone = footing.beside[link]
            ahead = footing.ahead[search, stone]
            if cost + footing.least[link] + ahead <= searches.most[search]:
                offset = footing.offsets[link]
                count = offer_steps(footing, rules, searches, search, node, stone + 4, offset, NONE, ahead, count)
    else:
        for stone in range(footing.stones.shape[0]):
            ahead = footing.ahead[search, stone]
            offset = footing.stones[stone] - footing.stances[search, place]
            count = offer_steps(footing, rules, searches, search, node, stone + 4, offset, NONE, ahead, count)
    heading = footing.goal_headings[search]
    offset = footing.stances[search, own] - place_at(footing, search, place)
    count = offer_steps(footing, rules, searches, search, node, own, offset, heading, wp.float64(0.0), count)
    return count


@wp.kernel(enable_backward=False)
def find_ways(
    footing: Footing,
    rules: StepRules,
    searches: Searches,
    rows: wp.array(dtype=wp.int32),
    arrived: wp.array(dtype=wp.int32),
):
    """The ways of the searches `rows` by A*, over nodes (place, foot, heading) of (M, 2 P K): a turn, then a step.

    Writes the node at the goal, -1 where none is reached, and of every node looked at its cost and the one before.
    """
    search = rows[wp.tid()]
    headings = footing.forward.shape[1]
    for node in range(searches.costs.shape[1]):
        searches.costs[search, node] = wp.float64(wp.inf)
        searches.slots[search, node] = NONE
    count = wp.int32(0)
    for side in range(2):
        node = (2 * side + side) * headings
        searches.costs[search, node] = wp.float64(0.0)
        searches.keys[search, node] = wp.float64(0.0)
        searches.before[search, node] = NONE
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
        searches.slots[search, node] = CLOSED
        place = node / headings / 2
        if place == 2 or place == 3:
            found = node
        else:
            count = leave(footing, rules, searches, search, node, count)
    arrived[search] = found
