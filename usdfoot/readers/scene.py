"""Reads a whole scene: stage in, crowd and characters out."""

from __future__ import annotations

import logging
import os
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from pxr import Usd, UsdSkel

from usdfoot.bridge.scene import Character, Scene, StageInfo
from usdfoot.bridge.tokens import Motion
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import ClipError, SceneError, UsdfootError
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.clip import Clip, ClipLibrary
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.readers.agents import AgentSource, list_agents, read_agent_options, select_agents
from usdfoot.readers.characters import character_key, find_skeleton, only_character, read_character
from usdfoot.readers.clip_sources import ClipFinder
from usdfoot.readers.clips import missing_leg_joints, read_clip
from usdfoot.readers.plans import read_plan
from usdfoot.readers.stage import StagePrims, collect_prims, open_stage, read_stage_info
from usdfoot.readers.terrain import read_terrain

__all__ = ["read_scene"]

_logger = logging.getLogger(__name__)

_ROUNDING = 1e-6


def read_scene(
    scene: str | os.PathLike[str] | Usd.Stage, *, agents: str = "*", frames: tuple[int, int] | None = None
) -> Scene:
    """Everything usdfoot needs of a stage, in canonical space; the stage is not changed.

    What cannot be used becomes a problem of the crowd, and the rest goes on.

    Args:
        scene: File or open stage.
        agents: Glob on the names or prim paths of the agents to read.
        frames: First and last time code of the output; None = from the first strike to the last liftoff of all agents.

    Raises:
        SceneError: If the stage cannot be opened or no agent at all can be used.
    """
    stage = open_stage(scene)
    info = read_stage_info(stage)
    prims = collect_prims(stage)
    everyone, agent_problems = list_agents(stage, prims)
    chosen = select_agents(everyone, agents)
    plans, plan_problems = _read_plans(chosen, info.units)
    codes = _frame_codes(list(plans.values()), info.units, frames)
    terrain, terrain_problems = read_terrain(stage, prims, info.units)
    foreign = (*(source.plan for source in everyone), *(stage.GetPrimAtPath(path) for path in terrain.meshes))
    casting = _Casting(
        stage=stage,
        prims=prims,
        foreign=foreign,
        units=info.units,
        frame_codes=codes,
        finder=ClipFinder(stage, prims),
    )
    cast = [agent for source in chosen if source.name in plans and (agent := casting.cast(source, plans[source.name]))]
    problems = (*agent_problems, *plan_problems, *casting.problems, *casting.unfit_clips(), *terrain_problems)
    _require_agents(info, everyone, cast, problems)
    for problem in problems:
        _logger.log(logging.ERROR if problem.severity == "error" else logging.WARNING, "%s", problem.message)
    crowd = Crowd(
        agents=tuple(cast),
        libraries=tuple(casting.libraries),
        terrain=terrain,
        frame_times=info.units.codes_to_times(codes),
        frame_rate=info.units.time_codes_per_second,
        problems=problems,
    )
    return Scene(stage=info, crowd=crowd, characters=tuple(casting.characters), frame_codes=codes)


@dataclass(kw_only=True)
class _Casting:
    """Gives agents their character and clips, reading each only once."""

    stage: Usd.Stage
    prims: StagePrims
    foreign: tuple[Usd.Prim, ...]
    """Plans and terrain."""
    units: StageUnits
    frame_codes: FloatArray
    finder: ClipFinder
    characters: list[Character] = field(default_factory=list)
    libraries: list[ClipLibrary] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    _only: Usd.Prim | None = None
    _unfit: dict[str, str] = field(default_factory=dict)
    _character_of: dict[object, int | UsdfootError] = field(default_factory=dict)
    _library_of: dict[object, int | UsdfootError] = field(default_factory=dict)

    def cast(self, source: AgentSource, plan: FootstepPlan) -> Agent | None:
        """The agent; None, and a problem noted, if it cannot be used."""
        try:
            options = read_agent_options(source, self.units)
            character, prim = self._character(source)
            library = self._library(source, character, prim, required=options.motion != Motion.PHYSICS)
        except UsdfootError as error:
            self.problems.append(_skipped(source, error))
            return None
        return Agent(
            name=source.name,
            source=str(source.prim.GetPath()),
            plan=plan,
            library=library,
            character=character,
            ik_reach=options.ik_reach,
            root_weight=options.root_weight,
            replace_distance=options.replace_distance,
            motion=options.motion,
        )

    def _character(self, source: AgentSource) -> tuple[int, Usd.Prim]:
        """Index of the agent's character, and its prim."""
        prim = source.character or (source.prim if source.is_authored and _holds_skeleton(source.prim) else None)
        prim = prim or self._only_character()
        key = character_key(prim, self.units)
        if key not in self._character_of:
            try:
                self.characters.append(read_character(prim, self.units, self.frame_codes))
                self._character_of[key] = len(self.characters) - 1
            except UsdfootError as error:
                self._character_of[key] = error
        return _or_raise(self._character_of[key]), prim

    def _only_character(self) -> Usd.Prim:
        """The stage's only character, looked for once."""
        if self._only is None:
            self._only = only_character(self.prims, self.foreign)
        return self._only

    def _library(self, source: AgentSource, character: int, prim: Usd.Prim, *, required: bool) -> int:
        """Index of the library with the agent's clips on its character."""
        key = (character, source.clips, required)
        if key not in self._library_of:
            try:
                clips = self._clips(source, character, find_skeleton(prim), required=required)
                actor = self.characters[character]
                self.libraries.append(ClipLibrary(skeleton=actor.skeleton, biped=actor.biped, clips=clips))
                self._library_of[key] = len(self.libraries) - 1
            except UsdfootError as error:
                self._library_of[key] = error
        return _or_raise(self._library_of[key])

    def _clips(self, source: AgentSource, character: int, skeleton: Usd.Prim, *, required: bool) -> tuple[Clip, ...]:
        """Clips of the agent's scopes that can be used. Clips nobody asked for may be of other skeletons."""
        actor = self.characters[character]
        animations = self.finder.animations_below(source.clips)
        clips, reasons = [], []
        for animation in animations:
            path = str(animation.GetPath())
            try:
                clip_source = self.finder.source_of(animation, skeleton)
                if not source.clips and missing_leg_joints(clip_source, actor.skeleton, actor.biped):
                    self._unfit.setdefault(path, actor.skeleton.name)
                    reasons.append(path)
                    continue
                clips.append(read_clip(clip_source, actor.skeleton, actor.biped, self.units))
            except UsdfootError as error:
                reasons.append(path)
                severity = "error" if source.clips else "warning"
                self.problems.append(Problem(severity=severity, where=path, message=str(error)))
        if required and not clips:
            raise _no_clips(source, actor, len(animations), reasons)
        return tuple(clips)

    def unfit_clips(self) -> tuple[Problem, ...]:
        """A warning for each clip nobody asked for that fits none of the characters."""
        used = {clip.name for library in self.libraries for clip in library.clips}
        return tuple(
            Problem(severity="warning", where=path, message=f"{path}: not used, lacks leg joints of {skeleton}")
            for path, skeleton in self._unfit.items()
            if path not in used
        )


def _read_plans(
    sources: Sequence[AgentSource], units: StageUnits
) -> tuple[dict[str, FootstepPlan], tuple[Problem, ...]]:
    """Plans by agent name, and problems with them."""
    plans: dict[str, FootstepPlan] = {}
    problems: list[Problem] = []
    for source in sources:
        try:
            plans[source.name], warnings = read_plan(source.plan, units)
            problems.extend(warnings)
        except UsdfootError as error:
            problems.append(_skipped(source, error))
    return plans, tuple(problems)


def _frame_codes(plans: Sequence[FootstepPlan], units: StageUnits, frames: tuple[int, int] | None) -> FloatArray:
    """Whole time codes from before the first strike to after the last liftoff of all plans, shape (F,)."""
    if frames is not None:
        if frames[1] < frames[0]:
            raise SceneError("frames", f"{frames[0]}:{frames[1]} is empty", "give the first and the last time code")
        return np.arange(frames[0], frames[1] + 1, dtype=float)
    if not plans:
        return np.zeros(1)
    start = min(float(units.times_to_codes(plan.strike_times[0])) for plan in plans)
    end = max(float(units.times_to_codes(plan.liftoff_times.max())) for plan in plans)
    return np.arange(np.floor(start + _ROUNDING), np.ceil(end - _ROUNDING) + 1.0)


def _require_agents(
    info: StageInfo, everyone: Sequence[AgentSource], cast: Sequence[Agent], problems: Sequence[Problem]
) -> None:
    """Raises SceneError if nothing is left to animate."""
    if cast:
        return
    errors = [problem.message for problem in problems if problem.severity == "error"]
    if not everyone and not errors:
        raise SceneError(
            info.identifier,
            "has no footstep plan",
            "add a PointInstancer with UsdfootPlanAPI: protoIndices, positions, usdfoot:plan:strikeTimes, "
            "usdfoot:plan:liftoffTimes",
        )
    raise SceneError(info.identifier, "no agent can be used", names=errors)


def _no_clips(source: AgentSource, character: Character, count: int, names: Sequence[str]) -> ClipError:
    where = ", ".join(str(path) for path in source.clips) or "the stage"
    if not count:
        return ClipError(where, "has no clips (SkelAnimation prims)", "add some, or point usdfoot:agent:clips at them")
    return ClipError(
        where,
        f"none of {count} clip(s) fits {character.skeleton.name}",
        "their joints must have the names of the Skeleton's leg joints and at least two samples",
        names,
    )


def _skipped(source: AgentSource, error: UsdfootError) -> Problem:
    path = str(source.prim.GetPath())
    message = str(error) if error.where.startswith(path) else f"{path}: {error}"
    return Problem(severity="error", where=path, message=message)


def _or_raise(result: int | UsdfootError) -> int:
    if isinstance(result, UsdfootError):
        raise result
    return result


def _holds_skeleton(prim: Usd.Prim) -> bool:
    return any(below.IsA(UsdSkel.Skeleton) for below in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()))
