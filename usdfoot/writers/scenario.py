"""A scenario as a stage: agents with goals, obstacles and ground, to be planned and edited."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from usdfoot.bridge import tokens
from usdfoot.bridge.names import valid_name
from usdfoot.bridge.units import StageUnits
from usdfoot.maths.types import FloatArray
from usdfoot.planning.scenario import Scenario, Seeker
from usdfoot.planning.world import box_outline
from usdfoot.writers.layers import LayerFormat, apply_schemas, author, author_targets, define_prim, new_layer
from usdfoot.writers.paths import layer_path
from usdfoot.writers.staging import staged_files

__all__ = ["write_scenario"]

ValueTypes = Sdf.ValueTypeNames

WORLD = "/World"
UNITS = StageUnits(meters_per_unit=1.0, up_axis="Y", time_codes_per_second=30.0)
HEIGHT = 1.0
"""Of the obstacles [m]; only their outline counts."""
GROUND_COLOR, OBSTACLE_COLOR = (0.55, 0.55, 0.5), (0.62, 0.36, 0.3)


def write_scenario(
    file: str | os.PathLike[str],
    scenario: Scenario,
    *,
    character: str = "",
    clips: str = "",
    provenance: Mapping[str, Any] | None = None,
) -> Path:
    """Write a scenario as a USD stage in metres, +Y up: agents below /World/Agents, goals, obstacles and ground.

    Args:
        file: .usd, .usda or .usdc to write, replaced if it exists.
        scenario: What to write.
        character: USD file whose default prim all agents reference as their character; empty = none.
        clips: USD file with their clips; empty = none.
        provenance: For `customLayerData["usdfoot"]`.

    Raises:
        OutputError: If the file's name is no USD layer's or it cannot be written.
    """
    target = layer_path(file)
    layer = new_layer(LayerFormat(units=UNITS, frames_per_second=30.0, start_code=0.0, end_code=0.0), text=True)
    layer.defaultPrim = Sdf.Path(WORLD).name
    layer.customLayerData = {tokens.PROVENANCE: dict(provenance or {})}
    with Sdf.ChangeBlock():
        define_prim(layer, WORLD, "Xform")
        _write_ground(layer, scenario)
        for index, obstacle in enumerate(scenario.obstacles):
            _write_obstacle(
                layer, f"{WORLD}/Obstacles/{_name(obstacle.name, index)}", obstacle.outline, obstacle.margin
            )
        if character or clips:
            define_prim(layer, f"{WORLD}/Library", "Scope")
            author(layer.GetPrimAtPath(f"{WORLD}/Library"), "visibility", ValueTypes.Token, value="invisible")
        for index, seeker in enumerate(scenario.seekers):
            _write_seeker(layer, index, seeker, has_character=bool(character), has_clips=bool(clips))
    for kind, asset in (("Character", character), ("Motion", clips)):
        if asset:
            _write_asset(layer.GetPrimAtPath(f"{WORLD}/Library"), kind, asset, target.parent)
    with staged_files(target.parent) as files:
        files.add_layer(target.name, layer)
    return target


def _name(name: str, index: int) -> str:
    """A prim's name that is valid and unique."""
    return f"{valid_name(name.rpartition('/')[2])}_{index}"


def _write_ground(layer: Sdf.Layer, scenario: Scenario) -> None:
    outline = scenario.bounds
    if outline is None:
        places = np.array([place[[0, 2]] for one in scenario.seekers for place in (one.start, *one.goals)])
        outline = box_outline(places.min(axis=0) - 5.0, places.max(axis=0) + 5.0)
    prim = _write_mesh(layer, f"{WORLD}/Ground", outline, [0.0], GROUND_COLOR)
    apply_schemas(prim, [tokens.Schema.TERRAIN])
    author(prim, tokens.Terrain.WALKABLE, ValueTypes.Bool, value=True, uniform=True)


def _write_obstacle(layer: Sdf.Layer, path: str, outline: FloatArray, margin: float) -> None:
    prim = _write_mesh(layer, path, outline, [0.0, HEIGHT], OBSTACLE_COLOR)
    apply_schemas(prim, [tokens.Schema.OBSTACLE])
    author(prim, tokens.Obstacle.MARGIN, ValueTypes.Float, value=float(margin), uniform=True)


def _write_mesh(
    layer: Sdf.Layer, path: str, outline: FloatArray, heights: list[float], color: tuple[float, float, float]
) -> Sdf.PrimSpec:
    """A polygon facing up, or a prism between two heights."""
    x, z = outline.T
    if np.sum(x * np.roll(z, -1) - np.roll(x, -1) * z) > 0.0:
        outline = outline[::-1]  # counter-clockwise seen from above, which is clockwise in (x, z)
    count = len(outline)
    points = np.concatenate([np.insert(outline, 1, height, axis=1) for height in heights])
    faces = [list(range(count))]
    if len(heights) > 1:
        faces = [[*range(2 * count - 1, count - 1, -1)][::-1], [*range(count - 1, -1, -1)]]
        faces += [[i, (i + 1) % count, count + (i + 1) % count, count + i] for i in range(count)]
    prim = define_prim(layer, path, "Mesh")
    array = np.ascontiguousarray(points, dtype=np.float32)
    author(prim, "points", ValueTypes.Point3fArray, value=Vt.Vec3fArray.FromNumpy(array))
    author(prim, "faceVertexCounts", ValueTypes.IntArray, value=Vt.IntArray([len(face) for face in faces]))
    author(
        prim, "faceVertexIndices", ValueTypes.IntArray, value=Vt.IntArray([corner for face in faces for corner in face])
    )
    extent = np.stack([array.min(axis=0), array.max(axis=0)])
    author(prim, "extent", ValueTypes.Float3Array, value=Vt.Vec3fArray.FromNumpy(extent))
    author(prim, "subdivisionScheme", ValueTypes.Token, value="none", uniform=True)
    display = author(prim, "primvars:displayColor", ValueTypes.Color3fArray, value=Vt.Vec3fArray([Gf.Vec3f(*color)]))
    display.SetInfo("interpolation", "constant")
    return prim


def _write_asset(library: Sdf.PrimSpec, name: str, asset: str, folder: Path) -> None:
    """A reference to a file's default prim, of that prim's type, scaled and turned to metres, +Y up.

    What places the prim in its own file stays, below the scale.
    """
    prim = Sdf.PrimSpec(library, name, Sdf.SpecifierDef)
    relative = os.path.relpath(os.path.realpath(asset), folder).replace(os.sep, "/")
    prim.referenceList.prependedItems = [Sdf.Reference(f"./{relative}")]
    stage = Usd.Stage.Open(os.fspath(asset))
    scale = UsdGeom.GetStageMetersPerUnit(stage) / UNITS.meters_per_unit
    operations = []
    if not np.isclose(scale, 1.0):
        operations.append("xformOp:scale:toMetres")
        author(prim, operations[-1], ValueTypes.Double3, value=Gf.Vec3d(scale))
    if UsdGeom.GetStageUpAxis(stage) != UNITS.up_axis:
        operations.append("xformOp:rotateX:toYUp")
        author(prim, operations[-1], ValueTypes.Double, value=-90.0)
    if operations:
        own = UsdGeom.Xformable(stage.GetDefaultPrim())
        if not own:
            prim.typeName = "Xform"  # a Scope cannot be scaled
        operations += (own.GetXformOpOrderAttr().Get() or ()) if own else ()
        order = [operation for operation in operations if operation != "!resetXformStack!"]
        author(prim, "xformOpOrder", ValueTypes.TokenArray, value=Vt.TokenArray(order), uniform=True)


def _write_seeker(layer: Sdf.Layer, index: int, seeker: Seeker, *, has_character: bool, has_clips: bool) -> None:
    """The agent, and an Xform for each of its goals."""
    name = _name(seeker.name, index)
    goals = [f"{WORLD}/Goals/{name}_{number}" for number in range(len(seeker.goals))]
    for path, goal in zip(goals, seeker.goals, strict=True):
        _place(define_prim(layer, path, "Xform"), goal, None)
    prim = define_prim(layer, f"{WORLD}/Agents/{name}", "Xform")
    apply_schemas(prim, [tokens.Schema.AGENT])
    _place(prim, seeker.start, seeker.yaw)
    author(prim, tokens.Agent.SPEED, ValueTypes.Float, value=float(seeker.speed), uniform=True)
    author_targets(prim, tokens.Agent.GOAL, goals)
    if has_character:
        author_targets(prim, tokens.Agent.CHARACTER, [f"{WORLD}/Library/Character"])
    if has_clips:
        author_targets(prim, tokens.Agent.CLIPS, [f"{WORLD}/Library/Motion"])


def _place(prim: Sdf.PrimSpec, point: FloatArray, yaw: float | None) -> None:
    """A translation and, with a yaw [rad], a rotation about +Y."""
    operations = ["xformOp:translate"]
    author(prim, "xformOp:translate", ValueTypes.Double3, value=Gf.Vec3d(*(float(value) for value in point)))
    if yaw is not None:
        operations.append("xformOp:rotateY")
        author(prim, "xformOp:rotateY", ValueTypes.Double, value=float(np.degrees(yaw)))
    author(prim, "xformOpOrder", ValueTypes.TokenArray, value=Vt.TokenArray(operations), uniform=True)
