"""Listing: what there is on a stage and who its agents are, before it is known how they move."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

from pxr import Usd

from usdfoot.bridge.scene import StageInfo
from usdfoot.model.limits import DEFAULT_LIMITS, Limits, check_limit
from usdfoot.model.report import Problem
from usdfoot.readers.agents import AgentSource, list_agents, select_agents
from usdfoot.readers.skeleton import check_skeletons
from usdfoot.readers.stage import StagePrims, collect_prims, composition_problems, open_stage, read_stage_info

__all__ = ["ListedScene", "list_scene"]


@dataclass(frozen=True, kw_only=True)
class ListedScene:
    """An open stage that was walked through once."""

    stage: Usd.Stage
    info: StageInfo
    prims: StagePrims
    everyone: tuple[AgentSource, ...]
    """All agents of the stage."""
    chosen: tuple[AgentSource, ...]
    """Those that are asked for."""
    problems: tuple[Problem, ...]
    """Agents that cannot be used, and what the stage lacks."""


def list_scene(
    scene: str | os.PathLike[str] | Usd.Stage,
    *,
    agents: str | Sequence[str] = "*",
    limits: Limits = DEFAULT_LIMITS,
    reload: bool = False,
) -> ListedScene:
    """What there is on a stage.

    Args:
        scene: File or open stage; never changed.
        agents: Glob on the names or prim paths of the agents that are asked for, or several.
        limits: How much of a scene is read.
        reload: Read the files again where this process has read them before.

    Raises:
        SceneError: If the stage cannot be opened, the glob matches nobody, or it is too large.
    """
    stage = open_stage(scene)
    if reload:
        stage.Reload()
    prims = collect_prims(stage, most=limits.prims)
    info = read_stage_info(stage)
    everyone, problems = list_agents(stage, prims)
    check_limit(info.identifier, "agents", len(everyone), limit=limits.agents)
    check_skeletons(prims.skeletons, limits)
    return ListedScene(
        stage=stage,
        info=info,
        prims=prims,
        everyone=everyone,
        chosen=select_agents(everyone, agents),
        problems=(*problems, *composition_problems(stage)),
    )
