"""Agents: who walks which plan with which character and clips."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

from pxr import Sdf, Usd

from usdfoot.bridge.tokens import Agent as Token
from usdfoot.bridge.tokens import Motion, Schema
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import PlanError, SceneError
from usdfoot.model.report import Problem
from usdfoot.readers.authored import authored, authored_values, targets
from usdfoot.readers.plans import is_plan
from usdfoot.readers.stage import StagePrims

__all__ = [
    "OPTIONS",
    "AgentOptions",
    "AgentSource",
    "existing_targets",
    "list_agents",
    "list_agents_without_plans",
    "read_agent_options",
    "said_of",
    "select_agents",
]

IK_REACH = 0.3
"""Largest IK correction where none is authored [m]."""
_WALKED = (Token.PLAN, Token.PATH, Token.TRAJECTORY)
"""Relationships of which one says where an agent goes."""
_RELATIONSHIPS = (*_WALKED, Token.CHARACTER, Token.CLIPS)
OPTIONS = (Token.MOTION, Token.ROOT_WEIGHT, Token.REPLACE_DISTANCE, Token.IK_REACH)
"""Attributes of `AgentOptions`."""


@dataclass(frozen=True, kw_only=True)
class AgentSource:
    """Where an agent's parts are on the stage."""

    name: str
    """Name of the agent prim, unique."""
    prim: Usd.Prim
    """The agent prim; without UsdfootAgentAPI on the stage, the plan."""
    plan: Usd.Prim
    """The plan's prim; of an agent that has none but follows a path or a trajectory, that prim."""
    character: Usd.Prim | None
    """Prim that holds the character; None = the agent prim, or the only character of the stage."""
    clips: tuple[Sdf.Path, ...]
    """Scopes and collections of clips; empty = every clip that fits."""
    is_authored: bool
    """Whether the prim has UsdfootAgentAPI."""
    properties: tuple[str, ...]
    """Names of what is authored on the prim."""
    path: Usd.Prim | None = None
    """The curve that an agent without a plan follows."""
    trajectory: Usd.Prim | None = None
    """What an agent without plan and path follows."""
    number: int | None = None
    """Which of the points of a trajectory is the agent's."""
    override: Usd.Prim | None = None
    """What artists say of the written agent in overrides.usda, over the agent prim."""


@dataclass(frozen=True, kw_only=True)
class AgentOptions:
    """Numbers and tokens of UsdfootAgentAPI."""

    motion: str = Motion.CLIPS
    root_weight: float = 0.0
    replace_distance: float = 0.0
    """[m]"""
    ik_reach: float = IK_REACH
    """[m]"""


def list_agents(stage: Usd.Stage, prims: StagePrims) -> tuple[tuple[AgentSource, ...], tuple[Problem, ...]]:
    """All agents of a stage, and those that cannot be used with the reason.

    Without any UsdfootAgentAPI every plan is walked by an agent of its own, named as the plan.
    """
    named = set(prims.with_apis.get(Schema.PLAN, ()))
    plans = [prim for prim in prims.instancers if prim in named or is_plan(prim)]
    marked = prims.with_apis.get(Schema.AGENT, ())
    if not marked:
        names = _unique_names([plan.GetName() for plan in plans])
        return tuple(
            AgentSource(
                name=name,
                prim=plan,
                plan=plan,
                character=None,
                clips=(),
                is_authored=False,
                properties=tuple(plan.GetAuthoredPropertyNames()),
            )
            for name, plan in zip(names, plans, strict=True)
        ), ()
    properties = [tuple(prim.GetAuthoredPropertyNames()) for prim in marked]
    pointed = [_pointed(prim, own) for prim, own in zip(marked, properties, strict=True)]
    claimed = {path for found in pointed for path in found.get(Token.PLAN, ())}
    unclaimed = [plan for plan in plans if plan.GetPath() not in claimed]
    default = unclaimed[0] if len(unclaimed) == 1 and sum(map(_is_idle, pointed)) == 1 else None
    sources, problems = [], []
    names = _unique_names([prim.GetName() for prim in marked])
    for name, prim, own, found in zip(names, marked, properties, pointed, strict=True):
        try:
            sources.append(_source(stage, prim, name, own, found, default))
        except (PlanError, SceneError) as error:
            problems.append(Problem(severity="error", where=str(prim.GetPath()), message=str(error)))
        problems += _unused_targets(prim, found)
    if default is None:
        problems += [_nobody_walks(plan) for plan in unclaimed]
    return tuple(sources), tuple(problems)


def list_agents_without_plans(
    stage: Usd.Stage, prims: StagePrims, *, with_goals: bool
) -> tuple[tuple[AgentSource, ...], tuple[Problem, ...]]:
    """Agents to make plans for, and those that cannot be used: those with a goal, or all that follow nothing."""
    marked = prims.with_apis.get(Schema.AGENT, ())
    sources, problems = [], []
    for name, prim in zip(_unique_names([prim.GetName() for prim in marked]), marked, strict=True):
        own = tuple(prim.GetAuthoredPropertyNames())
        found = _pointed(prim, own)
        has_goal = bool(targets(prim, Token.GOAL))
        if not has_goal and (with_goals or not _is_idle(found)):
            continue
        try:
            sources.append(_source(stage, prim, name, own, found, prim))
        except (PlanError, SceneError) as error:
            problems.append(Problem(severity="error", where=str(prim.GetPath()), message=str(error)))
    return tuple(sources), tuple(problems)


def select_agents(sources: Sequence[AgentSource], patterns: str | Sequence[str]) -> tuple[AgentSource, ...]:
    """Agents whose name or prim path matches a glob pattern, or one of several.

    Raises:
        SceneError: If there are agents but none matches.
    """
    globs = (patterns,) if isinstance(patterns, str) else tuple(patterns)
    if "*" in globs:
        return tuple(sources)
    chosen = tuple(
        source
        for source in sources
        if any(fnmatchcase(text, glob) for text in (source.name, str(source.prim.GetPath())) for glob in globs)
    )
    if sources and not chosen:
        raise SceneError(
            f"agents {' '.join(globs)}",
            "match none of the scene's agents",
            "give a glob of their names or paths",
            [s.name for s in sources],
        )
    return chosen


def said_of(source: AgentSource, names: Collection[str]) -> dict[str, Any]:
    """Values authored for attributes of an agent, by name, those of the artists' overrides over the scene's."""
    overriding = authored_values(source.override, names) if source.override else {}
    found = {name: authored(source.prim, name) for name in source.properties if name in names}
    return {**{name: value for name, value in found.items() if value is not None}, **overriding}


def read_agent_options(source: AgentSource, units: StageUnits) -> AgentOptions:
    """Options authored on the agent prim, and over it.

    Raises:
        SceneError: If a value is outside its range.
    """
    said = said_of(source, OPTIONS)
    motion = str(said.get(Token.MOTION) or Motion.CLIPS)
    if motion not in Motion.ALL:
        raise SceneError(source.prim.GetPath(), f"{Token.MOTION} is {motion}", f"author one of {', '.join(Motion.ALL)}")
    return AgentOptions(
        motion=motion,
        root_weight=_number(source.prim, said, Token.ROOT_WEIGHT, 0.0, upper=1.0),
        replace_distance=_number(source.prim, said, Token.REPLACE_DISTANCE, 0.0) * units.meters_per_unit,
        ik_reach=_number(source.prim, said, Token.IK_REACH, IK_REACH / units.meters_per_unit) * units.meters_per_unit,
    )


def _pointed(prim: Usd.Prim, properties: Sequence[str]) -> dict[str, list[Sdf.Path]]:
    """What an agent's relationships point at, by name; without those that point at nothing."""
    found = {name: targets(prim, name) for name in properties if name in _RELATIONSHIPS}
    return {name: paths for name, paths in found.items() if paths}


def _source(
    stage: Usd.Stage,
    prim: Usd.Prim,
    name: str,
    properties: tuple[str, ...],
    pointed: Mapping[str, list[Sdf.Path]],
    default_plan: Usd.Prim | None,
) -> AgentSource:
    """Raises PlanError or SceneError if a relationship is missing or points nowhere."""
    plan = _target(stage, prim, Token.PLAN, pointed)
    path = _target(stage, prim, Token.PATH, pointed) if plan is None else None
    trajectory = _target(stage, prim, Token.TRAJECTORY, pointed) if plan is None and path is None else None
    number = authored(prim, Token.ID) if Token.ID in properties else None
    existing_targets(stage, prim, Token.CLIPS, pointed=pointed)
    return AgentSource(
        name=name,
        prim=prim,
        plan=plan or path or trajectory or _default_plan(prim, default_plan),
        path=path,
        character=_target(stage, prim, Token.CHARACTER, pointed),
        clips=tuple(pointed.get(Token.CLIPS, ())),
        is_authored=True,
        properties=properties,
        trajectory=trajectory,
        number=None if number is None else int(number),
    )


def _unused_targets(prim: Usd.Prim, pointed: Mapping[str, list[Sdf.Path]]) -> list[Problem]:
    """A warning for each relationship of an agent with several targets of which one can count."""
    problems = []
    for name in (*_WALKED, Token.CHARACTER):
        first, *others = pointed.get(name, (None,))
        if others:
            unused = ", ".join(map(str, others))
            message = f"{prim.GetPath()}: {name} has several targets, {first} is used. remove {unused}"
            problems.append(Problem(severity="warning", where=str(prim.GetPath()), message=message))
    return problems


def _is_idle(pointed: Mapping[str, list[Sdf.Path]]) -> bool:
    """Whether an agent says nothing of where it goes."""
    return not any(name in pointed for name in _WALKED)


def _default_plan(prim: Usd.Prim, default: Usd.Prim | None) -> Usd.Prim:
    if default is None:
        raise PlanError(
            prim.GetPath(),
            "has no footstep plan",
            f"point {Token.PLAN} at a PointInstancer with UsdfootPlanAPI, {Token.PATH} at BasisCurves, or "
            f"{Token.TRAJECTORY} at an animated Xform"
            + ("; or let usdfoot plan crowd make a plan" if targets(prim, Token.GOAL) else ""),
        )
    return default


def _target(stage: Usd.Stage, prim: Usd.Prim, name: str, pointed: Mapping[str, list[Sdf.Path]]) -> Usd.Prim | None:
    existing = existing_targets(stage, prim, name, pointed=pointed)
    return existing[0] if existing else None


def existing_targets(
    stage: Usd.Stage, prim: Usd.Prim, name: str, *, pointed: Mapping[str, list[Sdf.Path]]
) -> list[Usd.Prim]:
    """Targets of a relationship, all of which must exist and be active, as what is below them must."""
    found = pointed.get(name, [])
    prims = [_holder(stage, path) if name == Token.CLIPS else stage.GetPrimAtPath(path) for path in found]
    if all(target and target.IsActive() for target in prims):
        return prims
    absent = [path for path, target in zip(found, prims, strict=True) if not target]
    if absent:
        raise SceneError(prim.GetPath(), f"{name} points at what does not exist", "correct the target", absent)
    muted = [path for path, target in zip(found, prims, strict=True) if not target.IsActive()]
    raise SceneError(prim.GetPath(), f"{name} points at what is inactive", "activate it, or mute the agent", muted)


def _holder(stage: Usd.Stage, path: Sdf.Path) -> Usd.Prim:
    """The prim at a path, or that has the collection there; invalid where there is neither."""
    collection = Usd.CollectionAPI.GetCollection(stage, path) if path.IsPropertyPath() else None
    return collection.GetPrim() if collection else stage.GetPrimAtPath(path)


def _number(prim: Usd.Prim, said: Mapping[str, Any], name: str, default: float, *, upper: float = math.inf) -> float:
    value = said.get(name)
    if value is None:
        return default
    if not (math.isfinite(value) and 0.0 <= value <= upper):
        limits = f"between 0 and {upper:g}" if math.isfinite(upper) else "of at least 0"
        raise SceneError(prim.GetPath(), f"{name} is {value:g}", f"author a number {limits}")
    return float(value)


def _nobody_walks(plan: Usd.Prim) -> Problem:
    message = f"{plan.GetPath()}: no agent walks this plan. point an agent's {Token.PLAN} at it"
    return Problem(severity="warning", where=str(plan.GetPath()), message=message)


def _unique_names(names: Sequence[str]) -> list[str]:
    """Names with _1, _2 and so on added to those that occurred before."""
    taken = set(names)
    seen: set[str] = set()
    unique = []
    for name in names:
        candidate, count = name, 0
        while candidate in seen or (count > 0 and candidate in taken):
            count += 1
            candidate = f"{name}_{count}"
        seen.add(candidate)
        unique.append(candidate)
    return unique
