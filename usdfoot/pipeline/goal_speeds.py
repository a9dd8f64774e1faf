"""Goal speeds: agents with goals step as the clips of their characters do, and go no faster than these show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from usdfoot.analysis.examples import build_examples
from usdfoot.analysis.gaits import RUNNING_FROUDE
from usdfoot.analysis.timing import EARTH_GRAVITY
from usdfoot.bridge.tokens import Agent as Token
from usdfoot.bridge.tokens import Motion
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import UsdfootError
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.report import Problem
from usdfoot.planning.habits import PEOPLE, Habits, find_habits
from usdfoot.readers.goals import GoalAgent, read_agent_libraries
from usdfoot.readers.stage import authored

__all__ = ["fit_to_clips"]


def fit_to_clips(
    stage: Any, prims: Any, units: StageUnits, *, agents: Sequence[GoalAgent]
) -> tuple[tuple[GoalAgent, ...], tuple[Problem, ...]]:
    """The agents with the habits of their clips, runners faster than their clips slowed down to them, and who that is.

    Agents without clips, and those whom physics moves, step as people do and keep their speeds.

    Args:
        stage: Open stage.
        prims: Its prims.
        units: Its units.
        agents: With goals.
    """
    moved = [agent.source for agent in agents if authored(agent.source.prim, Token.MOTION) != Motion.PHYSICS]
    libraries = read_agent_libraries(stage, prims, units, sources=moved)[0]
    different = {id(library): library for library in libraries.values()}
    gaits = {number: _gait_of(library) for number, library in different.items()}
    fitted, problems = [], []
    for agent in agents:
        library, seeker = libraries.get(agent.source.name), agent.seeker
        top, habits = gaits[id(library)] if library is not None else (np.inf, PEOPLE)
        if _runs(agent) and seeker.speed > top:
            what = (
                f"{seeker.name}: wants to go {seeker.speed:.2f} m/s; {top:.2f} m/s were taken, as fast as its clips go"
            )
            problems.append(Problem(severity="warning", where=seeker.name, message=what))
            seeker = replace(seeker, speed=top)
        fitted.append(replace(agent, seeker=replace(seeker, body=replace(seeker.body, habits=habits))))
    return tuple(fitted), tuple(problems)


def _runs(agent: GoalAgent) -> bool:
    """Whether an agent wants to go faster than people walk."""
    return agent.seeker.speed > np.sqrt(RUNNING_FROUDE * EARTH_GRAVITY * agent.seeker.body.leg_length)


def _gait_of(library: ClipLibrary) -> tuple[float, Habits]:
    """Speed of the fastest step of a library [m/s] and how it steps; without any step there is no limit."""
    try:
        examples, _ = build_examples(library)
    except UsdfootError:  # animating it tells why
        return float("inf"), PEOPLE
    speeds = np.linalg.norm(examples.landings, axis=1) / examples.durations
    top = float(speeds.max(initial=0.0)) or float("inf")
    return top, find_habits(examples, leg_length=library.biped.maximal_leg_length)
