"""Overlays as layers: /__usdfoot, guides that any viewer shows and nothing else depends on."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Vt

from usdfoot.bridge.tokens import PROVENANCE
from usdfoot.bridge.tokens import Overlay as Token
from usdfoot.bridge.units import StageUnits
from usdfoot.maths import quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.overlay import Lines, Marks, Overlay, Shape
from usdfoot.writers.layers import (
    LayerFormat,
    author,
    author_samples,
    author_targets,
    define_prim,
    new_layer,
    rounded_codes,
)
from usdfoot.writers.paths import layer_path
from usdfoot.writers.staging import staged_files

__all__ = ["overlay_layer", "write_overlay"]

ValueTypes = Sdf.ValueTypeNames


def write_overlay(file: str | os.PathLike[str], layer: Sdf.Layer, *, sources: tuple[str, ...] = ()) -> Path:
    """Save an overlay's layer.

    Args:
        file: .usd, .usda or .usdc to write, replaced if it exists.
        layer: From `overlay_layer`.
        sources: Layers of the crowd, which must not be replaced.

    Raises:
        OutputError: If the file's name is no USD layer's, would replace the crowd, or cannot be written.
    """
    target = layer_path(file, sources=sources)
    with staged_files(target.parent) as files:
        files.add_layer(target.name, layer)
    return target


def overlay_layer(
    overlay: Overlay, layer_format: LayerFormat, *, text: bool = True, provenance: Mapping[str, Any] | None = None
) -> Sdf.Layer:
    """A layer in memory with /__usdfoot/<kind> for every kind that the overlay shows.

    Args:
        overlay: What to draw.
        layer_format: Stage metadata, those of the crowd.
        text: usda instead of usdc.
        provenance: For `customLayerData["usdfoot"]`.
    """
    layer = new_layer(layer_format, text=text)
    layer.defaultPrim = Sdf.Path(Token.ROOT).name
    layer.customLayerData = {PROVENANCE: dict(provenance or {})}
    units = layer_format.units
    with Sdf.ChangeBlock():
        root = define_prim(layer, Token.ROOT, "Scope")
        author(root, "purpose", ValueTypes.Token, value="guide", uniform=True)
        for name, value in sorted(overlay.notes.items()):
            author(root, f"{Token.NOTES}:{name}", ValueTypes.Double, value=float(value), uniform=True)
        for marks in overlay.marks:
            _write_agents(_write_marks(layer, marks, units), overlay, marks.agents)
        for lines in overlay.lines:
            _write_agents(_write_lines(layer, lines, units), overlay, lines.agents)
    return layer


def _write_agents(prim: Sdf.PrimSpec, overlay: Overlay, owners: IntArray) -> None:
    """Whose each instance or line is."""
    author(prim, Token.AGENTS, ValueTypes.TokenArray, value=Vt.TokenArray(overlay.agents), uniform=True)
    author(prim, Token.OWNERS, ValueTypes.IntArray, value=_ints(owners), uniform=True)


def _write_marks(layer: Sdf.Layer, marks: Marks, units: StageUnits) -> Sdf.PrimSpec:
    """A PointInstancer with its shapes below it."""
    path = f"{Token.ROOT}/{marks.path}"
    prim = define_prim(layer, path, "PointInstancer")
    author(prim, "purpose", ValueTypes.Token, value="guide", uniform=True)
    author_targets(prim, "prototypes", [_write_shape(layer, path, shape, units) for shape in marks.shapes])
    codes = rounded_codes(units.times_to_codes(marks.times))
    scales = np.abs(units.directions_to_stage(marks.scales))
    orientations = units.rotations_to_stage(marks.orientations)
    positions = units.points_to_stage(marks.positions)
    kinds = np.ascontiguousarray(marks.kinds, dtype=np.int32)
    _sampled(prim, "protoIndices", ValueTypes.IntArray, codes, kinds, Vt.IntArray.FromNumpy)
    for name, type_name, values, kind, convert in (
        ("positions", ValueTypes.Point3fArray, positions, np.float32, Vt.Vec3fArray.FromNumpy),
        ("orientations", ValueTypes.QuathArray, orientations, np.float16, Vt.QuathArray.FromNumpy),
        ("scales", ValueTypes.Float3Array, scales, np.float32, Vt.Vec3fArray.FromNumpy),
    ):
        _sampled(prim, name, type_name, codes, np.ascontiguousarray(values, dtype=kind), convert)
    if marks.hidden.any():
        _hide(prim, codes, marks.hidden)
    author(prim, Token.FOOTSTEPS, ValueTypes.IntArray, value=_ints(marks.footsteps), uniform=True)
    author(prim, "extent", ValueTypes.Float3Array, value=_box(units.points_to_stage(_bounds(marks))))
    return prim


def _write_shape(layer: Sdf.Layer, above: str, shape: Shape, units: StageUnits) -> str:
    """A mesh below its instancer; gives back its path."""
    path = f"{above}/Shapes/{shape.name}"
    prim = define_prim(layer, path, "Mesh")
    points = units.points_to_stage(shape.points)
    author(prim, "points", ValueTypes.Point3fArray, value=_points(points))
    for name, numbers in (("faceVertexCounts", shape.counts), ("faceVertexIndices", shape.indices)):
        author(prim, name, ValueTypes.IntArray, value=_ints(numbers))
    author(prim, "extent", ValueTypes.Float3Array, value=_box(points))
    author(prim, "subdivisionScheme", ValueTypes.Token, value="none", uniform=True)
    author(prim, "doubleSided", ValueTypes.Bool, value=True, uniform=True)
    color = author(
        prim, "primvars:displayColor", ValueTypes.Color3fArray, value=Vt.Vec3fArray([Gf.Vec3f(*shape.color)])
    )
    color.SetInfo("interpolation", "constant")
    return path


def _write_lines(layer: Sdf.Layer, lines: Lines, units: StageUnits) -> Sdf.PrimSpec:
    """Linear BasisCurves."""
    prim = define_prim(layer, f"{Token.ROOT}/{lines.path}", "BasisCurves")
    author(prim, "purpose", ValueTypes.Token, value="guide", uniform=True)
    author(prim, "type", ValueTypes.Token, value="linear", uniform=True)
    author(prim, "curveVertexCounts", ValueTypes.IntArray, value=_ints(lines.counts))
    points = units.points_to_stage(lines.points)
    width = lines.width / units.meters_per_unit
    author(prim, "points", ValueTypes.Point3fArray, value=_points(points))
    author(prim, "widths", ValueTypes.FloatArray, value=Vt.FloatArray([width])).SetInfo("interpolation", "constant")
    color = author(prim, "primvars:displayColor", ValueTypes.Color3fArray, value=_points(lines.colors))
    color.SetInfo("interpolation", "vertex")
    bounds = np.stack([points.min(axis=0) - 0.5 * width, points.max(axis=0) + 0.5 * width])
    author(prim, "extent", ValueTypes.Float3Array, value=_box(bounds))
    return prim


def _sampled(
    prim: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName, codes: FloatArray, values: Any, convert: Any
) -> None:
    """An attribute with values (T, N, ...) at time codes (T,); without samples where nothing changes."""
    attribute = author(prim, name, type_name)
    changed = (values[1:] != values[:-1]).any(axis=tuple(range(1, values.ndim)))
    if not changed.any():
        attribute.default = convert(values[0])
        return
    kept = np.flatnonzero(np.append(changed, True) | np.insert(changed, 0, True))  # both sides of every change
    author_samples(attribute, codes[kept].tolist(), [convert(np.ascontiguousarray(values[row])) for row in kept])


def _hide(prim: Sdf.PrimSpec, codes: FloatArray, hidden: BoolArray) -> None:
    """Authors invisibleIds of hidden instances (T, N), sampled where they change."""
    attribute = author(prim, "invisibleIds", ValueTypes.Int64Array)
    kept = np.flatnonzero(np.insert((hidden[1:] != hidden[:-1]).any(axis=1), 0, True))
    values = [Vt.Int64Array.FromNumpy(np.flatnonzero(hidden[row]).astype(np.int64)) for row in kept]
    author_samples(attribute, codes[kept].tolist(), values)


def _bounds(marks: Marks) -> FloatArray:
    """Lowest and highest corner of all instances at all times [m], hidden ones too, shape (2, 3)."""
    boxes = np.array([[shape.points.min(axis=0), shape.points.max(axis=0)] for shape in marks.shapes])
    found = []
    for choice in np.ndindex(2, 2, 2):
        corners = boxes[:, choice, np.arange(3)][marks.kinds] * marks.scales  # (T, N, 3)
        places = quaternion.rotate(marks.orientations, corners) + marks.positions
        found += [places.min(axis=(0, 1)), places.max(axis=(0, 1))]
    return np.stack([np.min(found, axis=0), np.max(found, axis=0)])


def _ints(numbers: IntArray) -> Any:
    return Vt.IntArray.FromNumpy(np.ascontiguousarray(numbers, dtype=np.int32))


def _points(points: FloatArray) -> Any:
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points, dtype=np.float32))


def _box(points: FloatArray) -> Any:
    return _points(np.stack([points.min(axis=0), points.max(axis=0)]))
