"""Plan waits: plans along paths that meet animated obstacles let these pass, or go round where they stay."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from usdfoot.errors import UsdfootError
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.planning.moving import Moving
from usdfoot.planning.waiting import find_meetings, let_pass
from usdfoot.planning.world import Obstacle
from usdfoot.readers.walkers import Walker
from usdfoot.writers.plans import PlannedAgent

__all__ = ["wait_for_moving"]


def wait_for_moving(
    walkers: Sequence[Walker],
    planned: Sequence[PlannedAgent],
    *,
    moving: Moving,
    still: Sequence[Obstacle],
    again: Callable[..., Mapping[str, FootstepPlan | UsdfootError]],
    flown: Callable[[Sequence[PlannedAgent]], Sequence[PlannedAgent]],
) -> tuple[list[PlannedAgent], list[Problem]]:
    """The plans, those that meet an obstacle later where that helps; and who waits, or cannot.

    Args:
        walkers: Who walks each.
        planned: Their plans, with the flights and double supports they are walked with.
        moving: Obstacles at times of the stage.
        still: The others.
        again: Plans the ways of walkers round `obstacles`, by name.
        flown: Gives plans their flights and double supports.
    """
    found, problems = list(planned), list[Problem]()
    bodies = [walker.proportions for walker in walkers]
    for row, (name, time) in find_meetings([part.plan for part in planned], bodies, moving).items():
        walker, plan = walkers[row], planned[row].plan
        later = let_pass(plan, walker.proportions, moving)
        if later is None:
            other = again([walker], obstacles=[*still, *moving.at(moving.end)])[walker.name]
            if isinstance(other, FootstepPlan):
                plan = flown([replace(planned[row], plan=other)])[0].plan
                later = let_pass(plan, walker.proportions, moving)
        if later is None:
            what = f"meets {name} at {time:.2f} s, and to wait does not help"
            remedy = "lead the path elsewhere, or author another usdfoot:path:startTime"
        else:
            found[row] = replace(planned[row], plan=later)
            wait = later.strike_times[-1] - plan.strike_times[-1]
            if wait <= 0.0:
                continue
            what, remedy = f"waits {wait:.1f} s for {name}", "--no-around keeps its times"
        problems.append(Problem(severity="warning", where=walker.name, message=f"{walker.name}: {what}. {remedy}"))
    return found, problems
