"""Plan rules: what footsteps must be to be a plan, of one plan or of many behind each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.biped import SIDES
from usdfoot.model.limits import FARTHEST
from usdfoot.model.plan_draft import PlanDraft

__all__ = ["RULES", "PlanRule", "check_plan", "entries"]


@dataclass(frozen=True, kw_only=True)
class PlanRule:
    """What no plan may be. The first rule that is broken says what is wrong: later ones rely on those before."""

    is_broken: Callable[[PlanDraft], BoolArray]
    """Of each footstep that has `reach` others after it, shape (N - reach,)."""
    what: Callable[[PlanDraft, int], str]
    """What is wrong at this footstep."""
    remedy: str
    reach: int = 0
    """How many of the following footsteps are looked at too."""


def check_plan(steps: PlanDraft) -> None:
    """Raises PlanError for the first thing that is wrong."""
    counts = entries(steps)
    if len(set(counts.values())) != 1:
        listing = ", ".join(f"{key} {value}" for key, value in counts.items())
        raise PlanError(steps.name, f"arrays differ in length ({listing})", "author one entry a footstep in each")
    if len(steps.sides) < 2:
        raise PlanError(steps.name, f"has {len(steps.sides)} footstep(s)", "a plan needs at least two")
    for rule in RULES:
        (broken,) = rule.is_broken(steps).nonzero()
        if broken.size:
            raise PlanError(steps.name, rule.what(steps, int(broken[0])), rule.remedy)


def entries(steps: PlanDraft) -> dict[str, int]:
    """How many entries each array has."""
    counts = {"protoIndices": len(steps.sides)}
    counts.update((label, len(values)) for label, values in _numbers(steps).items())
    return counts | ({"styles": len(steps.styles)} if steps.styles else {})


def _numbers(steps: PlanDraft) -> dict[str, FloatArray]:
    return {
        "positions": steps.positions,
        "orientations": steps.orientations,
        "strikeTimes": steps.strike_times,
        "liftoffTimes": steps.liftoff_times,
        "rootWeights": steps.root_weights,
    }


def _is_infinite(steps: PlanDraft) -> BoolArray:
    numbers = np.column_stack([*_numbers(steps).values()])
    return np.asarray(~np.isfinite(numbers).all(axis=1))


def _infinite(steps: PlanDraft, step: int) -> str:
    label = next(label for label, values in _numbers(steps).items() if not np.isfinite(values[step]).all())
    return f"{label} of footstep {step} is not a finite number"


def _is_turned_by_no_rotation(steps: PlanDraft) -> BoolArray:
    squares = np.einsum("ij,ij->i", steps.orientations, steps.orientations)
    return np.asarray(np.abs(np.sqrt(squares) - 1.0) > 1e-3)


def _overlap(steps: PlanDraft, step: int) -> str:
    strike, liftoff = steps.strike_times[step + 2], steps.liftoff_times[step]
    return (
        f"footstep {step + 2} strikes at {strike:.4g} s before the same foot has left "
        f"footstep {step} at {liftoff:.4g} s"
    )


RULES = (
    PlanRule(
        is_broken=lambda steps: (steps.sides < 0) | (steps.sides > 1),
        what=lambda steps, step: f"footstep {step} has protoIndex {steps.sides[step]}",
        remedy="0 = left, 1 = right",
    ),
    PlanRule(is_broken=_is_infinite, what=_infinite, remedy="author numbers"),
    PlanRule(
        is_broken=lambda steps: np.abs(steps.positions).max(axis=1) > FARTHEST,
        what=lambda steps, step: f"footstep {step} is {np.abs(steps.positions[step]).max():.3g} m from the origin",
        remedy=f"author positions within {FARTHEST:g} m, or correct metersPerUnit",
    ),
    PlanRule(
        is_broken=lambda steps: (steps.root_weights < 0.0) | (steps.root_weights > 1.0),
        what=lambda steps, step: f"rootWeights of footstep {step} is {steps.root_weights[step]:.4g}",
        remedy="0 to 1 is possible",
    ),
    PlanRule(
        is_broken=_is_turned_by_no_rotation,
        what=lambda _steps, _step: "orientations are not unit quaternions",
        remedy="normalise them",
    ),
    PlanRule(
        is_broken=lambda steps: steps.liftoff_times <= steps.strike_times,
        what=lambda steps, step: (
            f"footstep {step} lifts off at {steps.liftoff_times[step]:.4g} s, not after its strike at "
            f"{steps.strike_times[step]:.4g} s"
        ),
        remedy="liftoffTimes must come after strikeTimes",
    ),
    PlanRule(
        is_broken=lambda steps: steps.strike_times[1:] < steps.strike_times[:-1],
        what=lambda _steps, step: f"footstep {step + 1} strikes before footstep {step}",
        remedy="order by strike time",
        reach=1,
    ),
    PlanRule(
        is_broken=lambda steps: steps.sides[1:] == steps.sides[:-1],
        what=lambda steps, step: f"footsteps {step} and {step + 1} are both {SIDES[int(steps.sides[step])]}",
        remedy="left and right must alternate",
        reach=1,
    ),
    PlanRule(
        is_broken=lambda steps: steps.strike_times[2:] <= steps.liftoff_times[:-2],
        what=_overlap,
        remedy="contacts of one foot must not overlap",
        reach=2,
    ),
    PlanRule(
        is_broken=lambda steps: steps.strike_times[2:] <= steps.strike_times[1:-1],
        what=lambda _steps, step: f"footsteps {step + 1} and {step + 2} strike together",
        remedy="only the first two may",
        reach=2,
    ),
)
"""In the order in which they are looked at."""
