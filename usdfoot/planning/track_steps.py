"""Track steps: the footsteps of people who move as tracks say, all of them at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from usdfoot.analysis.timing import TimingRule
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import LEFT
from usdfoot.planning.gait import natural_lengths, overlap_shares
from usdfoot.planning.proportions import Proportions

__all__ = ["TrackSteps", "join_steps", "step_along_tracks", "uncross"]

SMOOTHING = 0.45
"""Standard deviation of the filter on tracks, which takes out a simulation's jitter [s]."""
FACING = 0.8
"""Standard deviation of the filter on where people face; to what is quicker they side-step [s]."""
STILL = 0.1
"""Slower people stand [m/s]."""
CLOSING = 0.6
"""Steps they go on for after that, so that the feet stand side by side."""
TURN = np.radians(40.0)
"""Turn that takes a step of its own [rad]."""
LEAD = 3.0
"""Time to turn on the spot before the tracks begin [s]."""
TAIL = 1.8
"""Time to close up after the tracks end [s]."""
STAND = 0.6
"""How long they stand after the last step [s]."""
NARROW = 0.6
"""Least distance between the feet across, over that of an easy step: legs do not cross."""
SWING = 0.6
"""Least part of a step's natural time that a foot swings after a stand."""
QUICKEST = 0.57
"""Least time of a swing over that of a short step."""
GAP = 1e3
"""Between people on the axis on which all tracks lie one after the other."""


@dataclass(frozen=True, kw_only=True)
class TrackSteps:
    """Footsteps of N people one after the other, S in all; everyone starts and ends standing."""

    first: IntArray
    """Index of each one's first footstep, shape (N + 1,)."""
    sides: IntArray
    """0 = left, 1 = right, shape (S,)."""
    points: FloatArray
    """Under the ball, (x, z) [m], shape (S, 2)."""
    yaws: FloatArray
    """Where the body faces [rad], shape (S,)."""
    strike_times: FloatArray
    """[s], shape (S,)."""
    liftoff_times: FloatArray
    """[s], shape (S,)."""
    widths: FloatArray
    """Least distance across from the footstep before, so that legs do not cross [m], shape (S,)."""
    lead: float
    """When the tracks begin [s]."""

    @property
    def owners(self) -> IntArray:
        """Whose each footstep is, shape (S,)."""
        return np.repeat(np.arange(len(self.first) - 1), np.diff(self.first))


def step_along_tracks(points: FloatArray, *, time_step: float, yaws: FloatArray, body: Proportions) -> TrackSteps:
    """Footsteps along tracks, quick and long as people of that speed choose, on the spot where they only turn.

    The root is midway between the feet whenever one strikes, so a footstep lies where the root is half a step later, to
    its side. Times count from the start of the turns, `LEAD` before the tracks begin.

    Args:
        points: Tracks (x, z) [m], shape (T, N, 2).
        time_step: Between their samples [s].
        yaws: Where people face at first, NaN = where they go [rad], shape (N,).
        body: Of all of them.
    """
    rule = TimingRule(leg_length=body.leg_length)
    lead, tail = round(LEAD / time_step), round(TAIL / time_step)
    still = np.concatenate([np.repeat(points[:1], lead, axis=0), points, np.repeat(points[-1:], tail, axis=0)])
    roots = gaussian_filter1d(still, SMOOTHING / time_step, axis=0, mode="nearest")
    velocities = np.gradient(roots, time_step, axis=0)
    speeds = np.linalg.norm(velocities, axis=2)
    facing = _facing(velocities, yaws, time_step, lead)
    cadence = _cadences(speeds, facing, time_step, rule)
    phases = np.concatenate([np.zeros((1, points.shape[1])), np.cumsum(cadence[:-1] * time_step, axis=0)])
    tracks = _Tracks(phases=phases, time_step=time_step)
    counts = np.floor(phases[-1] + 0.5).astype(int) + 2
    first = np.concatenate([[0], np.cumsum(counts)])
    owners = np.repeat(np.arange(len(counts)), counts)
    numbers = np.arange(first[-1]) - first[owners] - 1.0  # -1 and 0 are the stance at the start
    strikes = np.where(numbers < 1.0, 0.0, tracks.times(owners, numbers - 0.5))
    beside = np.minimum(tracks.times(owners, numbers), strikes + 0.5 * rule.longest_step)
    beside = np.where(numbers < 1.0, 0.0, beside)
    sides = ((numbers + 1.0) % 2).astype(int) ^ LEFT
    headings = tracks.at(owners, beside, facing)
    middles = np.stack([tracks.at(owners, beside, roots[..., axis]) for axis in (0, 1)], axis=-1)
    own_speeds = tracks.at(owners, beside, speeds)
    steps = TrackSteps(
        first=first,
        sides=sides,
        points=_beside(middles, headings, sides, body.step_width),
        yaws=headings,
        strike_times=strikes,
        liftoff_times=_liftoffs(strikes, own_speeds, first, rule),
        widths=np.full(len(sides), NARROW * body.step_width),
        lead=lead * time_step,
    )
    return uncross(steps)


def join_steps(parts: Sequence[TrackSteps], people: Sequence[IntArray]) -> TrackSteps:
    """The footsteps of several groups in the order of all.

    Args:
        parts: Of each group, with the same lead.
        people: Numbers of its members, from 0 to N - 1 over all groups.
    """
    counts = np.zeros(sum(len(numbers) for numbers in people), dtype=int)
    for part, numbers in zip(parts, people, strict=True):
        counts[numbers] = np.diff(part.first)
    owners = np.concatenate([numbers[part.owners] for part, numbers in zip(parts, people, strict=True)])
    order = np.argsort(owners, kind="stable")

    def joined(name: str) -> np.ndarray:
        return np.concatenate([getattr(part, name) for part in parts])[order]

    return TrackSteps(
        first=np.concatenate([[0], np.cumsum(counts)]),
        sides=joined("sides"),
        points=joined("points"),
        yaws=joined("yaws"),
        strike_times=joined("strike_times"),
        liftoff_times=joined("liftoff_times"),
        widths=joined("widths"),
        lead=parts[0].lead,
    )


def uncross(steps: TrackSteps) -> TrackSteps:
    """The steps with every foot kept on its own side of the other: it comes down further out where it would cross."""
    points = steps.points.copy()
    outward = np.where(steps.sides == LEFT, 1.0, -1.0)
    across = outward[:, None] * planar.direction(steps.yaws + 0.5 * np.pi)
    most = int(np.diff(steps.first).max())
    for number in range(1, most):
        rows = steps.first[:-1] + number
        rows = rows[rows < steps.first[1:]]
        apart = np.sum((points[rows] - points[rows - 1]) * across[rows], axis=1)
        points[rows] += np.maximum(steps.widths[rows] - apart, 0.0)[:, None] * across[rows]
    return replace(steps, points=points)


@dataclass(frozen=True, kw_only=True)
class _Tracks:
    """Samples of N tracks looked up at any time, all at once."""

    phases: FloatArray
    """Steps taken until each sample, shape (T, N)."""
    time_step: float
    """[s]"""

    def at(self, owners: IntArray, times: FloatArray, values: FloatArray) -> FloatArray:
        """Values (T, N) of people `owners` (S,) at times (S,) [s], straight between samples, shape (S,)."""
        where = np.clip(times / self.time_step, 0.0, len(values) - 1.0)
        before = np.minimum(where.astype(int), len(values) - 2)
        share = where - before
        return (1.0 - share) * values[before, owners] + share * values[before + 1, owners]

    def times(self, owners: IntArray, phases: FloatArray) -> FloatArray:
        """When people `owners` (S,) reach phases (S,), at the latest at the tracks' end [s]; shape (S,)."""
        count, most = len(self.phases), self.phases.max() + GAP
        axis = (self.phases + most * np.arange(self.phases.shape[1])).T.ravel()
        samples = np.interp(phases + most * owners, axis, np.arange(axis.size)) - owners * count
        return self.time_step * np.clip(samples, 0.0, count - 1.0)


def _facing(velocities: FloatArray, yaws: FloatArray, time_step: float, lead: int) -> FloatArray:
    """Where people face at every sample, continuous [rad], shape (T, N).

    It is the direction of the velocity averaged over a second or two, kept while they stand; before the tracks begin
    they turn into it from where they look.
    """
    mean = gaussian_filter1d(velocities[lead:], FACING / time_step, axis=0, mode="nearest")
    moving = np.linalg.norm(mean, axis=2) > 0.5 * STILL
    samples = np.arange(len(mean))[:, None]
    last = np.maximum.accumulate(np.where(moving, samples, -1), axis=0)
    ever = moving.any(axis=0)
    last = np.where(last < 0, np.argmax(moving, axis=0), last)
    directions = planar.yaw_of(np.take_along_axis(mean, last[..., None], axis=0))
    directions = np.where(ever, directions, np.where(np.isnan(yaws), 0.0, yaws))
    directions = np.unwrap(directions, axis=0)
    begin = np.where(np.isnan(yaws), directions[0], yaws)
    turns = planar.wrap_angle(begin - directions[0])
    shares = np.linspace(0.0, 1.0, lead, endpoint=False)[:, None]
    eased = shares * shares * (3.0 - 2.0 * shares)
    return np.concatenate([directions[0] + (1.0 - eased) * turns, directions])


def _cadences(speeds: FloatArray, facing: FloatArray, time_step: float, rule: TimingRule) -> FloatArray:
    """Steps a second at every sample, shape (T, N)."""
    longest = 1.0 / rule.longest_step
    walking = np.maximum(speeds, 1e-6) / np.maximum(natural_lengths(speeds.ravel(), rule).reshape(speeds.shape), 1e-6)
    walking = np.where(speeds > STILL, np.maximum(walking, longest), 0.0)
    turning = np.abs(np.gradient(facing, time_step, axis=0)) / TURN
    rates = np.maximum(walking, np.where(turning > 0.1, np.maximum(turning, longest), 0.0))
    reach = 2 * round(CLOSING * rule.longest_step / time_step) + 1
    after = maximum_filter1d(rates, reach, axis=0, origin=reach // 2, mode="constant")  # of the time before
    return np.where(rates > 0.0, rates, np.where(after > 0.0, longest, 0.0))


def _beside(middles: FloatArray, headings: FloatArray, sides: IntArray, width: float) -> FloatArray:
    """Places of feet to either side of the middle, shape (S, 2)."""
    outward = np.where(sides == LEFT, 0.5, -0.5)
    return middles + (outward * width)[:, None] * planar.direction(headings + 0.5 * np.pi)


def _liftoffs(strikes: FloatArray, speeds: FloatArray, first: IntArray, rule: TimingRule) -> FloatArray:
    """Each foot leaves when the overlap after the next strike is over, after a stand just in time for its next step."""
    speeds = np.maximum(np.append(speeds[2:], speeds[-2:]), 1e-3)  # of the step that ends the swing
    natural = np.minimum(rule.longest_step, natural_lengths(speeds, rule) / speeds)
    other, same = np.append(strikes[1:], strikes[-1]), np.append(strikes[2:], strikes[[-1, -1]])
    shares = np.maximum(overlap_shares(speeds, rule), 0.05)
    spans = np.minimum(natural, same - other)
    liftoffs = np.maximum(other + shares * spans, same - np.maximum(1.0 - shares, SWING) * natural)
    swings = np.minimum(QUICKEST * rule.longest_step, 0.85 * (same - other))
    liftoffs = np.maximum(np.minimum(liftoffs, same - swings), strikes + 0.05)
    last = first[1:] - 1
    liftoffs[last] = strikes[last] + STAND
    liftoffs[last - 1] = liftoffs[last]
    return liftoffs
