"""Hurry: how quickly steps can be taken, as the clips show it, and which are taken more quickly."""

from __future__ import annotations

import numpy as np

from usdfoot.analysis.gaits import has_flight
from usdfoot.maths import planar
from usdfoot.maths.planar import GROUND_AXES
from usdfoot.maths.types import FloatArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.faults import WARNING, Fault, LintLimits
from usdfoot.planning.gait import Gait, overlap_shares
from usdfoot.spaces.features import StepFeatures
from usdfoot.spaces.library import FootstepSpaces, solve_steps

__all__ = ["MOST_HURRY", "lint_hurry", "unhurried_time"]

MOST_HURRY = 1.2
"""A step is at most so many times as quick as the clips it is blended from: hurried on more, joints jerk more than 1.2
times as much as theirs (design.md section 10), whatever the length of the steps."""
LONGER = 1.02 ** np.arange(150)
"""Times that are tried over what is asked, the quickest first."""


def unhurried_time(gait: Gait, spaces: FootstepSpaces, durations: FloatArray, *, style: str) -> float:
    """The least time of the even steps of a gait for which no clip has to be hurried too much, or theirs [s].

    Args:
        gait: Steps as asked for.
        spaces: Of the walker's clips.
        durations: Of the examples in the spaces [s], shape (E,).
        style: To walk in.

    Raises:
        ClipError: If the style has no step.
    """
    times, steps = gait.step_time * LONGER, np.ones((len(LONGER), 1))
    overlaps = overlap_shares(gait.step_length / times, gait.rule) * times
    found = solve_steps(
        spaces,
        steps * [gait.step_width, gait.step_length],
        swing_sides=np.zeros(len(times), dtype=np.intp),
        flights=overlaps < 0.0,
        styles=(style,) * len(times),
        features=StepFeatures(
            durations=times,
            swing_liftoffs=overlaps,
            turns=np.zeros(len(times)),
            landing_heights=np.zeros(len(times)),
            departures=steps * [gait.step_width, -gait.step_length],
        ),
    )
    unhurried = MOST_HURRY * times >= np.sum(found.weights * durations[found.examples], axis=1)
    return float(times[np.argmax(unhurried)])


def lint_hurry(
    plan: FootstepPlan, spaces: FootstepSpaces, durations: FloatArray, *, style: str, limits: LintLimits | None = None
) -> list[Fault]:
    """Footsteps for which the clips of a library have to be hurried so much that it shows.

    Args:
        plan: To walk with them.
        spaces: Of the library.
        durations: Of the examples in the spaces [s], shape (E,).
        style: To walk in.
        limits: What is still right.

    Raises:
        ClipError: If the style has no step of a foot.
    """
    limits = limits or LintLimits()
    rows = 2 + np.flatnonzero(np.diff(plan.strike_times)[1:] > 0.0)
    left, support = rows - 2, rows - 1
    starts, ends = (planar.midway_yaw(plan.yaws[a], plan.yaws[b]) for a, b in ((left, support), (support, rows)))
    places, times = plan.positions[:, GROUND_AXES], plan.strike_times[rows] - plan.strike_times[support]
    steps = places[rows] - places[support]
    stances = plan.liftoff_times[support] - plan.strike_times[support]
    found = solve_steps(
        spaces,
        planar.rotate(-ends, steps),
        swing_sides=plan.sides[rows],
        flights=has_flight(times, stances, steps, leg_length=spaces.leg_length),
        styles=(style,) * len(rows),
        features=StepFeatures(
            durations=times,
            swing_liftoffs=plan.liftoff_times[left] - plan.strike_times[support],
            turns=planar.wrap_angle(ends - starts),
            landing_heights=plan.positions[rows, 1] - plan.positions[support, 1],
            departures=planar.rotate(-starts, places[left] - places[support]),
        ),
    )
    hurries = np.sum(found.weights * durations[found.examples], axis=1) / times
    return [
        Fault(
            plan=plan.name,
            footstep=int(rows[quick]),
            kind="hurried",
            severity=WARNING,
            value=float(hurries[quick]),
            message=f"is reached in {times[quick]:.2f} s, {hurries[quick]:.1f} times as quickly as in the clips",
        )
        for quick in np.flatnonzero(hurries > limits.most_hurry)
    ]
