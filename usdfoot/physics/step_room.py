"""The arrays in which one footstep more is optimised, laid out once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.physics.energy_kernel import ProblemArrays
from usdfoot.physics.interactive_kernel import WindowArrays
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.samples import SAMPLES
from usdfoot.physics.shared_arrays import shared_record
from usdfoot.physics.solve import device_work
from usdfoot.physics.solve_kernel import WorkArrays
from usdfoot.physics.stance_kernel import StanceArrays
from usdfoot.physics.support import Stance, empty_stance

__all__ = ["WINDOW", "StepRoom", "make_step_room"]

WINDOW = 4
"""Footsteps of a plan, from its end, that the last steps depend on."""
PLAN_NAMES = {"strikes": "strike_times", "liftoffs": "liftoff_times"}
"""What plans call it otherwise than the kernel."""


@dataclass(frozen=True, kw_only=True)
class StepRoom:
    """Arrays that the kernel works in, for WINDOW footsteps and K knots."""

    footsteps: Mapping[str, np.ndarray]
    """Sides, positions and so on, as in `WindowArrays`."""
    headings: FloatArray
    """Of the feet at WINDOW footsteps and those expected [rad]."""
    count: IntArray
    """Knots in use, shape (1,)."""
    knot_times: FloatArray
    """[s], shape (K,)."""
    times: FloatArray
    """Of the instants [s], shape (K SAMPLES,)."""
    fixed: BoolArray
    """As in `Knots`, shape (K, 2)."""
    unknowns: FloatArray
    """Shape (K, 6)."""
    stance: Stance
    """K SAMPLES instants."""
    window: WindowArrays
    problem: ProblemArrays
    work: WorkArrays

    def take_footsteps(self, plan: FootstepPlan, count: int, *, leaves: float | None = None) -> None:
        """Copies the last footsteps of a plan to where the kernel finds them; the last `leaves` then, or as planned."""
        self.window.real = count
        for name, room in self.footsteps.items():
            room[:count] = getattr(plan, PLAN_NAMES.get(name, name))[-count:]
        if leaves is not None:
            self.footsteps["liftoffs"][count - 1] = leaves


def make_step_room(knots: int, options: PhysicsOptions) -> StepRoom:
    """Room for so many knots."""
    footsteps: dict[str, np.ndarray] = {
        "sides": np.empty(WINDOW, dtype=np.int32),
        "positions": np.empty((WINDOW, 3)),
        "orientations": np.empty((WINDOW, 4)),
        "strikes": np.empty(WINDOW),
        "liftoffs": np.empty(WINDOW),
    }
    headings, count = np.empty(WINDOW + 2 * options.run_up), np.zeros(1, dtype=np.int32)
    knot_times, times = np.empty(knots), np.empty(knots * SAMPLES)
    fixed, unknowns, stance = np.empty((knots, 2), dtype=bool), np.empty((knots, 6)), empty_stance(knots * SAMPLES)
    window: dict[str, object] = {
        **footsteps,
        "window": options.heading_window,
        "tolerance": options.tolerance,
        "headings": headings,
        "knots": count,
        "knot_times": knot_times,
        "times": times,
    }
    problem: dict[str, object] = {
        "instants": SAMPLES,
        "durations": np.empty(knots),
        "stance": shared_record(StanceArrays, vars(stance)),
        "fixed": fixed,
        "gravity": options.gravity,
        "comfort": options.comfort,
    }
    return StepRoom(
        footsteps=footsteps,
        headings=headings,
        count=count,
        knot_times=knot_times,
        times=times,
        fixed=fixed,
        unknowns=unknowns,
        stance=stance,
        window=shared_record(WindowArrays, window),
        problem=shared_record(ProblemArrays, problem),
        work=device_work(unknowns),
    )
