"""Plan waits: plans along paths that meet animated obstacles let these pass, or go round where they stay."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from usdfoot.errors import UsdfootError
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.planning.moving import Moving
from usdfoot.planning.waiting import find_meetings, let_pass
from usdfoot.planning.world import Obstacle
from usdfoot.readers.walkers import Walker

__all__ = ["wait_for_moving"]

Plans = Mapping[str, FootstepPlan | UsdfootError]


def wait_for_moving(
    walkers: Sequence[Walker],
    plans: Plans,
    *,
    moving: Moving,
    go_round: Callable[[Walker, Sequence[Obstacle]], FootstepPlan | UsdfootError],
) -> tuple[dict[str, FootstepPlan | UsdfootError], list[Problem]]:
    """The plans, those that meet an obstacle later where that helps, by name; and who waits, or cannot.

    Args:
        walkers: Who walks.
        plans: Their plans by name.
        moving: Obstacles at times of the stage.
        go_round: Plans somebody's way again, also round these obstacles.
    """
    walking = [walker for walker in walkers if isinstance(plans[walker.name], FootstepPlan)]
    made = [plan for walker in walking if isinstance(plan := plans[walker.name], FootstepPlan)]
    found, problems = dict(plans), []
    for row, (name, time) in find_meetings(made, [walker.proportions for walker in walking], moving).items():
        walker, plan = walking[row], made[row]
        later = let_pass(plan, walker.proportions, moving)
        if later is None:
            other = go_round(walker, moving.at(moving.end))
            if isinstance(other, FootstepPlan):
                plan, later = other, let_pass(other, walker.proportions, moving)
        if later is None:
            what = f"meets {name} at {time:.2f} s, and to wait does not help"
            remedy = "lead the path elsewhere, or author another usdfoot:path:startTime"
        else:
            found[walker.name] = later
            wait = later.strike_times[-1] - plan.strike_times[-1]
            if wait <= 0.0:
                continue
            what, remedy = f"waits {wait:.1f} s for {name}", "--no-around keeps its times"
        problems.append(Problem(severity="warning", where=walker.name, message=f"{walker.name}: {what}. {remedy}"))
    return found, problems
