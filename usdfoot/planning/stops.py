"""Stops: plans in which who walks comes to stand on both feet, and sets out again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.prints import lay_prints

__all__ = ["with_stops"]

ONWARD = 0.25
"""How far on its way to its next footstep the foot that sets out comes first: half a step."""


def with_stops(plan: FootstepPlan, rows: Sequence[int], ground: Ground) -> tuple[FootstepPlan, IntArray] | None:
    """The plan with two more footsteps after each of rows, and which are the first of these; None if that cannot be.

    The first closes the other foot up to that of the row, the second takes that one half a step on, from where the plan
    goes on as it was, as much later. Steps and swings last as long as they did there.

    Args:
        plan: Of steps without a flight at these rows.
        rows: Footsteps beside which to stand, ascending.
        ground: To lay footsteps on.
    """
    stopped, closing = plan, []
    for count, row in enumerate(rows):
        found = _with_stop(stopped, row + 2 * count, ground)
        if found is None:
            return None
        stopped = found
        closing.append(row + 2 * count + 1)
    return stopped, np.array(closing)


def _with_stop(plan: FootstepPlan, row: int, ground: Ground) -> FootstepPlan | None:
    strikes, liftoffs = plan.strike_times, plan.liftoff_times
    if row < 2 or row + 2 >= len(plan) or np.any(liftoffs[row - 1 : row + 2] <= strikes[row : row + 3]):
        return None
    shares = np.array([0.5, ONWARD])
    begins, ends = np.array([row - 1, row]), np.array([row + 1, row + 2])
    points, yaws = plan.positions, plan.yaws
    between = points[begins] + shares[:, None] * (points[ends] - points[begins])
    turned = yaws[begins] + shares * planar.wrap_angle(yaws[ends] - yaws[begins])
    laid = lay_prints(ground, between[:, [0, 2]], turned, near=between[:, 1])
    kept = np.array([row, row])  # whose weights and styles the new ones have
    order = np.insert(np.arange(len(plan)), row + 1, kept)
    new = slice(row + 1, row + 3)
    positions, orientations = points[order], plan.orientations[order]
    positions[new], orientations[new] = laid.positions, laid.orientations
    sides = plan.sides[order]
    sides[row + 1] = 1 - plan.sides[row]
    times = _times(plan, row)
    try:
        return replace(
            plan,
            sides=sides,
            positions=positions,
            orientations=orientations,
            strike_times=times[0],
            liftoff_times=times[1],
            root_weights=plan.root_weights[order],
            styles=tuple(plan.styles[index] for index in order) if plan.styles else plan.styles,
        )
    except PlanError:
        return None


def _times(plan: FootstepPlan, row: int) -> tuple[FloatArray, FloatArray]:
    """Strikes and liftoffs with two more footsteps after a row [s], shape (N + 2,) each."""
    strikes, liftoffs = plan.strike_times, plan.liftoff_times
    step, swing = strikes[row + 1] - strikes[row], strikes[row + 1] - liftoffs[row - 1]
    between, after = strikes[row] + step * np.array([1.0, 2.0]), strikes[row + 1 :] + 2.0 * step
    later = np.concatenate([strikes[: row + 1], between, after])
    leaves = np.concatenate([liftoffs[:row], later[row + 2 : row + 5] - swing, liftoffs[row + 1 :] + 2.0 * step])
    return later, leaves
