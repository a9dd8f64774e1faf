"""Waiting: plans that go slower, or stand for a while, so that obstacles that move pass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.bumps import (
    ON_TOP,
    STEPPED_OVER,
    body_places,
    coming_times,
    find_bumps,
    lower_heights,
    sole_places,
)
from usdfoot.planning.foot_table import FootTable, feet_of
from usdfoot.planning.lint import lint_alone
from usdfoot.planning.moving import Moving
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.stops import with_stops

__all__ = ["find_meetings", "let_pass"]

DELAY = 0.1
"""Steps are delayed by multiples of it [s]."""
LONGEST = (10.0, 120.0)
"""Nobody waits longer altogether [s]; what is shorter is looked for first."""
SLOWER = 1.5
"""A delay that is no longer [s] is made up of steps that each take `DELAY` longer."""
STOP = 1.0
"""Who waits at least so long in one place [s] stands there on both feet, where there is room."""
EARLIER = 3
"""So many footsteps before the last from which it can wait it may stand."""
BODY, SOLE = 0.25, 0.05
"""Distances kept from the middle of the body, and from the soles, where there is room [m]."""


def find_meetings(
    plans: Sequence[FootstepPlan], bodies: Sequence[Proportions], moving: Moving
) -> dict[int, tuple[str, float]]:
    """The first obstacle that each of P plans meets, and when the foot strikes that does [s], by index."""
    if not plans:
        return {}
    feet = feet_of(plans, bodies)
    soles, walks = find_bumps(feet, (), moving=moving.at)
    met = [*zip(soles.rows, soles.obstacles, strict=True), *zip(walks.rows, walks.obstacles, strict=True)]
    return {int(feet.owners[row]): (name, float(feet.strikes[row])) for row, name in sorted(met, reverse=True)}


def let_pass(plan: FootstepPlan, body: Proportions, moving: Moving, *, ground: Ground) -> FootstepPlan | None:
    """The plan with the same footsteps, some of them later, so that no obstacle meets it; None if there is none.

    Of the ways to wait the one that ends first; short delays are slower steps, in long ones it stands where it is
    longest clear, as near as it gets. Swings keep their time: both feet stand longer before them. Who stands long
    does so on both feet, with two footsteps more, where these are as right as the others.

    Args:
        plan: As it would be without the obstacles.
        body: Who walks it.
        moving: Obstacles at times of the plan.
        ground: Below it.
    """
    feet = feet_of([plan], [body])
    for beside, sole in ((BODY, SOLE), (0.0, 0.0)):
        for longest in LONGEST:
            delays = _delays(feet, _Room(feet=feet, moving=moving, body=beside, sole=sole), longest)
            if delays is not None:
                later = _delayed(plan, delays)
                if not find_meetings([later], [body], moving):
                    rows = np.flatnonzero(np.diff(delays) >= STOP)
                    stood = _stood(plan, rows, body, moving, ground=ground, room=(beside, sole)) if rows.size else None
                    return later if stood is None else stood
    return None


def _stood(
    plan: FootstepPlan,
    rows: IntArray,
    body: Proportions,
    moving: Moving,
    *,
    ground: Ground,
    room: tuple[float, float],
) -> FootstepPlan | None:
    """The plan with waits on both feet beside footsteps (K,) or ones before them, None if that is not as right."""
    for earlier in range(EARLIER):
        found = with_stops(plan, (rows - earlier).tolist(), ground)
        if found is None:
            continue
        stopped, closing = found
        feet = feet_of([stopped], [body])
        space = _Room(feet=feet, moving=moving, body=room[0], sole=room[1])
        delays = _delays(feet, space, LONGEST[-1], closing=closing)
        if delays is None:
            continue
        later = _delayed(stopped, delays)
        faults = [len(lint_alone([one], ground, bodies=[body])) for one in (plan, later)]
        if faults[1] <= faults[0] and not find_meetings([later], [body], moving):
            return later
    return None


def _delayed(plan: FootstepPlan, delays: FloatArray) -> FootstepPlan:
    """The plan with the step to each footstep so much later (N,) [s]."""
    leaving = np.concatenate([delays[2:], delays[-1:], delays[-1:]])
    return replace(plan, strike_times=plan.strike_times + delays, liftoff_times=plan.liftoff_times + leaving)


def _delays(feet: FootTable, room: _Room, longest: float, *, closing: IntArray | None = None) -> FloatArray | None:
    """By how much each step has to be late (N,), at most so long [s], None if that cannot be.

    Who stands after a step can stay as long as it is clear there, and go when the next step is. At which delays each
    step can end is found from the first to the last, the delays then from the last to the first. With closing steps
    (K,) it stands after these alone.
    """
    size = len(feet.owners)
    most = min(max(room.moving.end - feet.strikes[0], 0.0), longest)  # from the end on nothing changes
    count = 2 + int(np.ceil(most / DELAY))
    overlaps = np.append(0.0, feet.liftoffs[:-1] - feet.strikes[1:])
    overlaps[-1] = feet.liftoffs[-1] - feet.strikes[-1]
    spans = np.ceil(np.maximum(overlaps, 0.0) / DELAY - 1e-9).astype(np.intp)
    hurried = np.zeros(size, dtype=bool) if closing is None else ~np.isin(np.arange(size), closing)
    stands, comes = room.stands(count + int(spans.max())), room.comes(count)
    reached, latest = np.zeros((size, count), dtype=bool), np.zeros((size, count), dtype=np.intp)
    reached[1, 0] = True
    for row in range(1, size):
        blocked = np.append(np.flatnonzero(~stands[row]), stands.shape[1])
        latest[row] = blocked[np.searchsorted(blocked, np.arange(count))] - 1 - spans[row]
        if overlaps[row] <= 0.0:  # in flight nobody waits
            latest[row] = np.minimum(latest[row], np.arange(count))
        if hurried[row]:
            latest[row] = np.minimum(latest[row], np.arange(count) + 1)
        if row + 1 < size:
            own = np.flatnonzero(reached[row] & (latest[row] >= np.arange(count)))
            opens = np.bincount(own, minlength=count + 1) - np.bincount(
                np.minimum(latest[row, own] + 1, count), minlength=count + 1
            )
            reached[row + 1] = (np.cumsum(opens)[:count] > 0) & comes[row + 1]
    last = np.flatnonzero(reached[-1] & (latest[-1] >= np.arange(count)))
    if not last.size:
        return None
    delays = np.zeros(size, dtype=np.intp)
    delays[-1] = last[0]
    for row in range(size - 2, 0, -1):
        after = int(delays[row + 1])
        able = np.flatnonzero(reached[row, : after + 1] & (latest[row, : after + 1] >= after))
        delays[row] = able[-1] if hurried[row] else _before(able, after)
    return DELAY * delays


def _before(able: IntArray, after: int) -> int:
    """The delay, of those a step can have, before one that has a delay: both in multiples of `DELAY`."""
    little = able[able >= after - 1]
    return int(little[0] if DELAY * after <= SLOWER and little.size else able[0])


_Discs = tuple[FloatArray, FloatArray, FloatArray]


@dataclass(frozen=True, kw_only=True)
class _Room:
    """Whether a walker of N footsteps is clear of obstacles."""

    feet: FootTable
    moving: Moving
    body: float
    """Kept from the middle of the body [m]."""
    sole: float
    """And from the soles [m]."""

    def stands(self, count: int) -> BoolArray:
        """Whether both last feet and the body are clear so many times `DELAY` after each strikes, shape (N, count)."""
        rows = np.arange(len(self.feet.owners))
        discs = [*self._soles(rows), *self._soles(np.maximum(rows - 1, 0)), self._body(body_places(self.feet)[-1])]
        return self._clear([(self.feet.strikes, *disc) for disc in discs], count)

    def comes(self, count: int) -> BoolArray:
        """Whether steps are clear that are so many times `DELAY` late, shape (N, count)."""
        support = self._soles(np.maximum(np.arange(len(self.feet.owners)) - 1, 0))
        on_way = zip(coming_times(self.feet)[1], body_places(self.feet), strict=True)
        return self._clear(
            [(times, *disc) for times, places in on_way for disc in (*support, self._body(places))], count
        )

    def _soles(self, rows: IntArray) -> list[_Discs]:
        """Places (N, 2), heights (N,) and radii (N,) of discs in the soles of footsteps (N,)."""
        heights, radii = self.feet.positions[rows, 1] + ON_TOP, self.feet.half_widths[rows] + self.sole
        return [(places[rows], heights, radii) for places in sole_places(self.feet)]

    def _body(self, places: FloatArray) -> _Discs:
        """The same of bodies at places (N, 2)."""
        return places, lower_heights(self.feet) + STEPPED_OVER, np.full(len(places), self.body)

    def _clear(self, discs: Sequence[tuple[FloatArray, FloatArray, FloatArray, FloatArray]], count: int) -> BoolArray:
        """Whether all discs are clear so many times `DELAY` after times (N,), shape (N, count)."""
        began, places, heights, radii = (np.array(values) for values in zip(*discs, strict=True))  # (D, N) and so on
        times = began[..., None] + DELAY * np.arange(count)
        points = np.broadcast_to(places[:, :, None], (*times.shape, 2)).reshape(-1, 2)
        levels = np.broadcast_to(heights[..., None], times.shape).ravel()
        rooms = self.moving.clearances_then(points, levels, times.ravel()).reshape(times.shape)
        return np.asarray(np.all(rooms > radii[..., None], axis=0))
