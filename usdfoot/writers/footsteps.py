"""Footstep plans as PointInstancers: as planned, and as executed with what became of each footstep (design.md 2, 3)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from pxr import Sdf

from usdfoot.bridge import tokens
from usdfoot.bridge.placements import Placement
from usdfoot.bridge.units import StageUnits
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.displacement import Displacement
from usdfoot.model.motion import StepResults
from usdfoot.model.plan import FootstepPlan
from usdfoot.writers.attributes import (
    Attribute,
    author_attributes,
    code_array,
    prim_spec,
    relationship_spec,
    specs_of,
)
from usdfoot.writers.crate.specs import Spec
from usdfoot.writers.layers import apply_schemas, author_targets, define_prim
from usdfoot.writers.prints import PRINT_COLORS, print_extent, print_outline

__all__ = ["PrintModels", "author_plan", "executed_plan", "in_frame", "print_models"]

PRINTS, PRINT_NAMES = "/Prints", ("Left", "Right")
"""Where the prints' meshes are below their plan."""


@dataclass(frozen=True, kw_only=True)
class PrintModels:
    """Small meshes of a left and a right footprint, which all plans of one size share."""

    outlines: tuple[FloatArray, FloatArray]
    """Corners in the print's frame [m], shape (13, 3) each."""
    layer: Sdf.Layer
    """Holds the meshes below PRINTS."""
    spec: Spec
    """The same as a spec."""


def print_models(size: float, units: StageUnits) -> PrintModels:
    """Meshes of prints for feet with the ball `size` from the ankle [m]."""
    outlines = print_outline(0, size), print_outline(1, size)
    meshes = [_mesh(outline, color, units) for outline, color in zip(outlines, PRINT_COLORS, strict=True)]
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    with Sdf.ChangeBlock():
        define_prim(layer, PRINTS, "Scope")
        for name, mesh in zip(PRINT_NAMES, meshes, strict=True):
            author_attributes(define_prim(layer, f"{PRINTS}/{name}", "Mesh"), mesh)
    specs = {name: prim_spec("Mesh", specs_of(mesh)) for name, mesh in zip(PRINT_NAMES, meshes, strict=True)}
    return PrintModels(outlines=outlines, layer=layer, spec=prim_spec("Scope", specs))


def _mesh(outline: FloatArray, color: tuple[float, float, float], units: StageUnits) -> dict[str, Attribute]:
    points, count = units.points_to_stage(outline), len(outline)
    up = units.directions_to_stage(np.array([[0.0, 1.0, 0.0]]))
    return {
        "points": Attribute("point3f[]", points),
        "faceVertexCounts": Attribute("int[]", np.array([count])),
        "faceVertexIndices": Attribute("int[]", np.arange(count)),
        "extent": Attribute("float3[]", _box(points)),
        "subdivisionScheme": Attribute("token", "none", uniform=True),
        "normals": Attribute("normal3f[]", up, interpolation="uniform"),
        "primvars:displayColor": Attribute("color3f[]", np.array([color]), interpolation="constant"),
    }


def executed_plan(
    path: str,
    plan: FootstepPlan,
    *,
    results: StepResults,
    prints: PrintModels,
    units: StageUnits,
    placement: Placement | None = None,
) -> Spec:
    """Spec of a plan with what became of it.

    Args:
        path: Of the prim.
        plan: Kept as given.
        results: What became of each footstep.
        prints: What its footsteps look like.
        units: Of the written stage.
        placement: Where a stronger layer and its own transform will have the prim; None = nothing moves it.
    """
    placement = placement or Placement()
    plan = plan if placement.plan_frame is None else in_frame(plan, placement.plan_frame, units)
    attributes = {
        **_plan_attributes(plan, prints, units),
        "purpose": Attribute("token", "guide", uniform=True),
        tokens.Plan.ROOT_WEIGHTS: Attribute("float[]", plan.root_weights, uniform=True),
        **({tokens.Plan.STYLES: Attribute("token[]", plan.styles, uniform=True)} if plan.styles else {}),
        **_result_attributes(results, units),
        **_move_attributes(placement.plan_move, units),
    }
    prototypes = relationship_spec(_prototypes(path))
    below = {**specs_of(attributes), ".prototypes": prototypes, PRINTS.strip("/"): prints.spec}
    return prim_spec("PointInstancer", below, schemas=[tokens.Schema.PLAN, tokens.Schema.RESULT])


def _move_attributes(move: Displacement | None, units: StageUnits) -> dict[str, Attribute]:
    """The transform of a plan that goes with its agent."""
    if move is None:
        return {}
    translate, turn = f"{tokens.Op.TRANSLATE}:{tokens.Op.MOVED}", tokens.turn_op(units.up_axis, tokens.Op.MOVED)
    return {
        translate: Attribute("double3", units.points_to_stage(move.translation)),
        turn: Attribute("double", math.degrees(move.yaw)),
        "xformOpOrder": Attribute("token[]", [translate, turn], uniform=True),
    }


def _prototypes(path: str) -> list[str]:
    return [f"{path}{PRINTS}/{name}" for name in PRINT_NAMES]


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
    author_attributes(prim, _plan_attributes(plan, prints, units))
    Sdf.CopySpec(prints.layer, PRINTS, layer, path + PRINTS)
    author_targets(prim, "prototypes", _prototypes(path))
    return prim


def _plan_attributes(plan: FootstepPlan, prints: PrintModels, units: StageUnits) -> dict[str, Attribute]:
    """UsdfootPlanAPI, and what a PointInstancer has."""
    box = print_extent(plan.positions, plan.orientations, plan.sides, outlines=prints.outlines)
    return {
        "protoIndices": Attribute("int[]", plan.sides),
        "positions": Attribute("point3f[]", units.points_to_stage(plan.positions)),
        "orientations": Attribute("quath[]", units.rotations_to_stage(plan.orientations)),
        "extent": Attribute("float3[]", _box(units.points_to_stage(box))),
        tokens.Plan.STRIKE_TIMES: code_array(plan.strike_times, units),
        tokens.Plan.LIFTOFF_TIMES: code_array(plan.liftoff_times, units),
    }


def _result_attributes(results: StepResults, units: StageUnits) -> dict[str, Attribute]:
    """UsdfootResultAPI; distances in stage units, angles in degrees."""
    names, per_unit = tokens.Result, units.meters_per_unit
    floats = {
        names.BLEND_ERROR: results.blend_error / per_unit,
        names.PLACEMENT_ERROR: results.placement_error / per_unit,
        names.SLIDE: results.slide / per_unit,
        names.YAW_ERROR: np.degrees(results.yaw_error),
        names.HULL_DISTANCE: results.hull_distance / per_unit,
        names.TIME_WARP: results.time_warp,
        names.ROOT_WEIGHT: results.root_weight,
        names.BETA: results.beta,
        names.ROOT_VELOCITY_ERROR: results.root_velocity_error / per_unit,
        names.CLIP_WEIGHTS: results.clip_weights,
    }
    if results.forces is not None:
        floats |= {
            names.FORCE_IMBALANCE: results.forces.force_imbalance,
            names.CLAMP_TIME: results.forces.clamp_time,
            names.JUMP_HEIGHT: results.forces.jump_height / per_unit,
        }
    return {
        **{name: Attribute("float[]", values, uniform=True) for name, values in floats.items()},
        names.STATUS: Attribute("token[]", results.status, uniform=True),
        names.CLIP_COUNTS: Attribute("int[]", results.clip_counts, uniform=True),
        names.CLIPS: Attribute("token[]", results.clips, uniform=True),
    }


def _box(points: FloatArray) -> FloatArray:
    return np.stack([points.min(axis=0), points.max(axis=0)])
