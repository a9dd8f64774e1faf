"""A layer of footstep plans, to sublayer over the scene they were made for."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Vt

from usdfoot.bridge import tokens
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import OutputError
from usdfoot.model.plan import FootstepPlan
from usdfoot.writers.footsteps import author_plan, print_models
from usdfoot.writers.layers import LayerFormat, author, author_targets, define_prim, new_layer
from usdfoot.writers.paths import layer_path
from usdfoot.writers.plan_edits import PlanEdit, author_plan_edit
from usdfoot.writers.staging import staged_files

__all__ = ["PLANS_SCOPE", "PlannedAgent", "write_plans"]

PLANS_SCOPE = "/Plans"
"""Where the plans stand in the layer."""


@dataclass(frozen=True, kw_only=True)
class PlannedAgent:
    """One plan to write."""

    name: str
    """Name of the plan's prim, unique."""
    plan: FootstepPlan
    size: float = 0.13
    """Of the prints: distance from ankle to ball [m]."""
    agent: str = ""
    """Path of the agent prim that shall walk it; empty = none."""
    style: str = ""
    """Style to walk in; empty = the agent's own."""


def write_plans(
    file: str | os.PathLike[str],
    plans: Sequence[PlannedAgent],
    *,
    units: StageUnits,
    frames_per_second: float,
    edits: Sequence[PlanEdit] = (),
    sources: Sequence[str] = (),
    provenance: Mapping[str, Any] | None = None,
) -> Path:
    """Write /Plans/<name> for every plan, an `over` of each agent that points its usdfoot:agent:plan there, and edits.

    Args:
        file: .usd, .usda or .usdc to write, replaced if it exists.
        plans: New ones.
        edits: Of plans where they stand.
        units: Of the scene the layer belongs to.
        frames_per_second: Its playback rate.
        sources: Layers of the scene, which must not be replaced.
        provenance: For `customLayerData["usdfoot"]`.

    Raises:
        OutputError: If the file's name is no USD layer's, would replace the scene, or cannot be written.
    """
    target = layer_path(file, sources=sources)
    if not (plans or edits):
        raise OutputError(file, "there is no plan to write", "plan at least one agent or curve")
    layer = _layer_of(plans, edits, units, frames_per_second)
    layer.customLayerData = {tokens.PROVENANCE: dict(provenance or {})}
    with staged_files(target.parent) as files:
        files.add_layer(target.name, layer)
    return target


def _layer_of(
    plans: Sequence[PlannedAgent], edits: Sequence[PlanEdit], units: StageUnits, frames_per_second: float
) -> Sdf.Layer:
    """The layer in memory."""
    every = [part.plan for part in plans] + [edit.plan for edit in edits]
    codes = [units.times_to_codes(plan.strike_times[0]) for plan in every]
    ends = [units.times_to_codes(plan.liftoff_times.max()) for plan in every]
    layer_format = LayerFormat(
        units=units, frames_per_second=frames_per_second, start_code=float(min(codes)), end_code=float(max(ends))
    )
    layer = new_layer(layer_format, text=True)
    if plans:
        layer.defaultPrim = Sdf.Path(PLANS_SCOPE).name
    else:
        layer.ClearDefaultPrim()
    with Sdf.ChangeBlock():
        for edit in edits:
            author_plan_edit(layer, edit, units)
        if plans:
            define_prim(layer, PLANS_SCOPE, "Scope")
    for part in plans:
        path = f"{PLANS_SCOPE}/{part.name}"
        with Sdf.ChangeBlock():
            prim = author_plan(layer, path, part.plan, prints=print_models(part.size, units), units=units)
            styles = part.plan.styles or (part.style,) * len(part.plan)
            if any(styles):
                author(
                    prim, tokens.Plan.STYLES, Sdf.ValueTypeNames.TokenArray, value=Vt.TokenArray(styles), uniform=True
                )
            if part.plan.root_weights.any():
                weights = Vt.FloatArray.FromNumpy(part.plan.root_weights.astype(np.float32))
                author(prim, tokens.Plan.ROOT_WEIGHTS, Sdf.ValueTypeNames.FloatArray, value=weights, uniform=True)
            if part.agent:
                author_targets(Sdf.CreatePrimInLayer(layer, part.agent), tokens.Agent.PLAN, [path])
    return layer
