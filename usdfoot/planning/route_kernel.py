"""Searches for ways over a grid of spots as Warp kernels, one thread an end, and looks along these ways."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

from usdfoot.planning.clearance_kernel import Outlines, find_clearance
from usdfoot.planning.heap_kernel import CLOSED, climb, sink

__all__ = [
    "FULL",
    "LED",
    "NOWHERE",
    "STRAIGHT",
    "STRAYED",
    "TOO_SMALL",
    "UNKNOWN",
    "GridSpots",
    "Known",
    "Targets",
    "find_spots",
    "look_ahead",
    "search",
]

STRAIGHT = 985
DIAGONAL = 1393
"""Lengths of steps between cells in whole numbers, 1 : sqrt(2) but for 4e-7: sums do not depend on their order."""
RISER = wp.constant(wp.float64(0.21))
DEARER = 20
"""What steps are higher than those of stairs [m] counts as so many times as long: ramps are not entered from beside."""
SPARE = 2 * STRAIGHT
"""Ways so much longer than those from the starts are found too, for who strays from them."""
UNKNOWN = wp.constant(wp.int32(2**30))
"""Length of ways that were not looked for."""
FULL, TOO_SMALL = 1, 2
"""Why a search gave up: its table is full, it would lead out of the window."""
NOWHERE, STRAYED, LED = -1, 0, 1
"""No way leads on; the way on is not known; it is."""
VIEWS = wp.constant(wp.int32(15))
"""Places on a straight line at which one looks whether it leads over spots."""
ROUNDED = wp.constant(wp.float64(1.0e-9))
"""As much room as a body needs there is in spite of rounding [m]."""


@wp.struct
class GridSpots:
    """A window of X by Z cells of a lattice, with S spots to stand on."""

    cells: wp.vec2i
    cell: wp.float64  # [m]
    inner_lowest: wp.vec2i  # first and last cells around which all is known
    inner_highest: wp.vec2i
    around: wp.array(dtype=wp.vec2i)  # a cell itself, and those that touch it
    first: wp.array(dtype=wp.int32)  # spot of each cell, (X * Z + 1)
    columns: wp.array(dtype=wp.int32)
    heights: wp.array(dtype=wp.float64)
    clearances: wp.array(dtype=wp.float64)
    edges: wp.array(dtype=wp.bool)
    linked: wp.array(dtype=wp.int32)  # first link of each spot, (S + 1)
    links: wp.array(dtype=wp.int32)


@wp.struct
class Targets:
    """Where the ways of M searches end; each may move the lattice by less than a cell."""

    places: wp.array(dtype=wp.vec2d)
    spots: wp.array(dtype=wp.int32)
    anchors: wp.array(dtype=wp.vec2d)  # the centre of a cell as it moves the lattice
    cells: wp.array(dtype=wp.vec2i)  # which one
    shifts: wp.array(dtype=wp.float64)  # how far it moves the lattice [m]
    lowest: wp.array(dtype=wp.vec2i)  # first and last cells over which its ways may lead
    highest: wp.array(dtype=wp.vec2i)
    radius: wp.float64  # of the body [m]
    within: wp.float64  # how far above or below a place its spot may be [m]


@wp.struct
class Known:
    """Spots of each search in a table by their numbers, and how long the ways from there are, (M, C)."""

    spots: wp.array(dtype=wp.int32, ndim=2)  # -1 = none
    lengths: wp.array(dtype=wp.int32, ndim=2)
    complete: wp.array(dtype=wp.bool)  # whether nothing else has a way to the goal


@wp.func
def cell_of(grid: GridSpots, spot: int):
    """The cell of a spot."""
    column = grid.columns[spot]
    return wp.vec2i(column / grid.cells[1], column % grid.cells[1])


@wp.func
def is_between(cell: wp.vec2i, lowest: wp.vec2i, highest: wp.vec2i):
    """Whether a cell is in a window."""
    return cell[0] >= lowest[0] and cell[1] >= lowest[1] and cell[0] <= highest[0] and cell[1] <= highest[1]


@wp.func
def place_of(grid: GridSpots, targets: Targets, row: int, spot: int):
    """Where a spot is (x, z) [m]: the centre of its cell as a search moves the lattice, or where the ways end."""
    cell = cell_of(grid, spot)
    x = grid.cell * wp.float64(cell[0] - targets.cells[row][0])
    z = grid.cell * wp.float64(cell[1] - targets.cells[row][1])
    place = targets.anchors[row] + wp.vec2d(x, z)
    if spot == targets.spots[row]:
        place = targets.places[row]
    return place


@wp.func
def is_free(grid: GridSpots, outlines: Outlines, targets: Targets, row: int, spot: int):
    """Whether a body has room on a spot.

    How far that is from everything is known of the lattice as it is; only where that leaves it open one measures.
    """
    cell = cell_of(grid, spot)
    free = is_between(cell, targets.lowest[row], targets.highest[row]) and not grid.edges[spot]
    needed = targets.radius - ROUNDED
    if free and grid.clearances[spot] - targets.shifts[row] < needed:
        free = grid.clearances[spot] + targets.shifts[row] >= needed
        if free:
            place = place_of(grid, targets, row, spot)
            free = find_clearance(outlines, place, grid.heights[spot], wp.float64(0.0), needed) >= needed
    return free or spot == targets.spots[row]


@wp.func
def find_spot(grid: GridSpots, outlines: Outlines, targets: Targets, row: int, place: wp.vec2d, height: wp.float64):
    """The free spot in the cell of a place, or in one touching it, whose height is near; -1 = none."""
    own = cell_at(grid, targets, row, place)
    found = wp.int32(-1)
    side = wp.int32(0)
    while found < 0 and side < grid.around.shape[0]:
        cell = own + grid.around[side]
        if is_between(cell, wp.vec2i(0, 0), grid.cells - wp.vec2i(1, 1)):
            column = cell[0] * grid.cells[1] + cell[1]
            for spot in range(grid.first[column], grid.first[column + 1]):
                near = found < 0 and wp.abs(grid.heights[spot] - height) <= targets.within
                if near and is_free(grid, outlines, targets, row, spot):
                    found = spot
        side += 1
    return found


@wp.func
def cell_at(grid: GridSpots, targets: Targets, row: int, place: wp.vec2d):
    """The cell of a place as a search moves the lattice."""
    offset = (place - targets.anchors[row]) / grid.cell
    return targets.cells[row] + wp.vec2i(int(wp.rint(offset[0])), int(wp.rint(offset[1])))


@wp.func
def slot_of(known: Known, row: int, spot: int):
    """Where in its table a spot is, or would be."""
    most = known.spots.shape[1] - 1
    at = wp.int32(((wp.uint32(spot) * wp.uint32(40503)) >> wp.uint32(4)) & wp.uint32(most))
    while known.spots[row, at] >= 0 and known.spots[row, at] != spot:
        at = (at + 1) & most
    return at


@wp.func
def step_length(grid: GridSpots, spot: int, other: int):
    """How long the step to a neighbour is, a high one longer."""
    apart = wp.abs(grid.columns[other] - grid.columns[spot])
    length = wp.int32(DIAGONAL)
    if apart == 1 or apart == grid.cells[1]:
        length = wp.int32(STRAIGHT)
    above = wp.abs(grid.heights[other] - grid.heights[spot]) - RISER
    if above > wp.float64(0.0):
        length += wp.int32(wp.rint(wp.float64(STRAIGHT * DEARER) * above / grid.cell))
    return length


@wp.func
def least_ahead(cell: wp.vec2i, box: wp.vec4i):
    """How long a way from a cell into a box (lowest x and z, highest x and z) is at least."""
    x = wp.max(wp.max(box[0] - cell[0], cell[0] - box[2]), 0)
    z = wp.max(wp.max(box[1] - cell[1], cell[1] - box[3]), 0)
    return STRAIGHT * wp.max(x, z) + (DIAGONAL - STRAIGHT) * wp.min(x, z)


@wp.kernel(enable_backward=False)
def find_spots(
    grid: GridSpots,
    outlines: Outlines,
    targets: Targets,
    rows: wp.array(dtype=wp.int32),
    places: wp.array(dtype=wp.vec2d),
    heights: wp.array(dtype=wp.float64),
    spots: wp.array(dtype=wp.int32),
):
    """The free spot at or beside each place, as its search moves the lattice; -1 = none."""
    index = wp.tid()
    spots[index] = find_spot(grid, outlines, targets, rows[index], places[index], heights[index])


@wp.kernel(enable_backward=False)
def search(
    grid: GridSpots,
    outlines: Outlines,
    targets: Targets,
    boxes: wp.array(dtype=wp.vec4i),
    first: wp.array(dtype=wp.int32),
    starts: wp.array(dtype=wp.int32),
    known: Known,
    keys: wp.array(dtype=wp.float64, ndim=2),
    slots: wp.array(dtype=wp.int32, ndim=2),
    heaps: wp.array(dtype=wp.int32, ndim=2),
    failed: wp.array(dtype=wp.int32),
):
    """How long the ways to each end are, by A* from it towards the box around the starts, until those of all are known.

    And those of spots so little off the way from the farthest of them that it is longer by `SPARE` at most. A start of
    -1 is never found: then all is looked at; without any start nothing is.
    """
    row = wp.tid()
    goal = targets.spots[row]
    slot = slot_of(known, row, wp.max(goal, 0))
    count = wp.int32(0)
    if goal >= 0:
        count += 1
        known.spots[row, slot] = goal
    known.lengths[row, slot] = 0
    keys[row, slot] = wp.float64(0.0)
    heaps[row, 0] = slot
    slots[row, slot] = 0
    filled = wp.int32(1)
    left = first[row + 1] - first[row]
    most = wp.float64(1.0e300)
    if left == 0:
        most = wp.float64(-1.0)
    failure = wp.int32(0)
    while failure == 0 and count > 0 and keys[row, heaps[row, 0]] <= most:
        slot = heaps[row, 0]
        count -= 1
        if count > 0:
            heaps[row, 0] = heaps[row, count]
            sink(heaps, slots, keys, row, count)
        slots[row, slot] = CLOSED
        spot = known.spots[row, slot]
        length = known.lengths[row, slot]
        for number in range(first[row], first[row + 1]):
            if starts[number] == spot:
                left -= 1
                if left == 0:
                    most = wp.float64(length + SPARE)
        if not is_between(cell_of(grid, spot), grid.inner_lowest, grid.inner_highest):
            failure = TOO_SMALL
        for link in range(grid.linked[spot], grid.linked[spot + 1]):
            other = grid.links[link]
            slot = slot_of(known, row, other)
            longer = length + step_length(grid, spot, other)
            if known.spots[row, slot] < 0:
                known.spots[row, slot] = other
                known.lengths[row, slot] = UNKNOWN
                slots[row, slot] = CLOSED
                filled += 1
                if is_free(grid, outlines, targets, row, other):
                    heaps[row, count] = slot
                    slots[row, slot] = count
                    count += 1
            if slots[row, slot] != CLOSED and longer < known.lengths[row, slot]:
                known.lengths[row, slot] = longer
                keys[row, slot] = wp.float64(longer + least_ahead(cell_of(grid, other), boxes[row]))
                climb(heaps, slots, keys, row, slots[row, slot])
        if 2 * filled > known.spots.shape[1]:
            failure = FULL
    known.complete[row] = count == 0
    for place in range(count):
        known.lengths[row, heaps[row, place]] = UNKNOWN
    failed[row] = failure


@wp.func
def follow(grid: GridSpots, known: Known, row: int, spot: int):
    """The spot after one on the shortest way to the goal, itself at the goal; of several the first diagonal one."""
    left = known.lengths[row, slot_of(known, row, spot)]
    longest = wp.int32(0)
    following = wp.int32(spot)
    for link in range(grid.linked[spot], grid.linked[spot + 1]):
        other = grid.links[link]
        slot = slot_of(known, row, other)
        length = step_length(grid, spot, other)
        leads = known.spots[row, slot] == other and known.lengths[row, slot] + length == left
        if leads and length > longest:
            longest = length
            following = other
    return following


@wp.func
def is_in_view(
    grid: GridSpots, outlines: Outlines, targets: Targets, row: int, place: wp.vec2d, height: wp.float64, spot: int
):
    """Whether the straight line from a place to a spot leads over free spots all the way."""
    offset = place_of(grid, targets, row, spot) - place
    rise = grid.heights[spot] - height
    seen = bool(True)
    view = wp.int32(1)
    while seen and view <= VIEWS:
        share = wp.float64(view) / wp.float64(VIEWS)
        seen = find_spot(grid, outlines, targets, row, place + share * offset, height + share * rise) >= 0
        view += 1
    return seen


@wp.kernel(enable_backward=False)
def look_ahead(
    grid: GridSpots,
    outlines: Outlines,
    targets: Targets,
    known: Known,
    rows: wp.array(dtype=wp.int32),
    places: wp.array(dtype=wp.vec2d),
    heights: wp.array(dtype=wp.float64),
    ways: wp.array(dtype=wp.int32, ndim=2),
    led: wp.array(dtype=wp.int32),
    lengths: wp.array(dtype=wp.int32),
    aims: wp.array(dtype=wp.vec2d),
):
    """Whether each place has a way to its search's goal (M,), how long that is, and the farthest point in view on it.

    Ways (M, L) are followed for at most as many spots as there is room for. Who sees none of them looks at the next.
    """
    index = wp.tid()
    row = rows[index]
    place = places[index]
    height = heights[index]
    spot = find_spot(grid, outlines, targets, row, place, height)
    led[index] = NOWHERE
    cell = cell_at(grid, targets, row, place)
    beside = wp.vec2i(1, 1)
    inside = is_between(cell, targets.lowest[row] - beside, targets.highest[row] + beside)
    if inside and not is_between(cell, grid.inner_lowest, grid.inner_highest):
        led[index] = STRAYED
    if spot >= 0 and led[index] == NOWHERE:
        slot = slot_of(known, row, spot)
        if known.spots[row, slot] == spot and known.lengths[row, slot] != UNKNOWN:
            led[index] = LED
            lengths[index] = known.lengths[row, slot]
        elif not known.complete[row]:
            led[index] = STRAYED
    if led[index] == LED:
        count = wp.int32(0)
        while count < ways.shape[1] and (count == 0 or spot != ways[index, wp.max(count - 1, 0)]):
            ways[index, count] = spot
            spot = follow(grid, known, row, spot)
            count += 1
        farthest = count - 1
        while farthest >= 0 and not is_in_view(
            grid, outlines, targets, row, place, height, ways[index, wp.max(farthest, 0)]
        ):
            farthest -= 1
        if farthest < 0:
            farthest = wp.min(1, count - 1)
        aims[index] = place_of(grid, targets, row, ways[index, farthest])
