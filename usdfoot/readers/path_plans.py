"""Path plans: plans of those who walk paths of a stage, who let what is animated pass or go round it where it stays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from usdfoot.errors import UsdfootError
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.planning.moving import Moving
from usdfoot.planning.path import PathOptions
from usdfoot.planning.waiting import find_meetings, let_pass
from usdfoot.planning.world import Obstacle
from usdfoot.readers.moving_obstacles import MovingObstacles
from usdfoot.readers.walkers import Walker, plan_walkers

__all__ = ["PathPlans", "plan_paths"]


@dataclass(frozen=True, kw_only=True)
class PathPlans:
    """What walkers of paths do."""

    plans: dict[str, FootstepPlan]
    """By the walkers' names."""
    errors: dict[str, UsdfootError]
    """Why others have none."""
    waits: dict[str, Problem]
    """Warnings of those who wait, or cannot, by name."""


def plan_paths(
    walkers: Sequence[Walker],
    terrain: Terrain,
    *,
    obstacles: Sequence[Obstacle],
    moving: MovingObstacles,
    options: PathOptions | None = None,
) -> PathPlans:
    """Plans of walkers on a terrain, round its obstacles; for animated ones they wait, or go round where these stay.

    Args:
        walkers: Who walks what.
        terrain: Below them.
        obstacles: Of the stage as it starts, animated ones too.
        moving: The animated ones.
        options: How; None = as `plan_walkers` does.
    """
    still, known = moving.others(obstacles), moving.after(0.0)
    found = plan_walkers(walkers, terrain, obstacles=still, options=options)
    errors = {name: plan for name, plan in found.items() if isinstance(plan, UsdfootError)}
    plans = {name: plan for name, plan in found.items() if isinstance(plan, FootstepPlan)}
    waits: dict[str, Problem] = {}
    if known is None or (options and options.around is False):
        return PathPlans(plans=plans, errors=errors, waits=waits)
    walked = [walker for walker in walkers if walker.name in plans]
    bodies = [walker.proportions for walker in walked]
    for row, met in find_meetings([plans[walker.name] for walker in walked], bodies, known).items():
        walker, own = walked[row], plans[walked[row].name]
        plan, wait = _later(walker, own, terrain, moving=known), 0.0
        if plan is None:
            stays = [*still, *known.at(known.end)]
            around = plan_walkers([walker], terrain, obstacles=stays, options=options)[walker.name]
            if isinstance(around, FootstepPlan):
                own, plan = around, _later(walker, around, terrain, moving=known)
        if plan is not None:
            plans[walker.name], wait = plan, float(plan.strike_times[-1] - own.strike_times[-1])
        waits.update({walker.name: _told(walker, met, wait)} if plan is None or wait > 0.0 else {})
    return PathPlans(plans=plans, errors=errors, waits=waits)


def _later(walker: Walker, plan: FootstepPlan, terrain: Terrain, *, moving: Moving) -> FootstepPlan | None:
    """A walker's plan that lets what moves pass, None if it cannot."""
    ground = Ground(terrain, fallback_height=float(walker.path.points[:, 1].min()))
    return let_pass(plan, walker.proportions, moving, ground=ground)


def _told(walker: Walker, met: tuple[str, float], wait: float) -> Problem:
    """What is said of a walker who meets an obstacle at a time [s], and waits so long for it [s], 0 = in vain."""
    name, time = met
    message = f"{walker.name}: waits {wait:.1f} s for {name}. usdfoot plan path --no-around keeps its times"
    if wait <= 0.0:
        message = (
            f"{walker.name}: meets {name} at {time:.2f} s, and to wait does not help. lead the path elsewhere, or "
            "author another usdfoot:path:startTime"
        )
    return Problem(severity="warning", where=walker.name, message=message)
