"""Ten instants a segment at which physics and comfort are judged ([P] 2.4.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.physics.biped import HUMAN_LEG
from usdfoot.physics.footing import Footing
from usdfoot.physics.heading import FootHeadings, OrientationScript, body_orientations
from usdfoot.physics.spline import Knots
from usdfoot.physics.support import find_stance

__all__ = ["SAMPLES", "Samples", "instant_shares", "lay_samples", "take_segments"]

SAMPLES = 10
"""Instants a segment, in the middle of equal parts."""


@dataclass(frozen=True, kw_only=True)
class Samples:
    """What E depends on beside the spline: N instants of each of S segments, M = S N. Legs are (left, right)."""

    times: FloatArray
    """[s], shape (S, N)."""
    intervals: FloatArray
    """Time each instant stands for [s], shape (S,)."""
    contacts: IntArray
    """Contact that each foot carries in, or carried in last, shape (M, 2)."""
    standing: BoolArray
    """Whether the foot carries weight, shape (M, 2)."""
    leg_shares: FloatArray
    """Weight of each leg's comfort, of a leg of 0.86 m: its share of the body's weight, shape (M, 2)."""
    supports: FloatArray
    """Points of support [m], world, shape (M, 2, 3)."""
    anchors: FloatArray
    """Ankle minus the hip's place relative to the centre of mass: the virtual leg leads from there to the centre of
    mass [m], world, shape (M, 2, 3)."""
    nominal_lengths: FloatArray
    """Comfortable lengths of the virtual legs [m], shape (M, 2)."""


def lay_samples(
    footing: Footing, knots: Knots, headings: FootHeadings, scripts: Sequence[OrientationScript | None]
) -> Samples:
    """Samples of all segments."""
    durations = knots.durations
    times = knots.times[knots.begins][:, None] + durations[:, None] * instant_shares(SAMPLES)
    agents = np.repeat(knots.agents[knots.begins], SAMPLES)
    flat = times.ravel()
    stance = find_stance(footing, agents, flat)
    body = body_orientations(headings, scripts, agents, flat, window=footing.options.heading_window)
    return Samples(
        times=times,
        intervals=durations / SAMPLES,
        contacts=stance.contacts,
        standing=stance.standing,
        leg_shares=(HUMAN_LEG / footing.biped.maximal_length) ** 2 * stance.weights,
        supports=stance.supports,
        anchors=stance.ankles - quaternion.rotate(body[:, None], footing.biped.hips),
        nominal_lengths=stance.nominal_lengths,
    )


def instant_shares(count: int) -> FloatArray:
    """Parts of a segment passed at its instants, shape (count,)."""
    return (np.arange(count) + 0.5) / count


def take_segments(samples: Samples, segments: IntArray) -> Samples:
    """The samples of some segments (T,), in their order."""
    count, instants = samples.times.shape
    rows = (segments[:, None] * instants + np.arange(instants)).ravel()
    values = {field.name: getattr(samples, field.name) for field in fields(Samples)}
    return Samples(**{name: value[segments if len(value) == count else rows] for name, value in values.items()})
