"""Edits of executed plans in the artists' layer, where the next run of animate finds them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pxr import Sdf, Tf, Vt

from usdfoot.bridge.reasons import usd_reason
from usdfoot.bridge.tokens import Plan
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import OutputError
from usdfoot.maths.types import FloatArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.writers.footsteps import in_frame
from usdfoot.writers.layers import author, rounded_codes

__all__ = ["restore_layer", "save_plan_edit"]

ValueTypes = Sdf.ValueTypeNames


def save_plan_edit(
    file: Path, plan: FootstepPlan, *, before: FootstepPlan, units: StageUnits, frame: FloatArray
) -> Sdf.Layer:
    """Author over a plan what an edit changed of it, and save the layer; gives back what it held before, in memory.

    Args:
        file: overrides.usda of the crowd.
        plan: As edited, named by its prim.
        before: As it was.
        units: Of the crowd.
        frame: From the plan's prim to the world (row vectors, stage units), shape (4, 4).

    Raises:
        OutputError: If the layer cannot be changed or saved.
    """
    layer = Sdf.Layer.FindOrOpen(str(file))
    if layer is None:
        raise OutputError(file, "cannot be opened", "make the crowd again: usdfoot animate writes it")
    kept = Sdf.Layer.CreateAnonymous(".usda")
    kept.TransferContent(layer)
    with Sdf.ChangeBlock():
        _author(Sdf.CreatePrimInLayer(layer, plan.name), plan, before, units, frame)
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


def _author(prim: Sdf.PrimSpec, plan: FootstepPlan, before: FootstepPlan, units: StageUnits, frame: FloatArray) -> None:
    local = in_frame(plan, frame, units)
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
            author(prim, name, type_name, value, uniform=uniform)


def _codes(times: FloatArray, units: StageUnits) -> Sdf.TimeCodeArray:
    return Sdf.TimeCodeArray([Sdf.TimeCode(code) for code in rounded_codes(units.times_to_codes(times)).tolist()])


def _floats(values: FloatArray) -> Vt.FloatArray:
    return Vt.FloatArray.FromNumpy(np.ascontiguousarray(values, dtype=np.float32))
