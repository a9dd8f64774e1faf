"""How people hold the standing leg: bent in early stance, long in late stance, over a foot that rolls.

With a constant nominal length a body would not rise over the standing leg as people do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.physics.biped import PhysicsBiped

__all__ = ["ContactGaits", "foot_pitches", "measure_gaits", "nominal_lengths", "rolled_ankles"]

PHASES = np.linspace(0.0, 1.0, 11)
WALK_FLEXIONS = np.radians([5.0, 11.0, 17.0, 18.0, 15.0, 11.0, 8.0, 6.0, 5.0, 8.0, 15.0])
"""Knee over the contact of a walk, until the weight is off it (Winter 1991, Figure 3.32; Perry 1992)."""
BENT = np.radians(18.0)
"""Its value in early stance, where the leg has its nominal length."""
RUN_FLEXIONS = np.radians([20.0, 28.0, 35.0, 39.0, 40.0, 38.0, 34.0, 29.0, 24.0, 20.0, 18.0])
"""Over the contact of a run, less 20 degrees (Novacheck 1998, Figure 5)."""
PITCH_PHASES = np.array([0.0, 0.15, 0.5, 0.7, 0.85, 1.0])
PITCHES = np.radians([20.0, 0.0, 0.0, -5.0, -17.0, -40.0])
"""Foot over the contact of a long step, positive with the toes up (Perry 1992: heel, ankle and forefoot rocker)."""
WALK_FLIGHT = 0.1
RUN_FLIGHT = 0.25
"""Part of a step that a flight takes, at most in a walk and at least in a run. By the ball's contacts walks seem to
have short flights."""
STAIR_BEND = 0.6
"""Part of a stair's height by which the upper leg is shorter while both stand (Riener et al. 2002)."""
LONG_STEP = 0.8
"""Such a step, as a part of the leg's length."""


@dataclass(frozen=True, kw_only=True)
class ContactGaits:
    """What kind of step each contact belongs to, shape (C,) each."""

    alignments: FloatArray
    """Cosine between the foot's heading and the way the body travels over it."""
    reaches: FloatArray
    """Mean distance to the contacts before and after, as a part of the leg's length."""
    lands: FloatArray
    """How much a flight ends with its strike: 1 if it takes a quarter of the step or more."""
    leaps: FloatArray
    """How much a flight begins with its liftoff."""
    rises: FloatArray
    """Height gained from the contact before, 0 when lost [m]."""
    drops: FloatArray
    """Height lost to the contact after, 0 when gained [m]."""
    begins: BoolArray
    """Whether it stands on both feet when the motion begins."""
    ends: BoolArray
    """Whether it stands when the motion ends."""


def measure_gaits(contacts: ContactTable, leg_length: float) -> ContactGaits:
    """Kinds of all contacts, for legs of `leg_length` [m]."""
    index = np.arange(len(contacts.sides))
    has_previous, has_next = contacts.has_previous, contacts.has_next
    before, after = np.where(has_previous, index - 1, index), np.where(has_next, index + 1, index)
    travel = (contacts.positions[after] - contacts.positions[before])[:, [0, 2]]
    distance = np.linalg.norm(travel, axis=1)
    along = np.sum(travel * planar.direction(contacts.yaws), axis=1)
    together = has_previous & (contacts.strikes == contacts.strikes[before])
    first = ~has_previous & (contacts.strikes <= contacts.starts[contacts.agents])
    steps = np.maximum(has_previous.astype(int) + has_next, 1)
    return ContactGaits(
        alignments=np.divide(along, distance, out=np.zeros_like(along), where=distance > 1e-9),
        reaches=distance / steps / leg_length,
        lands=_flight_share(contacts, before, index),
        leaps=_flight_share(contacts, index, after),
        rises=np.maximum(contacts.positions[:, 1] - contacts.positions[before, 1], 0.0),
        drops=np.maximum(contacts.positions[:, 1] - contacts.positions[after, 1], 0.0),
        begins=together | first,
        ends=(contacts.liftoffs >= contacts.ends[contacts.agents]) & ~contacts.has_swing,
    )


def _flight_share(contacts: ContactTable, before: IntArray, after: IntArray) -> FloatArray:
    """How much the step between two contacts is a running step, 0 to 1."""
    step = contacts.strikes[after] - contacts.strikes[before]
    flight = contacts.strikes[after] - contacts.liftoffs[before]
    share = np.divide(flight, step, out=np.zeros_like(step), where=step > 0.0)
    return np.clip((share - WALK_FLIGHT) / (RUN_FLIGHT - WALK_FLIGHT), 0.0, 1.0)


def nominal_lengths(
    biped: PhysicsBiped, gaits: ContactGaits, contacts: IntArray, progress: FloatArray, *, play: float
) -> FloatArray:
    """Comfortable lengths of the legs [m], shape as `contacts`.

    The knee bends over the contact by published figures, around the bend of the nominal length, which is that of early
    stance. On stairs and slopes the leg on the higher foot is shorter while the weight changes over.

    Args:
        biped: Leg lengths.
        gaits: Of all contacts.
        contacts: Contact each leg stands in, any shape.
        progress: Part of the contact passed, the same shape.
        play: Share of the figures to use; 0 = constant length as in [P].
    """
    bend = 2.0 * np.arccos(np.clip(biped.nominal_length / biped.maximal_length, -1.0, 1.0))
    walk = np.interp(progress, PHASES, WALK_FLEXIONS) - BENT
    run = np.interp(progress, PHASES, RUN_FLEXIONS) - BENT
    share = 0.5 * (gaits.lands[contacts] + gaits.leaps[contacts])
    flexion = bend + play * (walk + share * (run - walk))
    lengths = biped.maximal_length * np.cos(0.5 * np.maximum(flexion, 0.0))
    early, late = np.maximum(1.0 - 2.0 * progress, 0.0), np.maximum(2.0 * progress - 1.0, 0.0)
    bent = gaits.rises[contacts] * early**2 * (3.0 - 2.0 * early) + gaits.drops[contacts] * late**2 * (3.0 - 2.0 * late)
    return np.maximum(lengths - STAIR_BEND * play * bent, 0.3 * biped.nominal_length)


def foot_pitches(gaits: ContactGaits, contacts: IntArray, progress: FloatArray) -> FloatArray:
    """Pitch of the feet about heel or ball, positive with the toes up [rad], shape as `contacts`.

    Short steps roll less; backward steps roll the other way round, and side steps not at all.
    """
    alignment = gaits.alignments[contacts]
    phase = np.where(alignment < 0.0, 1.0 - progress, progress)
    size = np.minimum(gaits.reaches[contacts] / LONG_STEP, 1.0) * np.abs(alignment)
    pitches = size * np.interp(phase, PITCH_PHASES, PITCHES)
    begins, ends = gaits.begins[contacts], gaits.ends[contacts]
    pitches = np.where(pitches > 0.0, pitches * (1.0 - gaits.lands[contacts]), pitches)
    return np.where((begins & (pitches > 0.0)) | (ends & (pitches < 0.0)), 0.0, pitches)


def rolled_ankles(biped: PhysicsBiped, pitches: FloatArray) -> FloatArray:
    """Ankles in the prints' frames with the feet rolled about heel or ball [m], shape (F, 2, 3) for pitches (F, 2)."""
    pivots = np.where(pitches > 0.0, biped.heel, 0.0)
    x, y, z = (np.broadcast_to(biped.ankles[:, axis], pitches.shape) for axis in range(3))
    ahead = z - pivots
    cosine, sine = np.cos(pitches), np.sin(pitches)
    return np.stack([x, y * cosine + ahead * sine, pivots + ahead * cosine - y * sine], axis=-1)
