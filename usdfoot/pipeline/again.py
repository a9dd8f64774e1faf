"""Again: a written crowd, or some of its agents, animated once more from its own scene."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from usdfoot.bridge.tokens import File
from usdfoot.errors import PlanError, SceneError, UsdfootError
from usdfoot.model.plan import FootstepPlan
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.provenance import call_of, options_of
from usdfoot.pipeline.report import AnimateReport
from usdfoot.readers.skeleton import matrices_of
from usdfoot.readers.stage import start_code
from usdfoot.readers.written import WrittenCrowd, agent_names, read_agent, read_written_crowd
from usdfoot.writers.plan_edits import PlanEdit, restore_layer, save_plan_edit
from usdfoot.writers.root import SUBLAYERS

__all__ = ["TAKES", "Take", "edit_plan", "keep_take", "make_take", "remake"]

TAKES = "takes"
"""Folder of takes within a crowd's."""


@dataclass(frozen=True, kw_only=True)
class Take:
    """Some agents of a crowd animated otherwise, to be looked at; the crowd itself is as it was."""

    folder: Path
    """Holds a crowd of its own."""
    layers: tuple[Path, ...]
    """What shows it over the crowd, strongest first."""
    report: AnimateReport


def remake(crowd: WrittenCrowd, *, options: MotionOptions | None = None) -> AnimateReport:
    """The crowd made again in its folder as it was asked for, with what artists changed since in overrides.usda.

    Chunks in which nothing changed are kept.

    Args:
        crowd: As read.
        options: None = as it was asked for.

    Raises:
        SceneError: If its scene is not known or cannot be read.
        OutputError: If the folder cannot be written to.
    """
    call = call_of(crowd.provenance)
    return animate(
        _scene_of(crowd),
        crowd.folder,
        agents=call.agents,
        frames=call.frames,
        options=options or options_of(crowd.provenance),
        collect=call.collect,
        levels=call.levels,
        chunk_size=call.chunk_size,
        limits=call.limits,
    )


def make_take(
    crowd: WrittenCrowd, names: Sequence[str], *, root_weight: float | None = None, seam: str | None = None
) -> Take:
    """Some agents animated again with other options, in a new folder below takes/ in the crowd's.

    Args:
        crowd: As read; not changed.
        names: Of the agents.
        root_weight: [B]'s lambda4 of all their steps; None = as it was.
        seam: inertialise | crossfade | none; None = as it was.

    Raises:
        UsdfootError: If an option is out of its range.
        SceneError: If the crowd's scene is not known or none of the agents can be read there.
        OutputError: If the folder cannot be written to.
    """
    options, call = options_of(crowd.provenance), call_of(crowd.provenance)
    options = replace(options, seam=seam or options.seam)
    options = options if root_weight is None else replace(options, root_weight=root_weight)
    scene = _scene_of(crowd)
    above = crowd.folder / TAKES
    taken = [int(path.name) for path in above.iterdir() if path.name.isdecimal()] if above.is_dir() else []
    folder = above / f"{max(taken, default=0) + 1:04d}"
    folder.mkdir(parents=True)
    try:
        if (crowd.folder / File.OVERRIDES).is_file():
            shutil.copyfile(crowd.folder / File.OVERRIDES, folder / File.OVERRIDES)
        report = animate(
            scene,
            folder,
            agents=tuple(names),
            frames=call.frames,
            options=options,
            collect=call.collect,
            levels=call.levels,
            limits=call.limits,
        )
    except BaseException:
        shutil.rmtree(folder)
        raise
    names = [name for name in (*SUBLAYERS, File.MATERIALS) if name != File.OVERRIDES]
    layers = tuple(folder / name for name in names if name != File.MATERIALS or (folder / name).is_file())
    return Take(folder=folder, layers=layers, report=report)


def edit_plan(crowd: WrittenCrowd, name: str, edit: Callable[[FootstepPlan], FootstepPlan]) -> AnimateReport:
    """Edit the footsteps of an agent in the crowd's overrides.usda, and make the crowd again.

    If the agent cannot be animated along the edited plan, overrides.usda and the crowd stay as they were.

    Args:
        crowd: As read.
        name: Of the agent.
        edit: Gives the plan as it shall be.

    Raises:
        PlanError: If what comes out is no plan, or one that cannot be animated.
        SceneError: If the crowd's scene is not known or cannot be read.
        OutputError: If overrides.usda or the folder cannot be written to.
    """
    return _edit_plans(crowd, {name: edit})


def keep_take(crowd: WrittenCrowd, folder: Path) -> AnimateReport:
    """Make the crowd again so that it has the motion of a take; gives back what was made.

    What was asked of everybody becomes what is asked of the crowd. Of some agents the root weight can be kept: as the
    `usdfoot:plan:rootWeights` of their plans in overrides.usda.

    Args:
        crowd: As read, without the take.
        folder: Of the take.

    Raises:
        SceneError: If the take is not there, or it asks of some agents what can only be asked of all.
        PlanError: If the agents cannot be animated so.
        OutputError: If overrides.usda or the folder cannot be written to.
    """
    take = read_written_crowd(folder / File.CROWD)
    was, now = options_of(crowd.provenance), options_of(take.provenance)
    if set(agent_names(take)) >= set(agent_names(crowd)):
        return remake(crowd, options=now)
    weight = now.root_weight
    if now.seam != was.seam or was.root_weight is not None or not weight:
        what = "seam" if now.seam != was.seam else "root weight"
        raise SceneError(
            folder, f"holds some agents, and their {what} is one that is asked of all", "make a take of all agents"
        )
    return _edit_plans(
        crowd, {name: lambda plan: replace(plan, root_weights=np.full(len(plan), weight)) for name in agent_names(take)}
    )


def _edit_plans(crowd: WrittenCrowd, edits: Mapping[str, Callable[[FootstepPlan], FootstepPlan]]) -> AnimateReport:
    """As `edit_plan`, for several agents at once, by name."""
    _scene_of(crowd)
    file = crowd.folder / File.OVERRIDES
    changes = []
    for name, edit in edits.items():
        before = read_agent(crowd, name).plan
        prim = crowd.stage.GetPrimAtPath(before.name)
        frame = matrices_of(prim, np.array([start_code(crowd.stage).GetValue()]))[0]
        changes.append(PlanEdit(plan=edit(before), before=before, frame=frame))
    kept = [save_plan_edit(file, change, units=crowd.units) for change in changes]
    try:
        report = remake(crowd)
        lost = not set(edits) <= set(report.results)
        reasons = [problem.message for problem in report.skipped] if lost else []
    except UsdfootError as error:
        report, reasons = None, [str(error)]
    if report is None or reasons:
        restore_layer(file, kept[0])
        if report is not None:
            remake(crowd)
        where = ", ".join(change.plan.name for change in changes)
        raise PlanError(where, "cannot be walked as edited, and stays as it was", names=reasons)
    return report


def _scene_of(crowd: WrittenCrowd) -> str:
    """The scene's path.

    Raises:
        SceneError: If the crowd does not name it.
    """
    if not crowd.scene:
        where = crowd.stage.GetRootLayer().identifier
        raise SceneError(where, "does not name the scene it was made from", "open a crowd.usd of usdfoot animate")
    return crowd.scene
