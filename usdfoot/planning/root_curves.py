"""RootCurves: the trajectories of many agents, smoothed and with headings, to be asked at any time.

Tracked people and simulated crowds come in coarse samples with jitter, and sway with each step. The model: around every
instant the samples, joined by straight lines, are fitted by a line whose weights fall off like a Gaussian. So a steady
walk is kept exactly, at its ends too; an acceleration a moves it by a sigma^2 / 2; a sway of period p shrinks by
exp(-2 (pi sigma / p)^2).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import correlate1d

from usdfoot.errors import PlanError
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.trajectory import RootTrajectory, sample_trajectories

__all__ = ["SPACING", "CurveBatches", "RootCurves", "build_root_curves"]

SPACING = 1.0 / 30.0
"""Distance of the curves' own samples [s]."""
LARGEST = 20_000_000
"""Samples of one curve: about half a gigabyte an array."""
BATCH = 2_000_000
"""Samples of curves that are made at once: some ten arrays of 16 to 48 MB."""
KEPT = 10_000_000
"""Samples of curves that are kept, 32 bytes each."""
TRAVEL = 0.15
"""A root that moves less than this across a window does not say where it goes [m]."""
WINDOWS = (0.3, 0.8, 1.6)
"""Half widths of the windows in which the direction is looked for, the narrowest that moves first [s]."""
TURN_RATE = 2.0
"""How fast a standing root turns to where it will go next [rad/s]."""


@dataclass(frozen=True, kw_only=True)
class RootCurves:
    """Curves of A agents, sampled every SPACING from each one's own start; held at their end."""

    starts: FloatArray
    """[s], shape (A,)."""
    ends: FloatArray
    """[s], shape (A,)."""
    positions: FloatArray
    """[m], shape (A, F, 3)."""
    yaws: FloatArray
    """Headings [rad], continuous, shape (A, F)."""
    end_velocities: FloatArray
    """With which the curve goes on beyond its end [m/s], shape (A, 3)."""
    deviations: FloatArray
    """Mean and largest distance of the smoothed from the given trajectory [m], shape (A, 2)."""

    def at(self, agents: IntArray, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (N, 3) [m] and headings (N,) [rad] of agents (N,) at times (N,) [s]."""
        inside = np.minimum(times, self.ends[agents])
        place = np.maximum((inside - self.starts[agents]) / SPACING, 0.0)
        before = np.minimum(place.astype(np.intp), self.yaws.shape[1] - 2)
        share = place - before
        first, second = self.positions[agents, before], self.positions[agents, before + 1]
        places = first + share[:, None] * (second - first)
        places += (times - inside)[:, None] * self.end_velocities[agents]
        yaws = self.yaws[agents, before]
        return places, yaws + share * (self.yaws[agents, before + 1] - yaws)

    def __getitem__(self, agents: IntArray) -> RootCurves:
        return RootCurves(
            starts=self.starts[agents],
            ends=self.ends[agents],
            positions=self.positions[agents],
            yaws=self.yaws[agents],
            end_velocities=self.end_velocities[agents],
            deviations=self.deviations[agents],
        )


class CurveBatches:
    """Root curves of A agents, made for some of them at a time, and anew whenever they are asked for.

    Those of thousands for ten minutes would fill the memory. Up to `KEPT` samples they are made once.

    Args:
        trajectories: One an agent.
        smoothing_time: Standard deviation of the window [s].

    Raises:
        PlanError: As `build_root_curves`.
    """

    def __init__(self, trajectories: Sequence[RootTrajectory], *, smoothing_time: float) -> None:
        self._trajectories, self._smoothing_time = trajectories, smoothing_time
        self.starts, self.ends = _spans(trajectories)
        kept = len(trajectories) * _frames(self.starts, self.ends) <= KEPT
        self._all = self._made(np.arange(len(trajectories))) if kept else None

    def of(self, agents: IntArray) -> Iterator[tuple[IntArray, RootCurves]]:
        """Some of the agents (N,) and their curves, until all have come; even numbers of them but for the last."""
        for part in _batches(self.starts[agents], self.ends[agents]):
            yield agents[part], self._made(agents[part]) if self._all is None else self._all[agents[part]]

    def _made(self, agents: IntArray) -> RootCurves:
        own = [self._trajectories[agent] for agent in agents.tolist()]
        return build_root_curves(own, smoothing_time=self._smoothing_time)


def build_root_curves(trajectories: Sequence[RootTrajectory], *, smoothing_time: float) -> RootCurves:
    """Curves of all trajectories; each has the same bytes whatever the others are.

    Args:
        trajectories: One an agent.
        smoothing_time: Standard deviation of the window [s].

    Raises:
        PlanError: If one of them is more than `LARGEST` samples long.
    """
    starts, ends = _spans(trajectories)
    parts = _batches(starts, ends)
    if len(parts) == 1:
        return _build_batch(trajectories, starts, ends, smoothing_time)
    frames = _frames(starts, ends)
    positions, yaws = np.empty((len(starts), frames, 3)), np.empty((len(starts), frames))
    velocities, deviations = np.empty((len(starts), 3)), np.empty((len(starts), 2))
    for part in parts:
        own = _build_batch(trajectories[part], starts[part], ends[part], smoothing_time)
        count = own.yaws.shape[1]
        positions[part, :count], positions[part, count:] = own.positions, own.positions[:, -1:]
        yaws[part, :count], yaws[part, count:] = own.yaws, own.yaws[:, -1:]
        velocities[part], deviations[part] = own.end_velocities, own.deviations
    return RootCurves(
        starts=starts, ends=ends, positions=positions, yaws=yaws, end_velocities=velocities, deviations=deviations
    )


def _build_batch(
    trajectories: Sequence[RootTrajectory], starts: FloatArray, ends: FloatArray, smoothing_time: float
) -> RootCurves:
    """Curves of all trajectories at once."""
    grid = np.arange(_frames(starts, ends)) * SPACING
    clock = np.minimum(grid, (ends - starts)[:, None])  # (A, F)
    inside = grid <= (ends - starts)[:, None] + 0.5 * SPACING
    rows = np.broadcast_to(np.arange(len(trajectories))[:, None], clock.shape)
    places = np.concatenate([trajectory.positions for trajectory in trajectories])
    given = sample_trajectories(trajectories, rows, starts[:, None] + clock, values=places)
    smoothed = _fitted(given, inside, smoothing_time / SPACING)
    distances = np.where(inside, np.linalg.norm((smoothed - given)[..., [0, 2]], axis=-1), 0.0)
    counts = inside.sum(axis=1)
    last = counts - 1
    agents = np.arange(len(starts))
    back = np.maximum(last - 3, 0)
    elapsed = np.maximum(last - back, 1)[:, None] * SPACING
    return RootCurves(
        starts=starts,
        ends=ends,
        positions=_held(smoothed, last),
        yaws=_headings(trajectories, starts, clock, smoothed, inside, smoothing_time),
        end_velocities=(smoothed[agents, last] - smoothed[agents, back]) / elapsed,
        deviations=np.stack([distances.sum(axis=1) / counts, distances.max(axis=1)], axis=1),
    )


def _frames(starts: FloatArray, ends: FloatArray) -> int:
    """Samples of the longest of some curves."""
    return int(np.ceil((ends - starts).max() / SPACING)) + 2


def _batches(starts: FloatArray, ends: FloatArray) -> list[slice]:
    """Agents whose curves are made at once: even numbers of them, but for the last ones."""
    size = 2 * max(1, BATCH // (2 * _frames(starts, ends)))
    return [slice(first, first + size) for first in range(0, len(starts), size)]


def _spans(trajectories: Sequence[RootTrajectory]) -> tuple[FloatArray, FloatArray]:
    """Starts and ends [s], shape (A,) each; raises PlanError, which names it, if the longest has too many samples."""
    starts = np.array([trajectory.start for trajectory in trajectories])
    ends = np.array([trajectory.end for trajectory in trajectories])
    longest = int(np.argmax(ends - starts))
    if (ends - starts)[longest] / SPACING > LARGEST:
        raise PlanError(
            trajectories[longest].name,
            f"goes on from {starts[longest]:.6g} to {ends[longest]:.6g} s, {ends[longest] - starts[longest]:.6g} s",
            f"cut it: each may take {LARGEST * SPACING:.0f} s; or correct its times",
        )
    return starts, ends


def _fitted(values: FloatArray, inside: BoolArray, sigma: float) -> FloatArray:
    """Values (A, F, C) fitted by lines in Gaussian windows of `sigma` samples; samples not `inside` do not count."""
    if sigma <= 0.0:
        return values
    reach = int(np.ceil(3.0 * sigma))
    offsets = np.arange(-reach, reach + 1)
    bell = np.exp(-0.5 * (offsets / sigma) ** 2)

    def moments(power: int, of: FloatArray) -> FloatArray:
        return np.asarray(correlate1d(of, bell * offsets**power, axis=1, mode="constant"))

    weight, lean, spread = (moment[..., None] for moment in _window_moments(bell, offsets, inside))
    masked = values * inside[..., None]
    level, slope = moments(0, masked), moments(1, masked)
    determinant = weight * spread - lean**2
    usable = determinant > 1e-9 * np.maximum(weight * spread, 1e-30)
    return np.where(usable, (spread * level - lean * slope) / np.where(usable, determinant, 1.0), values)


def _window_moments(bell: FloatArray, offsets: IntArray, inside: BoolArray) -> list[FloatArray]:
    """Sums of a bell (W,) times powers 0 to 2 of its offsets (W,) over those that fall on samples `inside` (A, F)."""
    frames, reach = np.arange(inside.shape[1]), len(bell) // 2
    first = np.maximum(reach - frames, 0)
    end = np.clip(inside.sum(axis=1)[:, None] - frames + reach, first, len(bell))
    sums = [np.concatenate([[0.0], np.cumsum(bell * offsets**power)]) for power in range(3)]
    return [total[end] - total[first] for total in sums]


def _held(values: FloatArray, last: IntArray) -> FloatArray:
    """Values (A, F, ...) with what follows each one's `last` sample replaced by it."""
    places = np.minimum(np.arange(values.shape[1]), last[:, None])
    return values[np.arange(len(values))[:, None], places]


def _headings(
    trajectories: Sequence[RootTrajectory],
    starts: FloatArray,
    clock: FloatArray,
    positions: FloatArray,
    inside: BoolArray,
    smoothing_time: float,
) -> FloatArray:
    """Headings as given, else where the root goes, smoothed; shape (A, F)."""
    last = inside.sum(axis=1) - 1
    given = np.array([trajectory.yaws is not None for trajectory in trajectories])
    yaws: FloatArray = np.zeros(clock.shape)
    if given.any():
        rows = np.broadcast_to(np.arange(len(trajectories))[:, None], clock.shape)
        values = np.concatenate([np.zeros(len(t.times)) if t.yaws is None else t.yaws for t in trajectories])
        yaws = sample_trajectories(trajectories, rows, starts[:, None] + clock, values=values[:, None])[..., 0]
    if not given.all():
        own = np.flatnonzero(~given)
        rest = np.array([trajectories[agent].rest_yaw for agent in own.tolist()])
        yaws[own] = _travel_yaws(_held(positions[own], last[own])[..., [0, 2]], rest, last[own])
    return _held(_fitted(yaws[..., None], inside, smoothing_time / SPACING)[..., 0], last)


def _travel_yaws(places: FloatArray, rest: FloatArray, last: IntArray) -> FloatArray:
    """Where roots at (x, z) (A, F, 2) go; while they stand, where they went, turning in time to where they go next."""
    count = places.shape[1]
    frames = np.arange(count)
    known = np.zeros(places.shape[:2], dtype=bool)
    yaws = np.zeros(places.shape[:2])
    rows = np.arange(len(places))[:, None]
    for half in WINDOWS:
        width = round(half / SPACING)
        ahead = np.minimum(frames + width, last[:, None])
        behind = np.maximum(frames - width, 0)
        travel = places[rows, ahead] - places[:, behind]
        moves = ~known & (np.linalg.norm(travel, axis=-1) > TRAVEL)
        yaws[moves] = planar.yaw_of(travel[moves])
        known |= moves
    before = np.maximum.accumulate(np.where(known, frames, -1), axis=1)
    after = np.minimum.accumulate(np.where(known, frames, count)[:, ::-1], axis=1)[:, ::-1]
    never = ~known.any(axis=1)
    next_yaws = np.take_along_axis(yaws, np.minimum(after, count - 1), axis=1)
    past_yaws = np.take_along_axis(yaws, np.maximum(before, 0), axis=1)
    past_yaws = np.where(before < 0, next_yaws, past_yaws)
    next_yaws = np.where(after >= count, past_yaws, next_yaws)
    change = planar.wrap_angle(next_yaws - past_yaws)
    left = (after - frames) * SPACING
    share = np.clip(1.0 - left * TURN_RATE / np.maximum(np.abs(change), 1e-9), 0.0, 1.0)
    filled = np.where(known, yaws, past_yaws + change * share)
    filled[never] = rest[never, None]
    return np.asarray(np.unwrap(filled, axis=1))
