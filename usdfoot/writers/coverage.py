"""Coverage as a stage: of every style, gait and foot the triangulated landings, coloured by the error to expect."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Vt

from usdfoot.bridge import tokens
from usdfoot.bridge.names import unique_name, valid_name
from usdfoot.bridge.units import StageUnits
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import SIDES
from usdfoot.model.coverage import SpaceCoverage
from usdfoot.writers.layers import LayerFormat, author, define_prim, new_layer
from usdfoot.writers.paths import layer_path
from usdfoot.writers.staging import staged_files

__all__ = ["write_coverage"]

ValueTypes = Sdf.ValueTypeNames
ROOT = "/Coverage"
COLOURS = np.array(
    [
        (68, 1, 84), (72, 40, 120), (62, 73, 137), (49, 104, 142), (38, 130, 142),
        (31, 158, 137), (53, 183, 121), (110, 206, 88), (181, 222, 43), (253, 231, 37),
    ]
)  # fmt: skip
"""Even steps from dark to light (viridis), sRGB of 0..255."""
UNKNOWN = np.array([0.2, 0.2, 0.2])
"""Where no error can be told, linear RGB."""
GAP = 0.5
"""Between the landings of one gait and the next [m]."""


def write_coverage(
    output: str | os.PathLike[str],
    spaces: Sequence[SpaceCoverage],
    *,
    units: StageUnits,
    sources: Sequence[str],
    provenance: Mapping[str, Any],
) -> Path:
    """Write /Coverage/<skeleton>_<style>_<gait>/<Foot>: the landings, the hull and the empty circles.

    The support ball is the origin of each gait's prim, +Z (on a Z-up stage -Y) ahead. Gaits stand side by side. Errors
    are `primvars:usdfoot:expectedError` in stage units, -1 where none can be told; the lightest colour is the largest
    error of all.

    Args:
        output: .usd, .usda or .usdc to write, replaced if it exists.
        spaces: At least one.
        units: Of the stage.
        sources: Files that must not be replaced.
        provenance: For `customLayerData["usdfoot"]`.

    Raises:
        OutputError: If the file's name is no USD layer's, would replace a source, or cannot be written.
    """
    target = layer_path(output, sources=sources)
    layer_format = LayerFormat(units=units, frames_per_second=units.time_codes_per_second, start_code=0.0, end_code=0.0)
    layer = new_layer(layer_format, text=target.suffix == ".usda")
    layer.defaultPrim = Sdf.Path(ROOT).name
    layer.customLayerData = {tokens.PROVENANCE: dict(provenance)}
    largest = max((float(np.nanmax(space.errors)) for space in spaces if np.isfinite(space.errors).any()), default=1.0)
    groups: dict[tuple[str, str, bool], list[SpaceCoverage]] = {}
    for space in spaces:
        groups.setdefault((space.skeleton, space.style, space.flight), []).append(space)
    names, edge = set[str](), 0.0
    with Sdf.ChangeBlock():
        define_prim(layer, ROOT, "Xform")
        for (skeleton, style, flight), members in groups.items():
            gait = "flight" if flight else "ground"
            name = unique_name(valid_name(f"{_short(skeleton)}_{style}_{gait}"), names)
            across = np.concatenate([space.landings[:, 0] for space in members])
            edge -= float(across.max())
            _write_group(layer, f"{ROOT}/{name}", members, edge, largest, units)
            edge += float(across.min()) - GAP
    with staged_files(target.parent) as files:
        files.add_layer(target.name, layer)
    return target


def _short(path: str) -> str:
    """The first part of a prim path."""
    return path.strip("/").split("/")[0]


def _write_group(
    layer: Sdf.Layer, path: str, spaces: Sequence[SpaceCoverage], shift: float, largest: float, units: StageUnits
) -> None:
    """Both feet of one gait, moved to the side by `shift` [m]."""
    prim = define_prim(layer, path, "Xform")
    place = units.points_to_stage(np.array([shift, 0.0, 0.0]))
    author(prim, "xformOp:translate", ValueTypes.Double3, value=Gf.Vec3d(*place.tolist()))
    author(prim, "xformOpOrder", ValueTypes.TokenArray, value=Vt.TokenArray(["xformOp:translate"]), uniform=True)
    for space in spaces:
        _write_space(layer, f"{path}/{SIDES[space.side].capitalize()}", space, largest, units)


def _write_space(layer: Sdf.Layer, path: str, space: SpaceCoverage, largest: float, units: StageUnits) -> None:
    """One foot: landings as a Mesh, the hull and the circles where none lands as BasisCurves."""
    define_prim(layer, path, "Xform")
    points = _points(space.landings, units)
    prim = define_prim(layer, f"{path}/Landings", "Mesh" if len(space.triangles) else "Points")
    author(prim, "points", ValueTypes.Point3fArray, value=points)
    author(prim, "extent", ValueTypes.Float3Array, value=_extent(space.landings, units))
    if len(space.triangles):
        # Seen from above: counter-clockwise in (x, z) is clockwise about +Y.
        faces = space.triangles[:, ::-1] if space.side == 0 else space.triangles
        author(prim, "faceVertexCounts", ValueTypes.IntArray, value=Vt.IntArray([3] * len(faces)))
        author(prim, "faceVertexIndices", ValueTypes.IntArray, value=_ints(faces))
        author(prim, "subdivisionScheme", ValueTypes.Token, value="none", uniform=True)
        author(prim, "doubleSided", ValueTypes.Bool, value=True, uniform=True)
    else:
        author(prim, "widths", ValueTypes.FloatArray, value=Vt.FloatArray([0.02 / units.meters_per_unit] * len(points)))
    errors = np.where(np.isfinite(space.errors), space.errors / units.meters_per_unit, -1.0)
    colours = Vt.Vec3fArray.FromNumpy(error_colours(space.errors, largest).astype(np.float32))
    values = Vt.FloatArray.FromNumpy(errors.astype(np.float32))
    for name, kind, value in (
        ("primvars:displayColor", ValueTypes.Color3fArray, colours),
        ("primvars:usdfoot:expectedError", ValueTypes.FloatArray, values),
    ):
        author(prim, name, kind, value=value).SetInfo("interpolation", "vertex")
    _write_lines(layer, f"{path}/Hull", space.landings[space.hull], np.array([0.05, 0.05, 0.05]), units)
    angles = np.linspace(0.0, 2.0 * np.pi, 33)
    circle = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    rings = [empty.place + empty.radius * circle for empty in space.empty_circles]
    if rings:
        _write_lines(layer, f"{path}/EmptyCircles", np.array(rings), np.array([0.6, 0.02, 0.02]), units)


def _write_lines(layer: Sdf.Layer, path: str, lines: FloatArray, colour: FloatArray, units: StageUnits) -> None:
    """Linear BasisCurves (L, P, 2) of one colour, linear RGB."""
    prim = define_prim(layer, path, "BasisCurves")
    author(prim, "type", ValueTypes.Token, value="linear", uniform=True)
    author(prim, "curveVertexCounts", ValueTypes.IntArray, value=Vt.IntArray([lines.shape[1]] * len(lines)))
    author(prim, "points", ValueTypes.Point3fArray, value=_points(lines.reshape(-1, 2), units))
    author(prim, "extent", ValueTypes.Float3Array, value=_extent(lines.reshape(-1, 2), units))
    width = author(prim, "widths", ValueTypes.FloatArray, value=Vt.FloatArray([0.005 / units.meters_per_unit]))
    width.SetInfo("interpolation", "constant")
    shown = author(
        prim, "primvars:displayColor", ValueTypes.Color3fArray, value=Vt.Vec3fArray([Gf.Vec3f(*colour.tolist())])
    )
    shown.SetInfo("interpolation", "constant")


def error_colours(errors: FloatArray, largest: float) -> FloatArray:
    """Linear RGB of errors (V,), the lightest for the largest one, shape (V, 3)."""
    place = np.clip(np.nan_to_num(errors) / max(largest, 1e-9), 0.0, 1.0) * (len(COLOURS) - 1)
    shown = np.stack([np.interp(place, np.arange(len(COLOURS)), column) for column in COLOURS.T / 255.0], axis=1)
    linear = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    return np.where(np.isfinite(errors)[:, None], linear, UNKNOWN)


def _level(places: FloatArray) -> FloatArray:
    """Places (N, 2) on the ground as points (N, 3)."""
    return np.insert(np.asarray(places, dtype=float), 1, 0.0, axis=1)


def _points(places: FloatArray, units: StageUnits) -> Vt.Vec3fArray:
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(units.points_to_stage(_level(places)), dtype=np.float32))


def _extent(places: FloatArray, units: StageUnits) -> Vt.Vec3fArray:
    points = units.points_to_stage(_level(places))
    corners = np.stack([points.min(axis=0), points.max(axis=0)])
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(corners, dtype=np.float32))


def _ints(values: IntArray) -> Vt.IntArray:
    return Vt.IntArray.FromNumpy(np.ascontiguousarray(values.reshape(-1), dtype=np.int32))
