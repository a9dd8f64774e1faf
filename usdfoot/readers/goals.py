"""Goals: agents without footsteps that want to get somewhere, from where their prims stand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Usd

from usdfoot.bridge.tokens import Agent as Token
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import PlanError, SceneError, UsdfootError
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.report import Problem
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.scenario import Seeker
from usdfoot.readers.agents import AgentSource
from usdfoot.readers.authored import authored, targets
from usdfoot.readers.casting import Casting, skipped
from usdfoot.readers.habits import HabitsReader
from usdfoot.readers.skeleton import matrices_of
from usdfoot.readers.stage import StagePrims, start_code

__all__ = ["GoalAgent", "read_agent_libraries", "read_goal_agents"]


@dataclass(frozen=True, kw_only=True)
class GoalAgent:
    """An agent to make a plan for."""

    source: AgentSource
    seeker: Seeker
    """Named as the agent's prim path."""
    authored_speed: float
    """usdfoot:agent:speed [m/s], 0 = none."""


def read_goal_agents(
    stage: Usd.Stage,
    prims: StagePrims,
    units: StageUnits,
    *,
    sources: Sequence[AgentSource],
    speed: float,
    radius: float,
    habits: HabitsReader | None = None,
) -> tuple[tuple[GoalAgent, ...], tuple[Problem, ...]]:
    """Agents where their prims stand at the stage's start, and those that cannot be used.

    An agent whose character cannot be found is taken for a person.

    Args:
        stage: Open stage.
        prims: Its prims.
        units: Its units.
        sources: The agents.
        speed: Of agents that author none [m/s].
        radius: Of their bodies [m].
        habits: Finds how they step; None = all as people do.
    """
    casting = Casting.to_look(stage, prims, units)
    agents, problems = [], []
    for source in sources:
        try:
            body = habits.body_of(casting, source) if habits else casting.body_of(source)
            own = _read_speed(source.prim, units)
            seeker = _read_seeker(stage, source.prim, units, speed=own or speed, radius=radius, body=body)
            agents.append(GoalAgent(source=source, seeker=seeker, authored_speed=own))
        except UsdfootError as error:
            problems.append(skipped(source, error))
    return tuple(agents), tuple(problems)


def read_agent_libraries(
    stage: Usd.Stage, prims: StagePrims, units: StageUnits, *, sources: Sequence[AgentSource]
) -> tuple[dict[str, ClipLibrary], tuple[Problem, ...]]:
    """Clip libraries of agents on their characters by the agents' names, and why some have none."""
    casting = Casting.to_look(stage, prims, units)
    libraries, problems = {}, []
    for source in sources:
        try:
            libraries[source.name] = casting.library_of(source)
        except UsdfootError as error:
            problems.append(skipped(source, error))
    return libraries, tuple(problems)


def _read_speed(prim: Usd.Prim, units: StageUnits) -> float:
    """Authored speed of an agent [m/s], 0 = none; raises SceneError if it is no number of at least 0."""
    wanted = authored(prim, Token.SPEED) or 0.0
    if not (math.isfinite(wanted) and wanted >= 0.0):
        raise SceneError(prim.GetPath(), f"{Token.SPEED} is {wanted:g}", "author a number of at least 0")
    return float(wanted) * units.meters_per_unit


def _read_seeker(
    stage: Usd.Stage, prim: Usd.Prim, units: StageUnits, *, speed: float, radius: float, body: Proportions
) -> Seeker:
    """An agent prim as a seeker: it stands at its origin and faces as its character would.

    Raises:
        SceneError: If a goal does not exist.
        PlanError: If a place is not finite or the prim faces up or down.
    """
    paths = targets(prim, Token.GOAL)
    absent = [path for path in paths if not stage.GetPrimAtPath(path)]
    if absent:
        raise SceneError(prim.GetPath(), f"{Token.GOAL} points at what does not exist", "correct the target", absent)
    matrix = _matrix(stage, prim)
    places = [_matrix(stage, stage.GetPrimAtPath(path))[3, :3] for path in paths]
    return Seeker(
        name=str(prim.GetPath()),
        start=units.points_to_canonical(matrix[3, :3]),
        yaw=_yaw(prim, units, matrix),
        goals=units.points_to_canonical(np.array(places, dtype=float).reshape(-1, 3)),
        speed=speed,
        radius=radius,
        body=body,
    )


def _yaw(prim: Usd.Prim, units: StageUnits, matrix: FloatArray) -> float:
    """Where the prim faces [rad]: its +Z on a Y-up stage, its -Y on a Z-up stage."""
    forward = units.directions_to_canonical(units.directions_to_stage(np.array([0.0, 0.0, 1.0])) @ matrix[:3, :3])
    if not np.isfinite(forward).all() or np.hypot(forward[0], forward[2]) < 1e-9:
        raise PlanError(prim.GetPath(), "faces straight up or down", "turn it upright")
    return float(planar.yaw_of(forward[[0, 2]]))


def _matrix(stage: Usd.Stage, prim: Usd.Prim) -> FloatArray:
    """Prim to world (row vectors) at the stage's start, shape (4, 4)."""
    return matrices_of(prim, np.array([start_code(stage).GetValue()]))[0]
