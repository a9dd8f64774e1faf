"""What each step's motion violates: physics, the leg's length, common sense."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.timeline import locate
from usdfoot.maths.types import FloatArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.physics.biped import PhysicsBiped
from usdfoot.physics.energy import leg_forces, sample_costs, spline_samples
from usdfoot.physics.footing import lay_footing
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.samples import Samples
from usdfoot.physics.spline import ComSpline
from usdfoot.physics.support import find_stance

__all__ = ["StepForces", "measure_forces"]


@dataclass(frozen=True, kw_only=True)
class StepForces:
    """Figures of every contact from its strike to the next, shape (C,) each; 0 outside the motion."""

    force_imbalance: FloatArray
    """[P]'s external force per unit mass that the motion needs, mean [m/s^2]; gravity is 9.81."""
    clamp_time: FloatArray
    """Time in which the standing legs would have to pull [s]."""
    jump_height: FloatArray
    """How far the centre of mass rises after the liftoff into the step's flight [m]."""
    overstretch: FloatArray
    """How far the virtual leg of this contact is pulled beyond its maximal length, while it stands [m]."""


def measure_forces(
    contacts: ContactTable,
    spline: ComSpline,
    *,
    biped: PhysicsBiped,
    samples: Samples,
    options: PhysicsOptions,
) -> tuple[FloatArray, StepForces]:
    """[P]'s E of each agent over its own time (A,), and the figures of all contacts.

    Args:
        contacts: Of the motion, without its run-up.
        spline: As optimised.
        biped: The character.
        samples: Of the spline.
        options: Gravity and comfort.
    """
    knots, controls = spline.knots, spline.controls
    positions, accelerations = spline_samples(samples, controls)
    forces = leg_forces(
        samples.stance.supports,
        samples.stance.standing,
        positions=positions,
        accelerations=accelerations,
        gravity=options.gravity,
    )
    count, instants = len(contacts.sides), samples.times.shape[1]
    agents, times = np.repeat(knots.agents[knots.begins], instants), samples.times.ravel()
    inside = (times >= contacts.starts[agents]) & (times <= contacts.ends[agents])
    lasting = np.where(inside, np.repeat(samples.intervals, instants), 0.0)
    costs = sample_costs(samples, controls, gravity=options.gravity, comfort=options.comfort)
    rows = locate(contacts.agents, contacts.strikes, contacts.starts, agents=agents, times=times)
    imbalance = np.bincount(rows, lasting * np.linalg.norm(forces.residuals, axis=1), count)
    stands = samples.stance.standing.any(axis=1)
    pushing = forces.pushes > 0.0
    pushing[forces.planes] = True
    index = np.arange(count)
    before = np.where(contacts.has_previous, index - 1, index)
    grounded = spline.evaluate(contacts.agents, np.maximum(contacts.liftoffs, contacts.liftoffs[before]))[0][:, 1]
    rises = positions[:, 1] - grounded[rows]
    stretches = np.linalg.norm(positions[:, None] - samples.stance.anchors, axis=-1) - biped.maximal_length
    jump, overstretch = np.zeros(count), np.zeros(count)
    np.maximum.at(jump, rows, np.where(inside & ~stands, rises, 0.0))
    upright = np.tile([0.0, 0.0, 0.0, 1.0], (len(times), 1))
    feet = find_stance(lay_footing(contacts, biped, options), agents=agents, times=times, bodies=upright).contacts
    np.maximum.at(overstretch, feet, np.where(inside[:, None] & samples.stance.standing, stretches, 0.0))
    steps = StepForces(
        force_imbalance=imbalance / np.maximum(np.bincount(rows, lasting, count), 1e-9),
        clamp_time=np.bincount(rows, np.where(stands & ~pushing, lasting, 0.0), count).astype(float),
        jump_height=jump,
        overstretch=overstretch,
    )
    return np.bincount(agents, lasting * costs, len(contacts.starts)).astype(float), steps
