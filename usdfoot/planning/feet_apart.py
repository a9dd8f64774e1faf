"""Feet apart: footsteps of different people that would be in one place at one time are moved."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.planning.foot_table import FootTable, Instants
from usdfoot.planning.giving_way import Room, give_way
from usdfoot.planning.near_feet import NearFeet, find_near_feet
from usdfoot.planning.presences import INSTANT
from usdfoot.planning.step_limits import StepLimits, uncross

__all__ = ["is_sideways", "set_feet_apart"]

CLEARANCE, CLOSE = 0.03, 0.015
"""Between soles that are moved apart, and those less than which apart are [m]."""
NOT_FAR, FARTHEST = 0.4, 0.6
"""A footstep is moved this far at most, at first and in the end [m]."""
SEARCHES, ROUNDS = 60, 12
"""How often near feet are looked for at most, and how often they are moved in between."""
PATIENCE = 3
"""So many searches may bring nothing before one gives up."""
RELAXING, WIDER = 0.8, 1.1
"""With every search the own feet may come this much nearer to each other across, over before; farther apart, in the
end, by this."""
NARROWER = 0.5
"""Who gives way keeps its feet this much of the least distance apart across, if it had that."""
ACROSS = 0.1
"""Feet that go less far across take no side step [m]."""
UNDECIDED = 0.7
"""Pushes between two feet of which less than this part is left in sum lead nowhere: one swings through the other."""
NEAR = 0.1
"""Feet this far apart are watched while others move [m]."""


def set_feet_apart(
    feet: FootTable,
    limits: StepLimits,
    *,
    confine: Callable[[FootTable, IntArray], FootTable] | None = None,
    waits: bool = True,
) -> FootTable:
    """The table with footsteps moved apart until no feet overlap, or as far as they may be moved.

    Each overlap pushes both feet away by half of it; a swinging foot passes that on to the footsteps it swings between.
    Those few that are left then give way one by one, aside or by waiting.

    Args:
        feet: Of all people.
        limits: How near and far from the other foot they may be.
        confine: Gives back a table with some of its feet (rows) moved to where they may stand, off walls; None =
            everywhere.
        waits: Whether feet may also strike later, or earlier.
    """
    feet = confine(feet, np.arange(len(feet.owners))) if confine else feet
    near = find_near_feet(feet, slack=NEAR)
    start = feet.positions[:, [0, 2]]
    best, least, found = feet, np.inf, 0
    for search in range(SEARCHES):
        before, strict = feet.positions, RELAXING**search
        for _ in range(ROUNDS):
            pushes = _pushes(feet, near)
            if pushes is None:
                break
            feet, moved = _pushed(feet, pushes, start, farthest=FARTHEST - (FARTHEST - NOT_FAR) * strict)
            near = near.moved(feet, moved)
        feet = uncross(feet, limits.relaxed(narrower=strict, wider=WIDER - (WIDER - 1.0) * strict))
        if confine:
            feet = confine(feet, np.flatnonzero(_moved(feet, before)))
        near = near.after(feet, _moved(feet, before))
        left = float(np.maximum(near.depths, 0.0).sum())
        if left < least:
            best, least, found = feet, left, search
        if left <= 0.0 or search - found >= PATIENCE:
            break
    last = limits.relaxed(narrower=NARROWER, wider=WIDER)
    room = Room(start=start, farthest=FARTHEST, limits=last, confine=confine, waits=waits)
    return best if least <= 0.0 else give_way(best, room)


def is_sideways(feet: FootTable) -> BoolArray:
    """Whether each footstep is part of a side step, in which a foot goes more across than ahead, shape (S,)."""
    rows = np.arange(len(feet.owners))
    before, after = np.where(feet.numbers > 1, rows - 2, rows), np.where(feet.last, rows, rows + 2)
    after = np.minimum(after, len(rows) - 1)
    moved = planar.rotate(-feet.yaws, (feet.positions[after] - feet.positions[before])[:, [0, 2]])
    return np.asarray(np.abs(moved[:, 0]) > np.maximum(np.abs(moved[:, 1]), ACROSS))


def _moved(feet: FootTable, before: FloatArray) -> BoolArray:
    """Which footsteps are elsewhere on the plane than positions (S, 3) [m] say, shape (S,)."""
    return np.asarray((feet.positions[:, 0] != before[:, 0]) | (feet.positions[:, 2] != before[:, 2]))


def _pushed(feet: FootTable, pushes: FloatArray, start: FloatArray, *, farthest: float) -> tuple[FootTable, BoolArray]:
    """The table with footsteps pushed (S, 2) up to `farthest` from their start (S, 2) [m]; and which were."""
    moved = (pushes[:, 0] != 0.0) | (pushes[:, 1] != 0.0)
    points, origins = feet.positions[:, [0, 2]], start[moved]
    offsets = points[moved] + pushes[moved] - origins
    lengths = np.maximum(np.linalg.norm(offsets, axis=1, keepdims=True), 1e-12)
    points[moved] = origins + offsets * np.minimum(1.0, farthest / lengths)
    return _placed(feet, points), moved


def _placed(feet: FootTable, points: FloatArray) -> FootTable:
    positions = feet.positions.copy()
    positions[:, [0, 2]] = points
    return replace(feet, positions=positions)


def _pushes(feet: FootTable, near: NearFeet) -> FloatArray | None:
    """Where to move every footstep [m]: the mean of what those too close ask for, shape (S, 2); None if nobody is."""
    close = np.flatnonzero(near.depths > -CLOSE)
    if not close.size:
        return None
    first, second = near.first[close], near.second[close]
    push = 0.5 * _decided(feet, first, second, (near.depths[close, None] + CLEARANCE) * near.directions[close])
    sums, counts = np.zeros((len(feet.owners), 2)), np.zeros(len(feet.owners))
    for instants, sign in ((first, 1.0), (second, -1.0)):
        norm = (1.0 - instants.shares) ** 2 + instants.shares**2
        for index, share in ((instants.steps, 1.0 - instants.shares), (instants.steps + 2, instants.shares)):
            used = share > 0.0
            np.add.at(sums, index[used], sign * (share / norm)[used, None] * push[used])
            np.add.at(counts, index[used], share[used])
    return sums / np.maximum(counts, 1.0)[:, None]


def _decided(feet: FootTable, first: Instants, second: Instants, pushes: FloatArray) -> FloatArray:
    """Pushes between feet [m], shape (K, 2); across the way of a foot that swings through where another is.

    Before that one it would be pushed back, behind it on.
    """
    groups = _meetings(feet, first, second)
    count, depths = int(groups.max()) + 1, np.linalg.norm(pushes, axis=1)
    sums, ways = np.zeros((count, 2)), np.zeros((count, 2))
    np.add.at(sums, groups, pushes)
    np.add.at(ways, groups, _ways(feet, first) - _ways(feet, second))
    undecided = np.linalg.norm(sums, axis=1) < UNDECIDED * np.bincount(groups, depths)
    lengths = np.linalg.norm(ways, axis=1, keepdims=True)
    across = ways[:, ::-1] * np.array([1.0, -1.0]) / np.maximum(lengths, 1e-9)
    across *= np.where(np.sum(sums * across, axis=1, keepdims=True) < 0.0, -1.0, 1.0)
    turned = (undecided & (lengths[:, 0] > ACROSS))[groups, None]
    return np.where(turned, depths[:, None] * across[groups], pushes)


def _meetings(feet: FootTable, first: Instants, second: Instants) -> IntArray:
    """To which meeting of two feet pairs of them belong, shape (K,): one goes on as long as they are near each other.

    One may strike in the midst of it, where the other has just left or goes through.
    """
    one, other = (2 * feet.owners[foot.steps] + feet.sides[foot.steps] for foot in (first, second))
    order = np.lexsort((first.times, other, one))
    new = (np.diff(one[order]) != 0) | (np.diff(other[order]) != 0) | (np.diff(first.times[order]) > 1.5 * INSTANT)
    groups = np.empty(len(order), dtype=np.intp)
    groups[order] = np.concatenate([[0], np.cumsum(new)])
    return groups


def _ways(feet: FootTable, instants: Instants) -> FloatArray:
    """Where feet go in their swings (x, z) [m]; 0 of those that stand, shape (K, 2)."""
    following = np.minimum(instants.steps + 2, len(feet.owners) - 1)
    ways = (feet.positions[following] - feet.positions[instants.steps])[:, [0, 2]]
    return np.where(instants.shares[:, None] > 0.0, ways, 0.0)
