"""Ten instants a segment at which physics and comfort are judged ([P] 2.4.3)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.physics.biped import PhysicsBiped
from usdfoot.physics.heading import FootHeadings, OrientationScript, body_orientations
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.spline import Knots, hermite_basis
from usdfoot.physics.support import find_stance

__all__ = ["SAMPLES", "Samples", "lay_samples"]

SAMPLES = 10
"""Instants a segment, in the middle of equal parts."""


@dataclass(frozen=True, kw_only=True)
class Samples:
    """What E depends on beside the spline: N instants of each of S segments. Leg axes are (left, right)."""

    times: FloatArray
    """[s], shape (S, N)."""
    intervals: FloatArray
    """Time each instant stands for [s], shape (S,)."""
    basis: FloatArray
    """Position and acceleration from the segment's begin position, begin velocity, end position, end velocity,
    shape (S, N, 2, 4)."""
    contacts: IntArray
    """Contact that each foot stands in, or stood in last, shape (S, N, 2)."""
    standing: BoolArray
    """Whether the foot is on the ground, shape (S, N, 2)."""
    supports: FloatArray
    """Points of support [m], world, shape (S, N, 2, 3)."""
    anchors: FloatArray
    """Ankle minus the hip's place relative to the centre of mass: the virtual leg ends there and at the centre of mass
    [m], world, shape (S, N, 2, 3)."""
    nominal_lengths: FloatArray
    """Comfortable lengths of the virtual legs [m], shape (S, N, 2)."""


def lay_samples(
    contacts: ContactTable,
    knots: Knots,
    biped: PhysicsBiped,
    headings: FootHeadings,
    scripts: Sequence[OrientationScript | None],
    options: PhysicsOptions,
) -> Samples:
    """Samples of all segments."""
    segments = len(knots.begins)
    shares = (np.arange(SAMPLES) + 0.5) / SAMPLES
    durations = knots.durations[:, None]
    times = knots.times[knots.begins][:, None] + durations * shares
    basis = hermite_basis(np.broadcast_to(shares, times.shape), np.broadcast_to(durations, times.shape))[[0, 2]]
    agents = np.repeat(knots.agents[knots.begins], SAMPLES)
    flat = times.ravel()
    stance = find_stance(contacts, biped, agents, flat, smooth=options.support == "smooth")
    body = body_orientations(headings, scripts, agents, flat, window=options.heading_window)
    hips = quaternion.rotate(body[:, None], biped.hips)
    shape = (segments, SAMPLES, 2)
    return Samples(
        times=times,
        intervals=durations[:, 0] / SAMPLES,
        basis=np.ascontiguousarray(np.moveaxis(basis, 0, 2)),
        contacts=stance.contacts.reshape(shape),
        standing=stance.standing.reshape(shape),
        supports=stance.supports.reshape(*shape, 3),
        anchors=(stance.ankles - hips).reshape(*shape, 3),
        nominal_lengths=np.full(shape, biped.nominal_length),
    )
