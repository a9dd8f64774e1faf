"""Doubts: what lint finds in plans as soon as they are made."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from usdfoot.model.ground import Ground
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.planning.faults import ERROR, Fault
from usdfoot.planning.lint import lint_plans
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.world import Obstacle
from usdfoot.writers.plans import PlannedAgent

__all__ = ["find_doubts"]

COLLISION = "collision"
"""Kind of fault that needs two."""


def find_doubts(
    planned: Sequence[PlannedAgent],
    terrain: Terrain,
    *,
    bodies: Sequence[Proportions],
    obstacles: Sequence[Obstacle] = (),
    moving: Callable[[float], Sequence[Obstacle]] | None = None,
    alone: bool = False,
) -> list[Problem]:
    """A warning for each plan that cannot be walked as it is, with its first fault.

    Args:
        planned: Plans of everyone who walks at the same time and place.
        terrain: Below them.
        bodies: Who walks each plan.
        obstacles: That nobody walks through, and stay where they are.
        moving: Others at a time [s]; None = there are none.
        alone: Each was planned as if nobody else was there: one warning for all who step on each other.
    """
    if not planned:
        return []
    lowest = min(float(part.plan.positions[:, 1].min()) for part in planned)
    plans = {part.name: replace(part.plan, name=part.name) for part in planned}
    ground = Ground(terrain, fallback_height=lowest)
    faults = lint_plans(list(plans.values()), ground, bodies=bodies, obstacles=obstacles, moving=moving)
    errors = [fault for fault in faults if fault.severity == ERROR]
    doubts = _meetings(errors, len(plans)) if alone else []
    errors = [fault for fault in errors if not (alone and fault.kind == COLLISION)]
    own = {name: [fault for fault in errors if fault.plan == name] for name in {fault.plan for fault in errors}}
    for name, plan in plans.items():
        if name in own:
            first, *others = own[name]
            more = f" (and {len(others)} more)" if others else ""
            place = ", ".join(f"{value:.2f}" for value in plan.positions[max(first.footstep, 0)])
            what = f"footstep {first.footstep} at ({place}) m {first.message}{more}"
            doubts.append(
                Problem(severity="warning", where=name, message=f"{name}: {what}. usdfoot plan lint tells more")
            )
    return doubts


def _meetings(errors: Sequence[Fault], count: int) -> list[Problem]:
    """One warning of all plans, of so many, whose feet are in each other."""
    meetings = [fault for fault in errors if fault.kind == COLLISION]
    if not meetings:
        return []
    first = meetings[0]
    who = f"{len({fault.plan for fault in meetings})} of {count} agents step on each other"
    where = f"footstep {first.footstep} of {first.plan} {first.message}"
    message = f"{who}, each is planned as if nobody else was there ({where}). usdfoot plan crowd keeps them apart"
    return [Problem(severity="warning", where=first.plan, message=message)]
