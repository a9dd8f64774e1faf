"""The worst step of a crowd: where to look first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pxr import Sdf, Usd

from usdfoot.bridge.tokens import Agent, Plan, Prim, Result
from usdfoot.errors import SceneError
from usdfoot.maths.types import FloatArray
from usdfoot.readers.authored import authored, targets
from usdfoot.readers.stage import read_stage_info
from usdfoot.usdview.selection import Selection, all_agents, selected_agents

__all__ = ["WorstStep", "find_worst_step"]


@dataclass(frozen=True, kw_only=True)
class WorstStep:
    """The footstep that is missed by most."""

    agent: Sdf.Path
    plan: Sdf.Path
    number: int
    """Of the footstep in its plan."""
    time: Usd.TimeCode
    """When the foot comes down."""
    placement_error: float
    """[m]."""
    status: str


def find_worst_step(stage: Usd.Stage, selection: Selection, time: Usd.TimeCode) -> WorstStep:
    """The step of the selected agents, or of all, with the largest placement error.

    Args:
        stage: Open stage of a crowd.
        selection: Whose agents.
        time: Not needed: all times are looked at.

    Raises:
        SceneError: If the stage has no agents, or no results are recorded on their plans.
    """
    best: WorstStep | None = None
    scale = read_stage_info(stage).units.meters_per_unit
    for name in selected_agents(stage, selection) or all_agents(stage):
        agent = Sdf.Path(Prim.AGENTS).AppendChild(name)
        for path in targets(stage.GetPrimAtPath(agent), Agent.PLAN):
            plan = stage.GetPrimAtPath(path)
            errors = scale * _values(plan, Result.PLACEMENT_ERROR)
            strikes = _values(plan, Plan.STRIKE_TIMES)
            known = np.isfinite(errors)
            if len(errors) != len(strikes) or not known.any():
                continue
            number = int(np.argmax(np.where(known, errors, -np.inf)))
            if best is None or errors[number] > best.placement_error:
                statuses = authored(plan, Result.STATUS) or ()
                best = WorstStep(
                    agent=agent,
                    plan=path,
                    number=number,
                    time=Usd.TimeCode(float(strikes[number])),
                    placement_error=float(errors[number]),
                    status=str(statuses[number]) if len(statuses) == len(errors) else "",
                )
    if best is None:
        raise SceneError(stage.GetRootLayer().identifier, "records no results", "animate it with usdfoot animate")
    return best


def _values(prim: Usd.Prim, name: str) -> FloatArray:
    """Numbers of an attribute, none if it is not authored."""
    values = authored(prim, name) if prim else None
    return np.array([float(value) for value in values or ()])
