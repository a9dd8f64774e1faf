"""Lint: the plans of a scene checked, and mended where the remedy is obvious."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot.analysis.examples import build_examples
from usdfoot.bridge.names import unique_name
from usdfoot.bridge.scene import Scene, StageInfo
from usdfoot.errors import ClipError, PlanError, SceneError, UsdfootError
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Agent
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.ground import Ground
from usdfoot.model.limits import DEFAULT_LIMITS, Limits
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.plan_draft import PlanDraft
from usdfoot.model.report import Problem
from usdfoot.pipeline.plan import save_plans
from usdfoot.planning.faults import Fault, LintLimits
from usdfoot.planning.hurry import lint_hurry
from usdfoot.planning.lint import lint_clips, lint_plans
from usdfoot.planning.mend import mend_plans, mend_times
from usdfoot.planning.proportions import Proportions, proportions_of
from usdfoot.readers.moving_obstacles import MovingObstacles
from usdfoot.readers.obstacles import read_obstacles
from usdfoot.readers.plans import is_plan, read_draft
from usdfoot.readers.scene import read_scene
from usdfoot.readers.skeleton import StartTransforms, check_skeletons
from usdfoot.readers.stage import StagePrims, collect_prims, open_stage, read_stage_info
from usdfoot.readers.terrain import read_terrain
from usdfoot.spaces.library import FootstepSpaces, build_spaces
from usdfoot.writers.plan_edits import PlanEdit
from usdfoot.writers.plans import PlannedAgent

__all__ = ["LintReport", "lint_scene"]


@dataclass(frozen=True, kw_only=True)
class LintReport:
    """What was found."""

    plans: Mapping[str, FootstepPlan]
    """By prim path; after mending, if that was asked for."""
    faults: tuple[Fault, ...]
    """What is wrong with them."""
    problems: tuple[Problem, ...]
    """What could not be checked."""
    file: Path | None = None
    """Layer with the mended plans, if that was asked for and any changed."""

    @property
    def clean(self) -> bool:
        """Whether no footstep has an error."""
        return not any(fault.severity == "error" for fault in self.faults)

    def to_json(self) -> dict[str, Any]:
        """Plain dictionaries for `--json`."""
        return {
            "clean": self.clean,
            "plans": len(self.plans),
            "footsteps": sum(len(plan) for plan in self.plans.values()),
            "faults": [fault.to_json() for fault in self.faults],
            "problems": [problem.message for problem in self.problems],
        }


@dataclass(frozen=True, kw_only=True)
class _Walkers:
    """Who walks the plans, as far as the scene says."""

    agents: Mapping[str, Agent]
    """By the name of the plan."""
    libraries: tuple[ClipLibrary, ...]

    def body(self, plan: str) -> Proportions:
        """Proportions of who walks a plan; a person's if nobody does."""
        if plan not in self.agents:
            return Proportions()
        library = self.libraries[self.agents[plan].library]
        return proportions_of(library.skeleton, library.biped, library.bind_pose)


def lint_scene(
    scene: str | os.PathLike[str],
    *,
    limits: LintLimits | None = None,
    clips: bool = True,
    fix: str | os.PathLike[str] | None = None,
    most: Limits = DEFAULT_LIMITS,
) -> LintReport:
    """Check a scene's plans, and its paths', against terrain, obstacles, bodies, clips and each other.

    Args:
        scene: USD file with plans; without agents the plans are checked for a person.
        limits: What is still right.
        clips: Also check what the agents' clips reach.
        fix: Layer to write with what can be mended: times, heights, crossing and colliding feet.
        most: How much of the scene is read before it is refused.

    Raises:
        SceneError: If the scene cannot be opened, is too large or has no plan.
        OutputError: If the layer cannot be written.
    """
    stage = open_stage(scene)
    info, prims = read_stage_info(stage), collect_prims(stage, most=most.prims)
    check_skeletons(prims.skeletons, most)
    terrain, terrain_problems = read_terrain(stage, prims, info.units, limits=most)
    found, malformed, drafts = _read_plans(prims, info, mend=fix is not None, most=most.footsteps)
    crowd, problems = _read_crowd(scene, most)
    walkers = _Walkers(
        agents={agent.plan.name: agent for agent in crowd.crowd.agents} if crowd else {},
        libraries=crowd.crowd.libraries if crowd else (),
    )
    plans = found | {name: agent.plan for name, agent in walkers.agents.items() if name not in found}
    if not plans and not malformed:
        raise SceneError(info.identifier, "has no footstep plan", "make some: usdfoot plan --help")
    bodies = [walkers.body(name) for name in plans]
    lowest = min((float(plan.positions[:, 1].min()) for plan in plans.values()), default=0.0)
    ground = Ground(terrain, fallback_height=lowest)
    file = None
    if fix is not None:
        mended = dict(zip(plans, mend_plans(list(plans.values()), ground, bodies=bodies), strict=True))
        changed, transforms = (
            {name for name in plans if mended[name] is not plans[name]} | set(drafts),
            StartTransforms(stage),
        )
        before = {name: drafts.get(name, found[name]) for name in changed if name in found}
        edits = [
            PlanEdit(plan=mended[name], before=before[name], frame=transforms.matrix_of(stage.GetPrimAtPath(name)))
            for name in sorted(before)
        ]
        plans = mended
        file = _save(changed - set(before), edits, plans, walkers, info, fix) if changed else None
    obstacles, obstacle_problems = read_obstacles(stage, prims, info.units)
    moving = MovingObstacles(prims, info.units)
    found_faults = lint_plans(
        list(plans.values()),
        ground,
        bodies=bodies,
        obstacles=moving.others(obstacles),
        moving=moving.at if moving else None,
        limits=limits,
    )
    faults = [*malformed, *found_faults]
    if clips:
        more, clip_problems = _lint_clips(plans, walkers, limits)
        faults, problems = faults + more, problems + clip_problems
    problems = [*terrain_problems, *obstacle_problems, *problems]
    return LintReport(plans=plans, faults=tuple(faults), problems=tuple(problems), file=file)


def _read_plans(
    prims: StagePrims, info: StageInfo, *, mend: bool, most: int
) -> tuple[dict[str, FootstepPlan], list[Fault], dict[str, PlanDraft]]:
    """Plans by prim path, what is wrong with those that are none, and what those were whose times were mended."""
    plans: dict[str, FootstepPlan] = {}
    faults: list[Fault] = []
    drafts: dict[str, PlanDraft] = {}
    for prim in prims.instancers:
        if not is_plan(prim):
            continue
        name = str(prim.GetPath())
        try:
            draft, _ = read_draft(prim, info.units, most=most)
            try:
                plans[name] = FootstepPlan.checked(draft)
            except PlanError as error:
                if not mend:
                    raise
                plans[name] = _mended(draft, error)
                drafts[name] = draft
        except PlanError as error:
            text = f"{error.what}. {error.remedy}" if error.remedy else error.what
            faults.append(Fault(plan=name, footstep=-1, kind="malformed", severity="error", value=0.0, message=text))
    return plans, faults, drafts


def _mended(draft: PlanDraft, error: PlanError) -> FootstepPlan:
    """The plan with its times mended; raises what is wrong with it as it stands if that is not enough."""
    try:
        return FootstepPlan.checked(mend_times(draft))
    except PlanError:
        raise error from None


def _read_crowd(scene: str | os.PathLike[str], most: Limits) -> tuple[Scene | None, list[Problem]]:
    """Agents with their characters and clips; None if the scene has none that can be used."""
    try:
        return read_scene(scene, limits=most), []
    except UsdfootError as error:
        message = f"checked for a person, without clips: {error}"
        return None, [Problem(severity="warning", where=error.where, message=message)]


def _lint_clips(
    plans: Mapping[str, FootstepPlan], walkers: _Walkers, limits: LintLimits | None
) -> tuple[list[Fault], list[Problem]]:
    """Faults against the clips of those who walk, each library prepared once."""
    faults, problems = [], []
    spaces: dict[int, tuple[FootstepSpaces, FloatArray, str] | None] = {}
    for name, agent in walkers.agents.items():
        try:
            if agent.library not in spaces:
                spaces[agent.library] = None
                spaces[agent.library] = _prepare(walkers.libraries[agent.library])
            prepared = spaces[agent.library]
            if prepared is not None and agent.motion != "physics":
                found, durations, style = prepared
                faults += lint_clips(plans[name], found, style=style, reach=agent.ik_reach)
                faults += lint_hurry(plans[name], found, durations, style=style, limits=limits)
        except UsdfootError as error:
            problems.append(Problem(severity="warning", where=error.where, message=str(error)))
    return faults, problems


def _prepare(library: ClipLibrary) -> tuple[FootstepSpaces, FloatArray, str]:
    """Footstep spaces of a library, how long its steps take, and the style of plans that name none."""
    examples, faults = build_examples(library)
    if not len(examples):
        reasons = [fault.message for fault in faults]
        raise ClipError(library.skeleton.name, "has no clip with a usable step to check against", names=reasons)
    spaces = build_spaces(examples, leg_length=library.biped.maximal_leg_length)
    return spaces, np.asarray(examples.durations, dtype=float), examples.default_style


def _save(
    added: set[str],
    edits: Sequence[PlanEdit],
    plans: Mapping[str, FootstepPlan],
    walkers: _Walkers,
    info: StageInfo,
    output: str | os.PathLike[str],
) -> Path:
    """A layer over the plans that were mended, and with those of paths, to which their agents point."""
    taken: set[str] = set()
    mended = []
    for name in sorted(added):
        agent = walkers.agents.get(name)
        mended.append(
            PlannedAgent(
                name=unique_name(name.rsplit("/", 1)[-1], taken),
                plan=replace(plans[name], name=name),
                size=walkers.body(name).foot_length,
                agent=agent.source if agent else "",
            )
        )
    return save_plans(mended, output, info, edits=edits, made_by={"planner": "lint --fix"})
