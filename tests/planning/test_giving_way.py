"""Giving way: one of two feet that meet goes aside, or waits."""

from __future__ import annotations

import numpy as np

from usdfoot.planning.collisions import find_collisions
from usdfoot.planning.foot_table import FootTable
from usdfoot.planning.giving_way import Room, give_way
from usdfoot.planning.step_limits import limit_steps

STEPS = 8


def walk(start: float, *, toward: float, first: float, owner: int) -> FootTable:
    """Somebody who walks from a place (z) [m] along x = 0, forth or back, both feet down for 0.3 s in each step."""
    numbers = np.arange(STEPS)
    strikes = first + 0.7 * numbers
    return FootTable(
        owners=np.full(STEPS, owner),
        numbers=numbers,
        positions=np.stack([0.1 * toward * (-1.0) ** numbers, np.zeros(STEPS), start + toward * 0.4 * numbers], axis=1),
        yaws=np.full(STEPS, 0.0 if toward > 0.0 else np.pi),
        sides=numbers % 2,
        strikes=strikes,
        liftoffs=strikes + 1.0,
        last=numbers >= STEPS - 2,
        heels=np.full(STEPS, 0.18),
        toes=np.full(STEPS, 0.08),
        half_widths=np.full(STEPS, 0.05),
    )


def together(first: FootTable, second: FootTable) -> FootTable:
    """One table of two."""
    return FootTable(**{name: np.concatenate([getattr(first, name), getattr(second, name)]) for name in vars(first)})


def room_of(feet: FootTable, *, farthest: float, waits: bool) -> Room:
    narrowest, widest = (np.full(len(feet.owners), size) for size in (0.05, 0.86))
    limits = limit_steps(feet, narrowest=narrowest, widest=widest)
    start = feet.positions[:, [0, 2]]
    return Room(start=start, farthest=farthest, limits=limits, confine=None, waits=waits)


def test_one_goes_aside_in_reach():
    feet = together(walk(0.0, toward=1.0, first=0.0, owner=0), walk(2.9, toward=-1.0, first=0.25, owner=1))
    met = find_collisions(feet).depths.sum()
    room = room_of(feet, farthest=0.6, waits=False)
    parted = give_way(feet, room)
    assert met > 0.1
    assert not len(find_collisions(parted).depths)
    assert np.linalg.norm(parted.positions - feet.positions, axis=1).max() <= 0.6 + 1e-9
    rows = np.flatnonzero(feet.numbers > 0)
    assert np.all(room.limits.excess(parted, rows) <= room.limits.excess(feet, rows) + 1e-6)
    assert np.array_equal(parted.strikes, feet.strikes)


def test_one_waits_where_the_other_has_not_left_yet():
    ahead = walk(0.0, toward=1.0, first=0.0, owner=0)
    behind = walk(0.0, toward=1.0, first=0.9, owner=1)
    behind.positions[:, 0] += np.where(behind.numbers == 4, 0.0, 5.0)  # only there is it where the other was
    feet = together(ahead, behind)
    waited = give_way(feet, room_of(feet, farthest=0.0, waits=True))
    assert np.array_equal(waited.positions, feet.positions)
    assert find_collisions(waited).depths.sum() < find_collisions(feet).depths.sum()
    moved = np.flatnonzero(waited.strikes != feet.strikes)
    assert len(moved) == 1
    assert np.all(waited.liftoffs > waited.strikes)
    other = moved - 1
    assert np.all(waited.strikes[moved] <= waited.liftoffs[other] + 1e-9)  # never without a foot on the ground
    assert np.all(waited.liftoffs[moved - 2] >= waited.strikes[other] - 1e-9)


def test_who_may_not_wait_keeps_its_times():
    feet = together(walk(0.0, toward=1.0, first=0.0, owner=0), walk(2.9, toward=-1.0, first=0.25, owner=1))
    kept = give_way(feet, room_of(feet, farthest=0.0, waits=False))
    assert np.array_equal(kept.positions, feet.positions)
    assert np.array_equal(kept.strikes, feet.strikes)
