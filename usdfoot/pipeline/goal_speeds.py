"""Goal speeds: agents with goals go no faster than the clips of their characters show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from usdfoot.analysis.gaits import RUNNING_FROUDE
from usdfoot.analysis.timing import EARTH_GRAVITY
from usdfoot.batch.analysed import build_once
from usdfoot.bridge.tokens import Agent as Token
from usdfoot.bridge.tokens import Motion
from usdfoot.bridge.units import StageUnits
from usdfoot.engine.options import EngineOptions
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.report import Problem
from usdfoot.planning.habits import fastest_step
from usdfoot.readers.authored import authored
from usdfoot.readers.goals import GoalAgent, read_agent_libraries

__all__ = ["slow_to_clips"]


def slow_to_clips(
    stage: Any, prims: Any, units: StageUnits, *, agents: Sequence[GoalAgent]
) -> tuple[tuple[GoalAgent, ...], tuple[Problem, ...]]:
    """The agents, those that want to go faster than their clips do slowed down to them, and who that is.

    Clips are read only where somebody wants to go faster than people walk. Agents without clips, and those whom physics
    moves, keep their speeds.

    Args:
        stage: Open stage.
        prims: Its prims.
        units: Its units.
        agents: With goals.
    """
    quick = [agent for agent in agents if _runs(agent) and authored(agent.source.prim, Token.MOTION) != Motion.PHYSICS]
    sources = [agent.source for agent in quick]
    libraries = read_agent_libraries(stage, prims, units, sources=sources)[0] if quick else {}
    different = {id(library): library for library in libraries.values()}
    tops = {number: _top_speed(library) for number, library in different.items()}
    slowed, problems = [], []
    for agent in agents:
        library = libraries.get(agent.source.name)
        top = tops[id(library)] if library is not None else np.inf
        seeker = agent.seeker
        if seeker.speed > top:
            what = (
                f"{seeker.name}: wants to go {seeker.speed:.2f} m/s; {top:.2f} m/s were taken, as fast as its clips go"
            )
            problems.append(Problem(severity="warning", where=seeker.name, message=what))
            agent = replace(agent, seeker=replace(seeker, speed=top))
        slowed.append(agent)
    return tuple(slowed), tuple(problems)


def _runs(agent: GoalAgent) -> bool:
    """Whether an agent wants to go faster than people walk."""
    return agent.seeker.speed > np.sqrt(RUNNING_FROUDE * EARTH_GRAVITY * agent.seeker.body.leg_length)


def _top_speed(library: ClipLibrary) -> float:
    """Speed of the fastest step of a library [m/s]; without any step there is no limit."""
    if not library.clips:
        return float("inf")
    examples, _ = build_once(library, samples=EngineOptions().samples)
    return fastest_step(examples)
