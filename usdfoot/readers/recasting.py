"""Recasting: other characters and clips that artists give agents in overrides.usda."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from pxr import Sdf, Usd

from usdfoot.bridge.tokens import Agent, File, Prim
from usdfoot.errors import SceneError
from usdfoot.model.report import Problem
from usdfoot.readers.agents import AgentSource, existing_targets
from usdfoot.readers.authored import targets
from usdfoot.readers.casting import holds_skeleton

__all__ = ["recast"]


def recast(
    sources: Sequence[AgentSource], stage: Usd.Stage, *, everyone: Sequence[AgentSource]
) -> tuple[tuple[AgentSource, ...], tuple[Problem, ...]]:
    """Agents with the characters and clips that artists give them, and warnings of those that are not there.

    Args:
        sources: Agents, with what artists say of each.
        stage: The scene.
        everyone: All of its agents.
    """
    found, problems = [], []
    by_name = {source.name: source for source in everyone}
    for source in sources:
        try:
            found.append(_recast(source, stage, by_name) if source.override else source)
        except SceneError as error:
            where = f"{File.OVERRIDES} {error.where}"
            message = f"{File.OVERRIDES} {error}. what the scene says is kept"
            problems.append(Problem(severity="warning", where=where, message=message))
            found.append(source)
    return tuple(found), tuple(problems)


def _recast(source: AgentSource, stage: Usd.Stage, by_name: Mapping[str, AgentSource]) -> AgentSource:
    """Raises SceneError if artists point at what is not there."""
    over = source.override
    pointed = {name: targets(over, name) for name in (Agent.CHARACTER, Agent.CLIPS)} if over else {}
    if clips := pointed.get(Agent.CLIPS):
        existing_targets(stage, over, Agent.CLIPS, pointed=pointed)
        source = replace(source, clips=tuple(clips))
    for path in pointed.get(Agent.CHARACTER, [])[:1]:
        source = replace(source, character=_character_at(path, stage, over, by_name))
    return source


def _character_at(path: Sdf.Path, stage: Usd.Stage, over: Usd.Prim, by_name: Mapping[str, AgentSource]) -> Usd.Prim:
    """The character at a path of the scene, or that of another agent at its path in the crowd."""
    other = by_name.get(path.name) if path.GetParentPath() == Prim.AGENTS else None
    prim = stage.GetPrimAtPath(path) if other is None else other.character or other.prim
    if not prim or not prim.IsActive() or not holds_skeleton(prim):
        what = f"{Agent.CHARACTER} points at no character"
        raise SceneError(over.GetPath(), what, "give a prim of the scene, or an agent", [path])
    return prim
