"""The recipe: footstep plans in, the centre of mass of all agents out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from usdfoot.maths.timeline import locate
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable, lay_contacts
from usdfoot.model.plan import FootstepPlan
from usdfoot.physics.biped import PhysicsBiped
from usdfoot.physics.footing import Footing, lay_footing
from usdfoot.physics.greedy import search_unknowns
from usdfoot.physics.heading import OrientationScript, body_orientations
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.results import StepForces, measure_forces
from usdfoot.physics.rhythm import FootRows, Rhythm, lay_foot_rows, rhythm_at
from usdfoot.physics.run_up import extend_contacts
from usdfoot.physics.samples import Samples, lay_samples
from usdfoot.physics.solve import optimise_unknowns
from usdfoot.physics.spline import ComSpline, Knots, lay_knots

__all__ = ["ComMotion", "ComSample", "optimise_com", "optimise_contacts", "solve_motion", "start_unknowns"]


@dataclass(frozen=True, kw_only=True)
class ComSample:
    """The body at F times."""

    positions: FloatArray
    """Centre of mass [m], world, shape (F, 3)."""
    velocities: FloatArray
    """[m/s], shape (F, 3)."""
    accelerations: FloatArray
    """[m/s^2], shape (F, 3)."""
    orientations: FloatArray
    """Body frame to world, xyzw, shape (F, 4)."""


@dataclass(frozen=True, kw_only=True)
class ComMotion:
    """The optimised centre of mass of A agents with one biped."""

    contacts: ContactTable
    """Footsteps and, where a plan begins or ends in mid gait, the contacts around them."""
    biped: PhysicsBiped
    options: PhysicsOptions
    spline: ComSpline
    footing: Footing
    scripts: tuple[OrientationScript | None, ...]
    samples: Samples
    """Where E was evaluated."""

    @cached_property
    def energies(self) -> FloatArray:
        """[P]'s E of each agent over its own time, shape (A,)."""
        return self._figures[0]

    @cached_property
    def steps(self) -> StepForces:
        """What each contact's motion violates."""
        return self._figures[1]

    @cached_property
    def foot_rows(self) -> FootRows:
        """The contacts in the order of each foot."""
        return lay_foot_rows(self.contacts)

    @cached_property
    def _figures(self) -> tuple[FloatArray, StepForces]:
        return measure_forces(self.contacts, self.spline, biped=self.biped, samples=self.samples, options=self.options)

    def evaluate(self, agents: IntArray, times: FloatArray) -> ComSample:
        """The body of `agents` (F,) at `times` (F,) [s]."""
        options = self.options
        positions, velocities, accelerations = self.spline.evaluate(agents, times)
        return ComSample(
            positions=positions,
            velocities=velocities,
            accelerations=accelerations,
            orientations=body_orientations(
                self.footing, self.scripts, agents=agents, times=times, window=options.heading_window
            ),
        )

    def rhythm(self, agents: IntArray, times: FloatArray, yaws: FloatArray) -> Rhythm:
        """What the steps of `agents` (F,) that head for `yaws` [rad] (F,) do to the body at `times` [s] (F,)."""
        length = self.biped.nominal_length
        return rhythm_at(self.contacts, self.foot_rows, agents=agents, times=times, yaws=yaws, leg_length=length)


def optimise_com(
    plans: Sequence[FootstepPlan],
    biped: PhysicsBiped,
    options: PhysicsOptions | None = None,
    *,
    scripts: Sequence[OrientationScript | None] = (),
) -> ComMotion:
    """Centre of mass over footstep plans ([P] 2).

    Args:
        plans: One an agent.
        biped: The character of all agents.
        options: How to optimise.
        scripts: Body orientation of each agent that has one; empty = no agent has.
    """
    return optimise_contacts(lay_contacts(plans), biped, options, scripts=scripts)


def optimise_contacts(
    contacts: ContactTable,
    biped: PhysicsBiped,
    options: PhysicsOptions | None = None,
    *,
    scripts: Sequence[OrientationScript | None] = (),
) -> ComMotion:
    """Centre of mass over contacts, which may have been laid on the ground since they were planned."""
    options = options or PhysicsOptions()
    extended = extend_contacts(contacts, strides=options.run_up)
    footing = lay_footing(extended, biped, options)
    knots = lay_knots(extended, footing, parts=options.parts, longest_segment=options.longest_segment)
    start = start_unknowns(extended, knots, biped)
    return solve_motion(contacts, footing, knots, start=start, biped=biped, options=options, scripts=scripts)


def solve_motion(
    contacts: ContactTable,
    footing: Footing,
    knots: Knots,
    *,
    start: FloatArray,
    biped: PhysicsBiped,
    options: PhysicsOptions,
    scripts: Sequence[OrientationScript | None] = (),
) -> ComMotion:
    """The motion over `contacts`, solved from unknowns `start` (K, 6) at the knots; `footing` is of all contacts."""
    samples = lay_samples(footing, knots, scripts, window=options.heading_window)
    solve = search_unknowns if options.solver == "greedy" else optimise_unknowns
    unknowns = solve(samples, knots, start, options=options)
    return ComMotion(
        contacts=contacts,
        biped=biped,
        options=options,
        spline=ComSpline(knots=knots, positions=unknowns[:, :3], velocities=unknowns[:, 3:]),
        footing=footing,
        scripts=tuple(scripts),
        samples=samples,
    )


def start_unknowns(contacts: ContactTable, knots: Knots, biped: PhysicsBiped) -> FloatArray:
    """[P]'s start: each knot above its footprint by the nominal leg length, tangents zero, shape (K, 6)."""
    rows = locate(contacts.agents, contacts.strikes, contacts.starts, agents=knots.agents, times=knots.times)
    unknowns = np.zeros((len(knots.times), 6))
    unknowns[:, :3] = contacts.positions[rows]
    unknowns[:, 1] += biped.nominal_length + biped.ankles[:, 1].mean() - biped.hips[:, 1].mean()
    return unknowns
