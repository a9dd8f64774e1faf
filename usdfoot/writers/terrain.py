"""Terrain as a layer to put under a scene: meshes that feet stand on."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Vt

from usdfoot.bridge import tokens
from usdfoot.bridge.names import unique_name, valid_name
from usdfoot.bridge.units import StageUnits
from usdfoot.maths.types import FloatArray
from usdfoot.model.terrain import Terrain
from usdfoot.writers.layers import LayerFormat, apply_schemas, author, define_prim, new_layer
from usdfoot.writers.paths import layer_path
from usdfoot.writers.staging import staged_files

__all__ = ["TERRAIN_PRIM", "write_terrain"]

ValueTypes = Sdf.ValueTypeNames

TERRAIN_PRIM = "/Terrain"
"""The default prim, above all meshes."""
COLOR = (0.55, 0.55, 0.5)


def write_terrain(
    file: str | os.PathLike[str],
    terrains: Mapping[str, Terrain],
    *,
    units: StageUnits,
    sources: tuple[str, ...] = (),
    provenance: Mapping[str, Any] | None = None,
) -> Path:
    """Write /Terrain/<name>, a Mesh of triangles, for every terrain.

    Args:
        file: .usd, .usda or .usdc to write, replaced if it exists; text only if it is named .usda.
        terrains: At least one, by name.
        units: Of the stage the layer is for.
        sources: Files that must not be replaced.
        provenance: For `customLayerData["usdfoot"]`.

    Raises:
        OutputError: If the file's name is no USD layer's, would replace a source, or cannot be written.
    """
    target = layer_path(file, sources=sources)
    rate = units.time_codes_per_second
    layer_format = LayerFormat(units=units, frames_per_second=rate, start_code=0.0, end_code=0.0)
    layer = new_layer(layer_format, text=target.suffix == ".usda")
    layer.defaultPrim = Sdf.Path(TERRAIN_PRIM).name
    layer.customLayerData = {tokens.PROVENANCE: dict(provenance or {})}
    names: set[str] = set()
    with Sdf.ChangeBlock():
        root = define_prim(layer, TERRAIN_PRIM, "Xform")
        apply_schemas(root, [tokens.Schema.TERRAIN])
        author(root, tokens.Terrain.WALKABLE, ValueTypes.Bool, value=True, uniform=True)
        for name, terrain in terrains.items():
            _write_mesh(layer, f"{TERRAIN_PRIM}/{unique_name(valid_name(name), names)}", terrain, units)
    with staged_files(target.parent) as files:
        files.add_layer(target.name, layer)
    return target


def _write_mesh(layer: Sdf.Layer, path: str, terrain: Terrain, units: StageUnits) -> None:
    prim = define_prim(layer, path, "Mesh")
    points = units.points_to_stage(terrain.points)
    counts = np.full(len(terrain.triangles), 3, dtype=np.int32)
    corners = np.ascontiguousarray(terrain.triangles.ravel(), dtype=np.int32)
    author(prim, "points", ValueTypes.Point3fArray, value=_points(points))
    author(prim, "faceVertexCounts", ValueTypes.IntArray, value=Vt.IntArray.FromNumpy(counts))
    author(prim, "faceVertexIndices", ValueTypes.IntArray, value=Vt.IntArray.FromNumpy(corners))
    author(prim, "extent", ValueTypes.Float3Array, value=_points(np.stack([points.min(axis=0), points.max(axis=0)])))
    author(prim, "subdivisionScheme", ValueTypes.Token, value="none", uniform=True)
    display = author(prim, "primvars:displayColor", ValueTypes.Color3fArray, value=Vt.Vec3fArray([Gf.Vec3f(*COLOR)]))
    display.SetInfo("interpolation", "constant")


def _points(points: FloatArray) -> Any:
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points, dtype=np.float32))
