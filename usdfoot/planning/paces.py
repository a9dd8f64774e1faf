"""Paces: how long the steps along ways take, and when feet strike and leave ([P] 2.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.contact_table import EDGE_HEIGHT
from usdfoot.model.ground import Ground
from usdfoot.planning.gait import Gait, overlap_shares
from usdfoot.planning.prints import STEP_UP
from usdfoot.planning.ways import Ways

__all__ = ["Paces", "pace_steps", "stance_times", "swing_lifts"]

STRETCH = 0.2
"""A step that is longer or shorter than it should be takes longer or shorter, up to this part."""
SWING = 0.4
"""A walking foot swings at least this long on level ground, for a leg of 0.86 m [s]."""
LIFT = 0.5
"""And longer for what it rises and falls [s/m]."""
BETWEEN = np.linspace(0.0, 1.0, 18)[1:-1, None, None]
"""Parts of a foot's way at which the ground under it is looked at."""
LEAST_OVERLAP = 0.1
"""Least double support of a walking step over its time."""


@dataclass(frozen=True, kw_only=True)
class Paces:
    """Times of the steps to N footsteps; those of first footsteps mean nothing."""

    durations: FloatArray
    """Strike before to strike [s], shape (N,)."""
    overlaps: FloatArray
    """Double support after the strike, negative: flight before it [s], shape (N,)."""


def pace_steps(ways: Ways, gaits: list[Gait], *, rows: IntArray, arcs: FloatArray, lifts: FloatArray) -> Paces:
    """Times of steps along ways.

    A step takes the gait's time, longer where steps are shorter since the walk ratio holds. Up, down or over an edge it
    takes no less than that however short it is, nor less than a walking foot needs to swing; how long both feet stand
    follows from the speed there, and from that time. Who runs leaps over what is farther than the legs span.

    Args:
        ways: All ways.
        gaits: Of each way's walker.
        rows: Way of each footstep, shape (N,).
        arcs: Where along it [m], shape (N,).
        lifts: As from `swing_lifts`, shape (N,).
    """
    known = {gait: gait.longest_time for gait in dict.fromkeys(gaits)}
    lengths, times, longest, quickest = (
        np.array(values)[rows]
        for values in (
            [gait.step_length for gait in gaits],
            [gait.step_time for gait in gaits],
            [known[gait] for gait in gaits],
            [gait.quickest_time for gait in gaits],
        )
    )
    previous = np.concatenate([arcs[:1], arcs[:-1]])
    shares = ways.at(rows, 0.5 * (arcs + previous), ways.shares)
    local = np.minimum(times / shares, np.maximum(times, longest))
    stretches = np.clip((arcs - previous) / (lengths * shares), 1.0 - STRETCH, 1.0 + STRETCH)
    durations = np.maximum(np.where(arcs > previous, local * stretches, local), quickest)
    speeds, parts = lengths * shares / local, np.empty(len(rows))
    walked, runs = (
        np.array(values)[rows]
        for values in ([gait.walked_length for gait in gaits], [gait.speed > gait.fastest_walk for gait in gaits])
    )
    leaps = runs & (arcs - previous > walked)
    for rule in dict.fromkeys(gait.rule for gait in gaits):
        own = np.array([gait.rule == rule for gait in gaits])[rows]
        parts[own] = overlap_shares(speeds[own], rule, leaps=leaps[own])
    level, edges = SWING * longest / 0.7, (parts > 0.0) & (lifts > EDGE_HEIGHT)
    least = np.maximum(local, np.minimum(local, level / (1.0 - LEAST_OVERLAP)) + LIFT * lifts)
    durations = np.where(edges, np.maximum(durations, least), durations)
    overlaps, swings = parts * durations, level + LIFT * lifts
    limits = np.maximum(np.roll(durations - swings, -1), LEAST_OVERLAP * durations)  # the swing is in the next step
    limits[-1] = durations[-1]
    return Paces(durations=durations, overlaps=np.where(overlaps > 0.0, np.minimum(overlaps, limits), overlaps))


def swing_lifts(rows: IntArray, positions: FloatArray, ground: Ground) -> FloatArray:
    """How far each foot has to rise and fall from where it stood before, over what lies between, [m], shape (N,).

    Args:
        rows: Way of each footstep, shape (N,).
        positions: Of the prints [m], shape (N, 3).
        ground: The terrain.
    """
    lifts, swung = np.zeros(len(rows)), 2 + np.flatnonzero(rows[2:] == rows[:-2])
    starts, ends = positions[swung - 2], positions[swung]
    tops = np.maximum(starts[:, 1], ends[:, 1])
    if ground.has_terrain:
        between = starts + BETWEEN * (ends - starts)  # (K, S, 3)
        near = np.broadcast_to(tops, between.shape[:-1])
        under = ground.heights(between[..., [0, 2]].reshape(-1, 2), near.ravel(), step_up=STEP_UP)
        heights = np.where(under.hit, under.heights, -np.inf).reshape(near.shape)
        tops = np.maximum(tops, heights.max(axis=0))
    lifts[swung] = 2.0 * tops - starts[:, 1] - ends[:, 1]
    return lifts


def stance_times(
    paces: Paces, first: IntArray, *, starts_standing: bool, ends_standing: bool, stand_time: float
) -> tuple[FloatArray, FloatArray]:
    """Strikes and liftoffs from each plan's start [s], shape (N,) each.

    Args:
        paces: Of all footsteps.
        first: Index of each plan's first footstep, shape (P + 1,); the last entry is N.
        starts_standing: Both first feet stand from the start.
        ends_standing: Both last feet stand to the end.
        stand_time: How long they stand [s].
    """
    begins, last = first[:-1], first[1:] - 1
    pieces = paces.durations.copy()
    pieces[begins] = 0.0
    if starts_standing:
        pieces[begins + 1] = 0.0
        pieces[begins + 2] += stand_time
    strikes = np.cumsum(pieces)
    strikes -= np.repeat(strikes[begins], np.diff(first))
    liftoffs = np.roll(strikes + paces.overlaps, -1)
    liftoffs[last] = strikes[last] + paces.durations[last] + paces.overlaps[last]
    if starts_standing:
        leaving = begins + 2
        liftoffs[begins] = strikes[leaving] - paces.durations[leaving] + 0.5 * np.maximum(paces.overlaps[leaving], 0.0)
    if ends_standing:
        liftoffs[last] = strikes[last] + stand_time
        liftoffs[last - 1] = liftoffs[last]
    return strikes, liftoffs
