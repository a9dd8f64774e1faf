"""Import plans: footsteps from files of other programs become a layer; export: plans of a stage become a CSV file."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from usdfoot import __version__
from usdfoot.bridge.names import unique_name, valid_name
from usdfoot.bridge.scene import StageInfo
from usdfoot.bridge.units import CANONICAL
from usdfoot.errors import PlanError, SceneError, UsdfootError
from usdfoot.importers.foot_recordings import import_foot_recording
from usdfoot.importers.plan_table import import_plan_table
from usdfoot.importers.stp import import_stp
from usdfoot.model.limits import DEFAULT_LIMITS, Limits
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.pipeline.plan import PlanReport, save_plans
from usdfoot.readers.plans import is_plan, read_plan
from usdfoot.readers.stage import collect_prims, open_stage, read_stage_info
from usdfoot.writers.plan_table import write_plan_table
from usdfoot.writers.plans import PlannedAgent, write_plans

__all__ = ["PLAN_SUFFIXES", "PlanFormat", "export_plans", "import_plans"]

PLAN_SUFFIXES = (".csv", ".stp", ".foot", ".rec")
"""Of files that can be imported as plans."""


@dataclass(frozen=True, kw_only=True)
class PlanFormat:
    """What files do not say about themselves."""

    unit: str = ""
    """Of lengths: m, cm, mm, ft, in, or metres a unit; CSV files without are in metres."""
    rate: float = 0.0
    """Units of time of STP files in a second; 0 = 3ds Max's 4800 ticks."""
    up: str = "Y"
    """Axis that points up in CSV files: Y | Z."""
    limits: Limits = DEFAULT_LIMITS
    """How much a file may hold."""


def import_plans(
    files: Sequence[str | os.PathLike[str]],
    output: str | os.PathLike[str],
    *,
    plan_format: PlanFormat | None = None,
    scene: str | os.PathLike[str] | None = None,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> PlanReport:
    """Write the footsteps of files as a layer of plans, /Plans/<name>.

    Args:
        files: .csv (columns of `bridge/plan_columns.py`), .stp of 3ds Max's Biped, footsteps recorded by SteerSuite.
        output: .usd, .usda or .usdc to write.
        plan_format: Units that the files do not state.
        scene: Stage the plans are for: its units and axes; None = metres, Y up.
        progress: Told which file is read, how many are done, and of how many.

    Raises:
        UsdfootError: If no file can be used; the first error.
        OutputError: If the layer cannot be written.
    """
    said = plan_format or PlanFormat()
    info = read_stage_info(open_stage(scene)) if scene is not None else None
    plans: dict[str, FootstepPlan] = {}
    taken: set[str] = set()
    problems: list[Problem] = []
    errors: list[UsdfootError] = []
    for done, file in enumerate(files):
        path = Path(file)
        progress(path.name, done, len(files))
        try:
            found, odd = _read(path, said)
        except UsdfootError as error:
            errors.append(error)
            continue
        problems += odd
        plans |= {unique_name(valid_name(name), taken): plan for name, plan in found.items()}
    if not plans:
        raise errors[0] if errors else PlanError("files", "there are none", "name at least one")
    problems += [Problem(severity="error", where=error.where, message=str(error)) for error in errors]
    progress("write", 0, 0)
    planned = [PlannedAgent(name=name, plan=plan) for name, plan in plans.items()]
    sources = [Path(file).name for file in files]
    target = _save(planned, output, info, sources)
    return PlanReport(file=target, plans=plans, problems=tuple(problems))


def export_plans(scene: str | os.PathLike[str], output: str | os.PathLike[str]) -> PlanReport:
    """Write all footstep plans of a stage as a CSV file, in metres, +Y up, degrees and seconds.

    Args:
        scene: USD file with PointInstancers of prints; never changed.
        output: .csv to write.

    Raises:
        SceneError: If the stage cannot be opened or has no plan that can be read.
        OutputError: If the file cannot be written.
    """
    stage = open_stage(scene)
    info = read_stage_info(stage)
    plans: dict[str, FootstepPlan] = {}
    taken: set[str] = set()
    problems: list[Problem] = []
    for prim in collect_prims(stage).instancers:
        if not is_plan(prim):
            continue
        try:
            plan, doubts = read_plan(prim, info.units)
        except PlanError as error:
            problems.append(Problem(severity="error", where=error.where, message=str(error)))
            continue
        plans[unique_name(prim.GetName(), taken)] = plan
        problems += doubts
    if not plans:
        names = [problem.message for problem in problems]
        what = "has no footstep plan" + (" that can be read" if names else "")
        raise SceneError(info.identifier, what, "plans are PointInstancers with UsdfootPlanAPI", names)
    file = write_plan_table(output, plans, source=info.identifier)
    return PlanReport(file=file, plans=plans, problems=tuple(problems))


def _read(path: Path, said: PlanFormat) -> tuple[Mapping[str, FootstepPlan], tuple[Problem, ...]]:
    """Plans of one file by name, and what was odd."""
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return import_plan_table(path, unit=said.unit, up=said.up), ()
    if suffix == ".stp":
        return {path.stem: import_stp(path, unit=said.unit, ticks=said.rate, limits=said.limits)}, ()
    if suffix in PLAN_SUFFIXES:
        found, odd = import_foot_recording(path, limits=said.limits)
        return {f"{path.stem}_{name}": plan for name, plan in found.items()}, odd
    raise PlanError(path, f"{suffix or 'no suffix'} is unknown", f"{', '.join(PLAN_SUFFIXES)} can be imported")


def _save(
    planned: Sequence[PlannedAgent],
    output: str | os.PathLike[str],
    info: StageInfo | None,
    sources: Sequence[str],
) -> Path:
    made_by = {"planner": "import", "sources": ", ".join(sources)}
    if info is not None:
        return save_plans(planned, output, info, made_by=made_by)
    provenance = {"version": __version__, **made_by}
    return write_plans(output, planned, units=CANONICAL, frames_per_second=24.0, provenance=provenance)
