"""Giving way: the last feet that are in one place at one time, each moved or delayed to where they are not."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.planning.collisions import find_collisions
from usdfoot.planning.foot_table import FootTable, Instants, joined_tables
from usdfoot.planning.near_feet import Pairs, find_pairs_of, overlaps
from usdfoot.planning.step_limits import StepLimits

__all__ = ["Room", "give_way"]

AROUND, BEFORE = 2.5, 6.0
"""Feet so near [m], so long before and after [s], are looked at."""
FAR = (0.05, 0.1, 0.17, 0.25, 0.35, 0.5)
"""How far feet are tried from where they are [m]."""
WAYS = 12
"""In how many directions."""
DELAYS = (0.1, -0.1, 0.2, -0.2, 0.3)
"""How much later swings are tried, or earlier [s]."""
LEAST_STAND = 0.1
"""No stand that was longer becomes shorter than this [s]."""
ROUNDS = 4
"""How often all that meet are gone through."""
CLEARANCE = 0.005
"""Feet so near [m] count as meeting."""


@dataclass(frozen=True, kw_only=True)
class Room:
    """Where footsteps may be."""

    start: FloatArray
    """Where they were planned (x, z) [m], shape (S, 2)."""
    farthest: float
    """From there [m]."""
    limits: StepLimits
    """From the other foot."""
    confine: Callable[[FootTable, IntArray], FootTable] | None
    """Moves feet (rows) off walls; None = there are none."""
    waits: bool
    """Whether swings may be later or earlier."""

    def __getitem__(self, rows: IntArray) -> Room:
        return replace(self, start=self.start[rows], limits=self.limits[rows])


def give_way(feet: FootTable, room: Room) -> FootTable:
    """The table in which of every two footsteps that meet one has moved to where it meets fewer, or swings later.

    Args:
        feet: Of all people.
        room: Where they may be.
    """
    meeting = find_collisions(feet).steps
    for _ in range(ROUNDS):
        before = feet
        for pair in meeting:
            rows = _around(feet, pair)
            part = _part(feet, rows)
            own = np.flatnonzero(np.isin(rows, np.concatenate([pair, pair + 2])))
            own = own[np.isin(part.owners, feet.owners[pair])[own] & (part.numbers[own] > 0)]
            feet = _with(feet, rows, _best(part, own, room[rows]))
        changed = np.any(feet.positions != before.positions, axis=1)
        changed |= (feet.strikes != before.strikes) | (feet.liftoffs != before.liftoffs)
        if not changed.any():
            break
        changed[meeting] = True
        meeting = find_collisions(feet, among=changed).steps
    return feet


def _with(feet: FootTable, rows: IntArray, part: FootTable) -> FootTable:
    """The table with footsteps (K,) where and when they are in another."""
    positions, strikes, liftoffs = feet.positions.copy(), feet.strikes.copy(), feet.liftoffs.copy()
    positions[rows], strikes[rows], liftoffs[rows] = part.positions, part.strikes, part.liftoffs
    return replace(feet, positions=positions, strikes=strikes, liftoffs=liftoffs)


def _around(feet: FootTable, pair: IntArray) -> IntArray:
    """Rows of all footsteps, for some seconds, of everybody who comes near two of them meanwhile."""
    middle, time = feet.positions[pair].mean(axis=0), feet.strikes[pair].max()
    soon = (feet.liftoffs > time - BEFORE) & (feet.strikes < time + BEFORE)
    near = soon & (np.linalg.norm(feet.positions - middle, axis=1) < AROUND)
    rows = np.flatnonzero(soon & np.isin(feet.owners, feet.owners[near]))
    first = np.flatnonzero(np.diff(feet.owners[rows], prepend=-1))
    ends = np.append(first[1:], len(rows)) - 1
    return np.concatenate([np.arange(rows[low], rows[high] + 1) for low, high in zip(first, ends, strict=True)])


def _part(feet: FootTable, rows: IntArray) -> FootTable:
    """Some footsteps (K,), consecutive for everybody, as a table."""
    part = FootTable(**{column.name: getattr(feet, column.name)[rows] for column in fields(FootTable)})
    cut = np.append(np.diff(part.owners) != 0, True)
    return replace(part, last=part.last | cut | np.append(cut[1:], True))


def _best(feet: FootTable, own: IntArray, room: Room) -> FootTable:
    """The table with one of some footsteps (K,) moved, or delayed, so that they meet others least."""
    chosen = np.isin(np.arange(len(feet.owners)), own)
    near = find_pairs_of(feet, chosen, slack=max(FAR))
    best, least = feet, _met(near.depths).sum()
    for row in own.tolist():
        places, met = _elsewhere(feet, row, near, room)
        for place in np.argsort(met, kind="stable").tolist():
            if met[place] >= least:
                break
            tried = _placed(feet, row, places[place])
            if _stays(tried, row, room):
                best, least = tried, met[place]
        if least <= 0.0:
            return best
    for row in own.tolist() if room.waits else ():
        for tried in _delayed(feet, row):
            left = _met(find_pairs_of(tried, chosen, slack=CLEARANCE).depths).sum()
            if left < least:
                best, least = tried, left
    return best


def _met(depths: FloatArray) -> FloatArray:
    """How much feet that overlap so far [m], negative = apart, are too near each other [m]."""
    return np.maximum(depths + CLEARANCE, 0.0)


def _elsewhere(feet: FootTable, row: int, near: Pairs, room: Room) -> tuple[FloatArray, FloatArray]:
    """Places (x, z) around a footstep that are in reach, and from which the next is, (C, 2); how much feet meet, (C,).

    All of them at once: as many tables one after the other.
    """
    here, ways = feet.positions[row, [0, 2]], planar.direction(2.0 * np.pi * np.arange(WAYS) / WAYS)
    places = here + (np.array(FAR)[:, None, None] * ways).reshape(-1, 2)
    inside = np.linalg.norm(places - room.start[row], axis=1) <= room.farthest
    places = np.concatenate([here[None], places[inside]])
    count, size = len(places), len(feet.owners)
    tables = joined_tables([feet] * count)
    shifts = size * np.arange(count)
    tables = _placed(tables, row + shifts, places)
    steps = np.array([row, row + 1] if row + 1 < size and feet.owners[row + 1] == feet.owners[row] else [row])
    limits = room.limits[np.tile(np.arange(size), count)]
    allowed = room.limits.excess(feet, steps) + 1e-9
    reached = limits.excess(tables, (shifts[:, None] + steps).ravel()).reshape(count, len(steps), 2)
    own = np.flatnonzero(near.touch(np.arange(size) == row))
    first, second = (
        Instants(
            steps=(shifts[:, None] + pairs.steps[own]).ravel(),
            shares=np.tile(pairs.shares[own], count),
            times=np.tile(pairs.times[own], count),
        )
        for pairs in (near.first, near.second)
    )
    rest = _met(np.delete(near.depths, own)).sum()
    met = rest + _met(overlaps(tables, first, second)[0]).reshape(count, len(own)).sum(axis=1)
    return places, np.where(np.all(reached <= allowed, axis=(1, 2)), met, np.inf)


def _placed(feet: FootTable, rows: int | IntArray, places: FloatArray) -> FootTable:
    """The table with footsteps at other places (x, z) [m]."""
    points = feet.positions[:, [0, 2]]
    points[rows] = places
    positions = feet.positions.copy()
    positions[:, [0, 2]] = points
    return replace(feet, positions=positions)


def _stays(feet: FootTable, row: int, room: Room) -> bool:
    """Whether walls let a footstep be where it is."""
    confined = room.confine(feet, np.array([row])) if room.confine else feet
    return bool(np.abs(confined.positions - feet.positions).max() < 1e-6)


def _delayed(feet: FootTable, row: int) -> Iterator[FootTable]:
    """Tables with the swing to one footstep later, or earlier, while the other foot stands as before."""
    left = row - 2
    if left < 0 or feet.owners[left] != feet.owners[row]:
        return
    for delay in DELAYS:
        strikes, liftoffs = feet.strikes.copy(), feet.liftoffs.copy()
        strikes[row] += delay
        liftoffs[left] += delay
        tried = replace(feet, strikes=strikes, liftoffs=liftoffs)
        if np.all(_margins(tried, row) >= np.minimum(_margins(feet, row), 0.0) - 1e-9):
            yield tried


def _margins(feet: FootTable, row: int) -> FloatArray:
    """How long both feet stand before and after the swing to a footstep, and its stands over the least [s]."""
    other, left = row - 1, row - 2
    margins = [
        feet.liftoffs[left] - feet.strikes[other],  # both stand before the swing
        feet.liftoffs[other] - feet.strikes[row],  # and after it
        feet.liftoffs[left] - feet.strikes[left] - LEAST_STAND,
        feet.liftoffs[row] - feet.strikes[row] - LEAST_STAND,
    ]
    return np.array(margins)
