"""Plan timing: the footprints of a scene get strike and liftoff times, in a layer over it ([P] 4.1)."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from fnmatch import fnmatchcase

from usdfoot.batch.analysed import build_once
from usdfoot.errors import PlanError, SceneError
from usdfoot.model.limits import DEFAULT_LIMITS, Limits
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.pipeline.plan import PlanReport
from usdfoot.planning.lint import lint_steps
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.retiming import TimingOptions, plan_times
from usdfoot.readers.agents import list_agents
from usdfoot.readers.casting import Casting
from usdfoot.readers.habits import HabitsReader
from usdfoot.readers.plans import is_plan, read_prints
from usdfoot.readers.skeleton import check_skeletons
from usdfoot.readers.stage import collect_prims, open_stage, read_stage_info
from usdfoot.readers.walkers import only_proportions
from usdfoot.writers.plan_times import write_plan_times

__all__ = ["time_scene_plans"]


def time_scene_plans(
    scene: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    plans: str = "*",
    options: TimingOptions | None = None,
    limits: Limits = DEFAULT_LIMITS,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> PlanReport:
    """Time the footprints of a scene as who walks them would, whatever times they have, and write a layer with that.

    Args:
        scene: The USD scene; never changed.
        output: Layer to write: it sublayers the scene and adds the times over its plans, to be read in its place.
        plans: Glob on the names or prim paths of PointInstancers with UsdfootPlanAPI, or that an agent walks.
        options: How.
        limits: How much of the scene is read before it is refused.
        progress: Told what begins: "read", "plan", "write".

    Raises:
        SceneError: If the scene cannot be opened, is too large, or none of its plans matches or can be timed.
        OutputError: If the layer cannot be written.
    """
    progress("read", 0, 0)
    stage = open_stage(scene)
    info, prims = read_stage_info(stage), collect_prims(stage, most=limits.prims)
    check_skeletons(prims.skeletons, limits)
    options = options or TimingOptions()
    if options.start_time is None:
        options = replace(options, start_time=info.start_time)
    sources, _ = list_agents(stage, prims)
    walkers = {source.plan.GetPath(): source for source in sources if not (source.path or source.trajectory)}
    foreign = [source.plan for source in sources]
    casting = Casting.to_look(stage, prims, info.units, foreign=foreign)
    found = [prim for prim in prims.instancers if is_plan(prim) or prim.GetPath() in walkers]
    chosen = [prim for prim in found if fnmatchcase(prim.GetName(), plans) or fnmatchcase(str(prim.GetPath()), plans)]
    if not chosen:
        what = f"has no plan that matches {plans}" if found else "has no footstep plan"
        names = [prim.GetPath() for prim in found]
        raise SceneError(info.identifier, what, "apply UsdfootPlanAPI to PointInstancers of prints", names)
    progress("plan", 0, 0)
    habits = HabitsReader(build=build_once)
    nobody = only_proportions(prims, info.units, foreign=foreign)
    timed: dict[str, FootstepPlan] = {}
    problems: list[Problem] = []
    for prim in chosen:
        path = str(prim.GetPath())
        try:
            prints, warnings = read_prints(prim, info.units, most=limits.footsteps)
            walker = walkers.get(prim.GetPath())
            body = habits.body_of(casting, walker) if walker else nobody
            timed[path] = plan_times(prints, body, options)
            problems += (*warnings, *_impossible(timed[path], body))
        except PlanError as error:
            problems.append(Problem(severity="error", where=path, message=str(error)))
    if not timed:
        raise SceneError(info.identifier, "no plan can be timed", names=[problem.message for problem in problems])
    progress("write", 0, 0)
    default = stage.GetDefaultPrim()
    file = write_plan_times(output, timed, info=info, default_prim=default.GetName() if default else "")
    return PlanReport(file=file, plans=timed, problems=tuple(problems))


def _impossible(plan: FootstepPlan, body: Proportions) -> list[Problem]:
    """A warning that names the first footstep nobody can take in the time it has, and how many there are."""
    faults = [fault for fault in lint_steps(plan, body) if fault.severity == "error"]
    if not faults:
        return []
    first, count = min(faults, key=lambda fault: fault.footstep), len({fault.footstep for fault in faults})
    message = (
        f"{plan.name}: {count} of its {len(plan)} footsteps cannot be walked; footstep {first.footstep} "
        f"{first.message}. check the places, the stage's metersPerUnit and the speed asked for"
    )
    return [Problem(severity="warning", where=plan.name, message=message)]
