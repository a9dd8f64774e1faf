"""Interactive mode: with every new footprint one more step is optimised, the one before it ([P] 4.2)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import warp as wp

from usdfoot.maths.types import FloatArray
from usdfoot.model.contact_table import ContactTable, lay_contacts, stay_down
from usdfoot.model.plan import FootstepPlan
from usdfoot.physics.biped import PhysicsBiped
from usdfoot.physics.contact_kernel import AgentRow, ContactArrays, ContactFooting, ContactRow
from usdfoot.physics.footing import Footing, device_legs, lay_footing
from usdfoot.physics.interactive_kernel import solve_window
from usdfoot.physics.knot_kernel import KnotOptions
from usdfoot.physics.optimise import ComMotion, solve_motion, start_unknowns
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.run_up import extend_contacts, has_steady_end
from usdfoot.physics.samples import SAMPLES, Samples
from usdfoot.physics.shared_arrays import shared_record
from usdfoot.physics.spline import ComSpline, Knots, hermite_basis, lay_knots
from usdfoot.physics.step_room import WINDOW, StepRoom, make_step_room
from usdfoot.physics.support import Stance

__all__ = ["StepOptimiser"]

TOLERANCE = 1e-3
"""Relative decrease of E that is not worth another iteration."""
ROOM = 64
"""Knots that there is room for at first."""


class StepOptimiser:
    """Optimises one character step by step; the arrays it works in are laid out once, what it gives back is its own."""

    def __init__(self, biped: PhysicsBiped, options: PhysicsOptions | None = None) -> None:
        """For a character.

        Args:
            biped: The character.
            options: How to optimise; `run_up` strides are expected after the newest footstep.
        """
        options = options or PhysicsOptions()
        self.biped = biped
        self.options = replace(options, tolerance=max(options.tolerance, TOLERANCE))
        self._legs = device_legs(biped, options)
        self._divisions = shared_record(KnotOptions, {"parts": options.parts, "longest": options.longest_segment})
        self._room = make_step_room(ROOM, self.options)

    def optimise_step(self, plan: FootstepPlan, *, before: ComMotion | None = None) -> ComMotion:
        """Centre of mass of step n - 1, and of what is expected after it, when footstep n is new.

        What was executed stays: step n - 1 begins with the position and velocity in which `before` has it begin. The
        steps after footstep n are expected to repeat the last stride and optimised too, so that step n - 1 prepares
        them; the next call replaces them. Executed so, a plan stays within 2 cm of its whole optimum on even walks and
        turns, within 3 cm on runs, and within 8 cm where steps of a walk differ by up to half their length.

        Args:
            plan: The last footsteps up to footstep n; `WINDOW` of them are used, however long the plan has become.
            before: Returned for footstep n - 1; None = the plan begins here, all of its steps are optimised.
        """
        if before is None or self.options.solver == "greedy" or len(plan) < 3:
            return self._optimise_anew(plan, before)
        if plan.ends_standing:
            return self._optimise_window(plan, before)
        strikes, liftoffs = plan.strike_times[-3:], plan.liftoff_times[-3:].copy()
        liftoffs[-1] = stay_down(strikes[-2:], liftoffs[-2:])
        if self.options.run_up > 0 and has_steady_end(strikes, liftoffs):
            return self._optimise_window(plan, before, expected=2 * self.options.run_up, leaves=liftoffs[-1])
        return self._optimise_anew(plan, before)

    def _optimise_anew(self, plan: FootstepPlan, before: ComMotion | None) -> ComMotion:
        """The same for a plan's begin and for ends that no stride can follow, by way of the tables of whole plans."""
        options = self.options
        extended = extend_contacts(lay_contacts([plan]), strides=options.run_up)
        if before is not None:
            last = np.flatnonzero(extended.steps >= 0)[-2]
            extended = replace(extended, starts=extended.strikes[last : last + 1])
        footing = lay_footing(extended, self.biped, options)
        knots = lay_knots(extended, footing, parts=options.parts, longest_segment=options.longest_segment)
        start = start_unknowns(extended, knots, self.biped)
        if before is not None:
            start[0] = _state_at(before, knots.times[0])
            knots = replace(knots, fixed=knots.fixed | (np.arange(len(knots.times)) == 0)[:, None])
        return solve_motion(extended, footing, knots, start=start, biped=self.biped, options=options)

    def _optimise_window(
        self, plan: FootstepPlan, before: ComMotion, *, expected: int = 0, leaves: float | None = None
    ) -> ComMotion:
        """The same in one launch, with `expected` contacts after the last footstep, which `leaves` the ground then."""
        real = min(len(plan), WINDOW)
        contacts, kinds = ContactArrays(), (ContactRow, ContactFooting)
        contacts.rows, footings = (wp.empty(real + expected, dtype=kind, device="cpu") for kind in kinds)
        contacts.agents = wp.empty(1, dtype=AgentRow, device="cpu")
        footing = Footing(contacts=contacts, legs=self._legs, rows=footings)
        state = _state_at(before, plan.strike_times[-2])
        while True:
            room = self._room
            room.unknowns[0] = state
            room.take_footsteps(plan, real, leaves=leaves)
            inputs = [contacts, self._legs, footing.rows, self._divisions, room.window, room.problem, room.work]
            wp.launch(solve_window, dim=1, inputs=inputs, device="cpu")
            count = int(room.count[0])
            if count <= len(room.unknowns):
                break
            self._room = make_step_room(2 * count, self.options)
        table = _window_table(contacts.rows.numpy(), room.knot_times[[0, count - 1]], room.headings, real)
        return _motion(table, footing, room, count, self.biped, self.options)


def _state_at(before: ComMotion, time: float) -> FloatArray:
    """Position and velocity of the centre of mass, shape (6,)."""
    spline, times = before.spline, before.spline.knots.times
    segment = min(max(int(np.searchsorted(times, time, side="right")) - 1, 0), len(times) - 2)
    length = times[segment + 1] - times[segment]
    basis = hermite_basis(np.clip((time - times[segment]) / length, 0.0, 1.0), length)[:2]
    ends = slice(segment, segment + 2)
    return (basis[:, 0::2] @ spline.positions[ends] + basis[:, 1::2] @ spline.velocities[ends]).ravel()


def _window_table(rows: np.ndarray, times: FloatArray, yaws: FloatArray, real: int) -> ContactTable:
    """The contacts of the window, the first `real` of which are footsteps.

    Args:
        rows: Of the kind of `ContactRow`, shape (C,).
        times: Begin and end [s], shape (2,).
        yaws: Of the contacts, continuous, and what is left of the room for them [rad], shape (C or more,).
        real: Footsteps.
    """
    index = np.arange(len(rows))
    yaws = yaws[: len(rows)]
    headings = yaws.copy()
    headings[1:] = 0.5 * (yaws[1:] + yaws[:-1])
    headings[0] = headings[1]
    return ContactTable(
        first=np.array([0, len(rows)]),
        agents=np.zeros_like(index),
        steps=np.where(index < real, index, -1),
        sides=rows["side"], positions=rows["position"], yaws=rows["yaw"], normals=rows["normal"],
        strikes=rows["strike"], liftoffs=rows["liftoff"],
        headings=headings,
        starts=times[:1], ends=times[1:],
    )  # fmt: skip


def _motion(
    contacts: ContactTable, footing: Footing, room: StepRoom, count: int, biped: PhysicsBiped, options: PhysicsOptions
) -> ComMotion:
    """The motion solved in the room's first `count` knots."""
    segments = count - 1
    times, unknowns = room.knot_times[:count].copy(), room.unknowns[:count].copy()
    knots = Knots(
        agents=np.zeros(count, dtype=int), times=times, starts=contacts.starts, fixed=room.fixed[:count].copy(),
        begins=np.arange(segments),
    )  # fmt: skip
    instants = segments * SAMPLES
    stance = Stance(**{name: values[:instants].copy() for name, values in vars(room.stance).items()})
    return ComMotion(
        contacts=contacts,
        biped=biped,
        options=options,
        spline=ComSpline(knots=knots, positions=unknowns[:, :3], velocities=unknowns[:, 3:]),
        footing=footing,
        scripts=(),
        samples=Samples(
            times=room.times[:instants].reshape(segments, SAMPLES).copy(),
            intervals=np.diff(times) / SAMPLES,
            stance=stance,
        ),
    )
