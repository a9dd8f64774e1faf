"""Edits of plans where they stand: in the artists' layer of a crowd, or in a layer over a scene."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pxr import Sdf, Tf, Vt

from usdfoot.bridge.tokens import Plan
from usdfoot.bridge.units import StageUnits
from usdfoot.bridge.usd_errors import usd_reason
from usdfoot.errors import OutputError
from usdfoot.maths.types import FloatArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.plan_draft import PlanDraft
from usdfoot.writers.footsteps import in_frame
from usdfoot.writers.layers import author, rounded_codes

__all__ = ["PlanEdit", "author_plan_edit", "restore_layer", "save_plan_edit"]

ValueTypes = Sdf.ValueTypeNames


@dataclass(frozen=True, kw_only=True)
class PlanEdit:
    """A plan that was changed."""

    plan: FootstepPlan
    """As edited, named by its prim."""
    before: FootstepPlan | PlanDraft
    """As it was."""
    frame: FloatArray
    """From the plan's prim to the world (row vectors, stage units), shape (4, 4)."""


def save_plan_edit(file: Path, edit: PlanEdit, *, units: StageUnits) -> Sdf.Layer:
    """Author over a plan what an edit changed of it, and save the layer; gives back what it held before, in memory.

    Args:
        file: overrides.usda of the crowd.
        edit: To save.
        units: Of the crowd.

    Raises:
        OutputError: If the layer cannot be changed or saved.
    """
    layer = Sdf.Layer.FindOrOpen(str(file))
    if layer is None:
        raise OutputError(file, "cannot be opened", "make the crowd again: usdfoot animate writes it")
    kept = Sdf.Layer.CreateAnonymous(".usda")
    kept.TransferContent(layer)
    with Sdf.ChangeBlock():
        author_plan_edit(layer, edit, units)
    _save(layer)
    return kept


def restore_layer(file: Path, kept: Sdf.Layer) -> None:
    """Put back what a layer held, as `save_plan_edit` gave it, and save it.

    Raises:
        OutputError: If the layer cannot be saved.
    """
    layer = Sdf.Layer.FindOrOpen(str(file))
    layer.TransferContent(kept)
    _save(layer)


def _save(layer: Sdf.Layer) -> None:
    try:
        saved = layer.Save()
    except Tf.ErrorException as error:
        raise OutputError(layer.realPath, "cannot be saved", usd_reason(error)) from error
    if not saved:
        raise OutputError(layer.realPath, "cannot be saved", "make it writable")


def author_plan_edit(layer: Sdf.Layer, edit: PlanEdit, units: StageUnits) -> None:
    """Author over a plan's prim those of its attributes that an edit changed."""
    plan, before = edit.plan, edit.before
    prim = Sdf.CreatePrimInLayer(layer, plan.name)
    local = in_frame(plan, edit.frame, units)
    positions = np.ascontiguousarray(units.points_to_stage(local.positions), dtype=np.float32)
    orientations = np.ascontiguousarray(units.rotations_to_stage(local.orientations), dtype=np.float16)
    for field, name, type_name, value, uniform in (
        ("sides", "protoIndices", ValueTypes.IntArray, Vt.IntArray.FromNumpy(plan.sides.astype(np.int32)), False),
        ("positions", "positions", ValueTypes.Point3fArray, Vt.Vec3fArray.FromNumpy(positions), False),
        ("orientations", "orientations", ValueTypes.QuathArray, Vt.QuathArray.FromNumpy(orientations), False),
        ("strike_times", Plan.STRIKE_TIMES, ValueTypes.TimeCodeArray, _codes(plan.strike_times, units), True),
        ("liftoff_times", Plan.LIFTOFF_TIMES, ValueTypes.TimeCodeArray, _codes(plan.liftoff_times, units), True),
        ("root_weights", Plan.ROOT_WEIGHTS, ValueTypes.FloatArray, _floats(plan.root_weights), True),
        ("styles", Plan.STYLES, ValueTypes.TokenArray, Vt.TokenArray(plan.styles), True),
    ):
        if np.array_equal(getattr(plan, field), getattr(before, field)):
            continue
        attribute = prim.layer.GetAttributeAtPath(prim.path.AppendProperty(name))
        if attribute:
            attribute.default = value
        else:
            author(prim, name, type_name, value=value, uniform=uniform)


def _codes(times: FloatArray, units: StageUnits) -> Sdf.TimeCodeArray:
    return Sdf.TimeCodeArray([Sdf.TimeCode(code) for code in rounded_codes(units.times_to_codes(times)).tolist()])


def _floats(values: FloatArray) -> Vt.FloatArray:
    return Vt.FloatArray.FromNumpy(np.ascontiguousarray(values, dtype=np.float32))
