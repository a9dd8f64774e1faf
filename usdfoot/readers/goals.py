"""Goals: agents that want to get somewhere, and what stands in their way."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from pxr import Usd

from usdfoot.bridge.tokens import Agent as Token
from usdfoot.bridge.tokens import Schema
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import PlanError, SceneError, UsdfootError
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.report import Problem
from usdfoot.planning.scenario import Scenario, Walker
from usdfoot.readers.obstacles import read_obstacles
from usdfoot.readers.skeleton import matrices_of
from usdfoot.readers.stage import StagePrims, authored, start_code, targets

__all__ = ["read_scenario", "read_walker"]


def read_scenario(
    stage: Usd.Stage, prims: StagePrims, units: StageUnits, *, speed: float, radius: float
) -> tuple[Scenario, tuple[Problem, ...]]:
    """Agents with usdfoot:agent:goal where their prims stand, the obstacles, and what could not be used.

    Args:
        stage: Open stage, read at its start.
        prims: Its prims.
        units: Its units.
        speed: Of agents that author none [m/s].
        radius: Of their bodies [m].
    """
    obstacles, problems = read_obstacles(stage, prims, units)
    walkers, faults = [], list(problems)
    for prim in prims.with_apis.get(Schema.AGENT, ()):
        if not targets(prim, Token.GOAL):
            continue
        try:
            walkers.append(read_walker(stage, prim, units, speed=speed, radius=radius))
        except UsdfootError as error:
            faults.append(Problem(severity="error", where=error.where, message=str(error)))
    return Scenario(walkers=tuple(walkers), obstacles=obstacles, bounds=None), tuple(faults)


def read_walker(stage: Usd.Stage, prim: Usd.Prim, units: StageUnits, *, speed: float, radius: float) -> Walker:
    """An agent prim as a walker: it stands at its origin and faces as its character would.

    Raises:
        SceneError: If a goal does not exist or the speed is no number of at least 0.
        PlanError: If a place is not finite.
    """
    wanted = authored(prim, Token.SPEED) or 0.0
    if not (math.isfinite(wanted) and wanted >= 0.0):
        raise SceneError(prim.GetPath(), f"{Token.SPEED} is {wanted:g}", "author a number of at least 0")
    paths = targets(prim, Token.GOAL)
    absent = [path for path in paths if not stage.GetPrimAtPath(path)]
    if absent:
        raise SceneError(prim.GetPath(), f"{Token.GOAL} points at what does not exist", "correct the target", absent)
    matrix = _matrix(stage, prim)
    places = [_matrix(stage, stage.GetPrimAtPath(path))[3, :3] for path in paths]
    goals = units.points_to_canonical(np.array(places).reshape(-1, 3))
    return Walker(
        name=str(prim.GetPath()),
        start=units.points_to_canonical(matrix[3, :3]),
        yaw=_yaw(prim, units, matrix),
        goals=goals,
        speed=wanted * units.meters_per_unit or speed,
        radius=radius,
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
