"""What each step's motion violates: physics, the leg's length, common sense."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.timeline import locate
from usdfoot.maths.types import FloatArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.physics.biped import PhysicsBiped
from usdfoot.physics.energy import FLIGHT, leg_forces, spline_samples
from usdfoot.physics.samples import Samples
from usdfoot.physics.spline import Knots

__all__ = ["StepForces", "measure_forces"]


@dataclass(frozen=True, kw_only=True)
class StepForces:
    """Figures of every contact from its strike to the next, shape (C,) each; 0 outside the motion."""

    force_imbalance: FloatArray
    """[P]'s external force per unit mass that the motion needs, mean [m/s^2]; gravity is 9.81."""
    clamp_time: FloatArray
    """Time in which the standing legs would have to pull [s]."""
    jump_height: FloatArray
    """How far the centre of mass rises after the takeoff of the step's flight [m]."""
    overstretch: FloatArray
    """How far the virtual leg of this contact is pulled beyond its maximal length, while it stands [m]."""


def measure_forces(
    contacts: ContactTable, knots: Knots, biped: PhysicsBiped, samples: Samples, controls: FloatArray, *, gravity: float
) -> StepForces:
    """Figures of all contacts from the samples of the optimised spline, controls (S, 4, 3)."""
    positions, accelerations = spline_samples(samples, controls)
    forces = leg_forces(samples.supports, samples.standing, positions, accelerations, gravity)
    count, shape = len(contacts.sides), samples.times.shape
    agents = np.repeat(knots.agents[knots.begins], shape[1])
    rows = locate(contacts.agents, contacts.strikes, contacts.starts, agents, samples.times.ravel())
    lasting = np.broadcast_to(samples.intervals[:, None], shape)
    imbalance = lasting * np.linalg.norm(forces.residuals, axis=-1)
    stands = samples.standing.any(axis=-1)
    clamped = np.where(stands & (forces.faces == FLIGHT), lasting, 0.0)
    time = np.bincount(rows, lasting.ravel(), count)
    rise = np.where(stands, 0.0, positions[..., 1] - controls[:, 0, 1][:, None])
    jump, overstretch = np.zeros(count), np.zeros(count)
    np.maximum.at(jump, rows, rise.ravel())
    lengths = np.linalg.norm(positions[..., None, :] - samples.anchors, axis=-1)
    excess = np.where(samples.standing, lengths - biped.maximal_length, 0.0)
    np.maximum.at(overstretch, samples.contacts.reshape(-1, 2), excess.reshape(-1, 2))
    return StepForces(
        force_imbalance=np.bincount(rows, imbalance.ravel(), count) / np.maximum(time, 1e-9),
        clamp_time=np.bincount(rows, clamped.ravel(), count).astype(float),
        jump_height=jump,
        overstretch=overstretch,
    )
