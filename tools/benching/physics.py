"""Milliseconds the centre of mass takes: whole plans, many agents, and one step more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benching.stopwatch import best_time
from usdfoot.analysis.footstep_times import time_footsteps
from usdfoot.maths import quaternion
from usdfoot.model.plan import FootstepPlan
from usdfoot.physics.biped import PhysicsBiped
from usdfoot.physics.interactive import StepOptimiser
from usdfoot.physics.optimise import optimise_com
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.step_room import WINDOW

__all__ = ["physics_times"]

STEPS = (12, 100, 1000)
AGENTS = 100


def physics_times(biped: PhysicsBiped) -> dict[str, float]:
    """Milliseconds by length of the plan, with the paper's solver, for a crowd, and for a new footstep."""
    plans = {count: _walk(count) for count in STEPS}
    shortest = plans[STEPS[0]]

    def time_plans(agents: list[FootstepPlan], options: PhysicsOptions | None = None) -> float:
        return 1e3 * best_time(lambda: optimise_com(agents, biped, options), repeats=5 if options is None else 1)

    figures = {f"{count} steps": time_plans([plan]) for count, plan in plans.items()}
    figures[f"{AGENTS} agents, {STEPS[0]} steps, each"] = time_plans([shortest] * AGENTS) / AGENTS
    figures[f"{STEPS[0]} steps, greedy"] = time_plans([shortest], PhysicsOptions(solver="greedy", run_up=0))
    stepper = StepOptimiser(biped)
    before = stepper.optimise_step(_part(shortest, WINDOW))
    newest = _part(shortest, WINDOW + 1)
    figures["one footstep more"] = 1e3 * best_time(lambda: stepper.optimise_step(newest, before=before), repeats=20)
    return figures


def _walk(count: int) -> FootstepPlan:
    """A walk along a wide circle."""
    headings = 0.05 * np.arange(count)
    ahead = np.cumsum(0.65 * np.column_stack([np.sin(headings), np.cos(headings)]), axis=0)
    aside = np.where(np.arange(count) % 2 == 0, 0.06, -0.06)
    ground = ahead + aside[:, None] * np.column_stack([np.cos(headings), -np.sin(headings)])
    positions = np.column_stack([ground[:, 0], np.zeros(count), ground[:, 1]])
    times = time_footsteps(positions)
    return FootstepPlan(
        name="/Bench/Plan",
        sides=np.arange(count) % 2,
        positions=positions,
        orientations=quaternion.yaw_quaternion(headings),
        strike_times=times.strike_times,
        liftoff_times=times.liftoff_times,
        root_weights=np.zeros(count),
    )


def _part(plan: FootstepPlan, count: int) -> FootstepPlan:
    """The last footsteps of a plan's first `count`."""
    rows = slice(max(0, count - WINDOW), count)
    return replace(
        plan,
        sides=plan.sides[rows],
        positions=plan.positions[rows],
        orientations=plan.orientations[rows],
        strike_times=plan.strike_times[rows],
        liftoff_times=plan.liftoff_times[rows],
        root_weights=plan.root_weights[rows],
    )
