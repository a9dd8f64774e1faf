"""Footstep plans as PointInstancers: as planned, and as executed with what became of each footstep (design.md 2, 3)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Vt

from usdfoot.bridge import tokens
from usdfoot.bridge.units import StageUnits
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.motion import StepResults
from usdfoot.model.plan import FootstepPlan
from usdfoot.writers.layers import apply_schemas, author, author_targets, define_prim
from usdfoot.writers.layers_over import author_times
from usdfoot.writers.prints import PRINT_COLORS, print_extent, print_outline

__all__ = ["PrintModels", "author_plan", "in_frame", "print_models", "write_executed_plan"]

ValueTypes = Sdf.ValueTypeNames
PRINTS, PRINT_NAMES = "/Prints", ("Left", "Right")
"""Where the prints' meshes are below their plan."""
INTERPOLATIONS = {"normals": "uniform", "primvars:displayColor": "constant"}


@dataclass(frozen=True, kw_only=True)
class PrintModels:
    """Small meshes of a left and a right footprint, which all plans of one size share."""

    outlines: tuple[FloatArray, FloatArray]
    """Corners in the print's frame [m], shape (13, 3) each."""
    layer: Sdf.Layer
    """Holds the meshes below PRINTS."""


def print_models(size: float, units: StageUnits) -> PrintModels:
    """Meshes of prints for feet with the ball `size` from the ankle [m]."""
    outlines = print_outline(0, size), print_outline(1, size)
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    with Sdf.ChangeBlock():
        define_prim(layer, PRINTS, "Scope")
        for name, outline, color in zip(PRINT_NAMES, outlines, PRINT_COLORS, strict=True):
            mesh = define_prim(layer, f"{PRINTS}/{name}", "Mesh")
            for attribute, (type_name, value) in _mesh_attributes(outline, color, units).items():
                spec = author(mesh, attribute, type_name, value, uniform=attribute == "subdivisionScheme")
                if attribute in INTERPOLATIONS:
                    spec.SetInfo("interpolation", INTERPOLATIONS[attribute])
    return PrintModels(outlines=outlines, layer=layer)


def _mesh_attributes(
    outline: FloatArray, color: tuple[float, float, float], units: StageUnits
) -> dict[str, tuple[Sdf.ValueTypeName, Any]]:
    points, count = units.points_to_stage(outline), len(outline)
    return {
        "points": (ValueTypes.Point3fArray, _points(points)),
        "faceVertexCounts": (ValueTypes.IntArray, Vt.IntArray([count])),
        "faceVertexIndices": (ValueTypes.IntArray, Vt.IntArray(range(count))),
        "extent": (ValueTypes.Float3Array, _box(points)),
        "subdivisionScheme": (ValueTypes.Token, "none"),
        "normals": (ValueTypes.Normal3fArray, _points(units.directions_to_stage(np.array([[0.0, 1.0, 0.0]])))),
        "primvars:displayColor": (ValueTypes.Color3fArray, Vt.Vec3fArray([Gf.Vec3f(*color)])),
    }


def write_executed_plan(
    layer: Sdf.Layer,
    name: str,
    plan: FootstepPlan,
    *,
    results: StepResults,
    prints: PrintModels,
    units: StageUnits,
    frame: FloatArray | None = None,
) -> None:
    """Author /Crowd/Plans/<name> into a layer.

    Args:
        layer: Layer to author in.
        name: The agent's name.
        plan: Its plan, kept as given.
        results: What became of each footstep.
        prints: What its footsteps look like.
        units: Of the written stage.
        frame: From the prim to the world, as a stronger layer will have it (row vectors, stage units), shape (4, 4);
            None = nothing moves the prim.
    """
    plan = plan if frame is None else in_frame(plan, frame, units)
    prim = author_plan(layer, f"{tokens.Prim.PLANS}/{name}", plan, prints=prints, units=units)
    apply_schemas(prim, [tokens.Schema.PLAN, tokens.Schema.RESULT])
    author(prim, "purpose", ValueTypes.Token, "guide", uniform=True)
    author(prim, tokens.Plan.ROOT_WEIGHTS, ValueTypes.FloatArray, _floats(plan.root_weights), uniform=True)
    if plan.styles:
        author(prim, tokens.Plan.STYLES, ValueTypes.TokenArray, Vt.TokenArray(plan.styles), uniform=True)
    _write_results(prim, results, units)


def in_frame(plan: FootstepPlan, frame: FloatArray, units: StageUnits) -> FootstepPlan:
    """The plan in the space of a prim that a transform moves, so that the transform puts it where it is."""
    to_local = np.linalg.inv(frame)
    positions = units.points_to_stage(plan.positions) @ to_local[:3, :3] + to_local[3, :3]
    rotation = to_local[:3, :3].T / np.cbrt(np.linalg.det(to_local[:3, :3]))
    turn = units.rotations_to_canonical(quaternion.from_matrix(rotation))
    return replace(
        plan,
        positions=units.points_to_canonical(positions),
        orientations=quaternion.compose(turn, plan.orientations),
    )


def author_plan(
    layer: Sdf.Layer, path: str, plan: FootstepPlan, *, prints: PrintModels, units: StageUnits
) -> Sdf.PrimSpec:
    """Author a plan with its prints at `path` of a layer; gives back its prim.

    Args:
        layer: Layer to author in.
        path: Of the prim.
        plan: In the canonical world.
        prints: What its footsteps look like.
        units: Of the written stage.
    """
    prim = define_prim(layer, path, "PointInstancer")
    apply_schemas(prim, [tokens.Schema.PLAN])
    author(prim, "protoIndices", ValueTypes.IntArray, Vt.IntArray.FromNumpy(plan.sides.astype(np.int32)))
    author(prim, "positions", ValueTypes.Point3fArray, _points(units.points_to_stage(plan.positions)))
    orientations = np.ascontiguousarray(units.rotations_to_stage(plan.orientations), dtype=np.float16)
    author(prim, "orientations", ValueTypes.QuathArray, Vt.QuathArray.FromNumpy(orientations))
    box = print_extent(plan.positions, plan.orientations, plan.sides, outlines=prints.outlines)
    author(prim, "extent", ValueTypes.Float3Array, _box(units.points_to_stage(box)))
    for attribute, times in (
        (tokens.Plan.STRIKE_TIMES, plan.strike_times),
        (tokens.Plan.LIFTOFF_TIMES, plan.liftoff_times),
    ):
        author_times(prim, attribute, times, units)
    Sdf.CopySpec(prints.layer, PRINTS, layer, path + PRINTS)
    author_targets(prim, "prototypes", [f"{path}{PRINTS}/{name}" for name in PRINT_NAMES])
    return prim


def _write_results(prim: Sdf.PrimSpec, results: StepResults, units: StageUnits) -> None:
    """UsdfootResultAPI; distances in stage units, angles in degrees."""
    names, per_unit = tokens.Result, units.meters_per_unit
    for name, values in (
        (names.BLEND_ERROR, results.blend_error / per_unit),
        (names.PLACEMENT_ERROR, results.placement_error / per_unit),
        (names.SLIDE, results.slide / per_unit),
        (names.YAW_ERROR, np.degrees(results.yaw_error)),
        (names.HULL_DISTANCE, results.hull_distance / per_unit),
        (names.TIME_WARP, results.time_warp),
        (names.ROOT_WEIGHT, results.root_weight),
        (names.BETA, results.beta),
        (names.ROOT_VELOCITY_ERROR, results.root_velocity_error / per_unit),
        (names.CLIP_WEIGHTS, results.clip_weights),
    ):
        author(prim, name, ValueTypes.FloatArray, _floats(values), uniform=True)
    if results.forces is not None:
        for name, values in (
            (names.FORCE_IMBALANCE, results.forces.force_imbalance),
            (names.CLAMP_TIME, results.forces.clamp_time),
            (names.JUMP_HEIGHT, results.forces.jump_height / per_unit),
        ):
            author(prim, name, ValueTypes.FloatArray, _floats(values), uniform=True)
    counts = Vt.IntArray.FromNumpy(np.asarray(results.clip_counts, dtype=np.int32))
    author(prim, names.STATUS, ValueTypes.TokenArray, Vt.TokenArray(results.status), uniform=True)
    author(prim, names.CLIP_COUNTS, ValueTypes.IntArray, counts, uniform=True)
    author(prim, names.CLIPS, ValueTypes.TokenArray, Vt.TokenArray(results.clips), uniform=True)


def _points(points: FloatArray) -> Any:
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points, dtype=np.float32))


def _floats(values: FloatArray) -> Any:
    return Vt.FloatArray.FromNumpy(np.ascontiguousarray(values, dtype=np.float32))


def _box(points: FloatArray) -> Any:
    return _points(np.stack([points.min(axis=0), points.max(axis=0)]))
