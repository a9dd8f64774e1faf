"""Layers and specs: the few Sdf calls that everything written goes through."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import Sdf, Vt

from usdfoot.bridge.tokens import Prim
from usdfoot.bridge.units import StageUnits
from usdfoot.maths.types import FloatArray

__all__ = [
    "MODEL_KINDS",
    "LayerFormat",
    "apply_schemas",
    "author",
    "author_format",
    "author_samples",
    "author_targets",
    "define_prim",
    "new_layer",
    "quaternion_array",
    "rounded_codes",
]


MODEL_KINDS = {Prim.CROWD: "assembly", Prim.AGENTS: "group"}
"""Kinds above the characters, which are often components: without them USD's model hierarchy would end here."""


@dataclass(frozen=True, kw_only=True)
class LayerFormat:
    """Stage metadata that every written layer carries, so that each also opens alone and none is retimed."""

    units: StageUnits
    """Units, up axis and rate, those of the scene."""
    frames_per_second: float
    """Playback rate of the scene."""
    start_code: float
    end_code: float
    """Time codes of the first and last frame."""


def new_layer(layer_format: LayerFormat, *, text: bool = False) -> Sdf.Layer:
    """A layer in memory with all stage metadata and the default prim's name.

    Args:
        layer_format: What the metadata say.
        text: usda instead of usdc.
    """
    layer = Sdf.Layer.CreateAnonymous(".usda" if text else ".usdc")
    author_format(layer, layer_format)
    return layer


def author_format(layer: Sdf.Layer, layer_format: LayerFormat) -> None:
    """Author all stage metadata and the default prim's name."""
    root = layer.pseudoRoot
    root.SetInfo("metersPerUnit", layer_format.units.meters_per_unit)
    root.SetInfo("upAxis", layer_format.units.up_axis)
    layer.timeCodesPerSecond = layer_format.units.time_codes_per_second
    layer.framesPerSecond = layer_format.frames_per_second
    layer.startTimeCode = layer_format.start_code
    layer.endTimeCode = layer_format.end_code
    layer.defaultPrim = Sdf.Path(Prim.CROWD).name


def define_prim(layer: Sdf.Layer, path: str, type_name: str) -> Sdf.PrimSpec:
    """The prim's spec, its ancestors defined too: /Crowd as an Xform, anything between as a Scope."""
    own = Sdf.Path(path)
    if not layer.GetPrimAtPath(own.GetParentPath()):
        for ancestor in own.GetPrefixes()[:-1]:
            if not layer.GetPrimAtPath(ancestor):
                _define(layer, ancestor, "Xform" if ancestor == Prim.CROWD else "Scope")
    return _define(layer, own, type_name)


def _define(layer: Sdf.Layer, path: Sdf.Path, type_name: str) -> Sdf.PrimSpec:
    spec = Sdf.CreatePrimInLayer(layer, path)
    spec.specifier = Sdf.SpecifierDef
    spec.typeName = type_name
    if str(path) in MODEL_KINDS:
        spec.kind = MODEL_KINDS[str(path)]
    return spec


def apply_schemas(prim: Sdf.PrimSpec, names: Sequence[str]) -> None:
    """Apply API schemas to a spec that has none."""
    schemas = Sdf.TokenListOp()
    schemas.prependedItems = list(names)
    prim.SetInfo("apiSchemas", schemas)


def author(
    prim: Sdf.PrimSpec, name: str, type_name: Sdf.ValueTypeName, *, value: Any = None, uniform: bool = False
) -> Sdf.AttributeSpec:
    """An attribute's spec, with a default value unless it is None."""
    variability = Sdf.VariabilityUniform if uniform else Sdf.VariabilityVarying
    attribute = Sdf.AttributeSpec(prim, name, type_name, variability)
    if value is not None:
        attribute.default = value
    return attribute


def author_samples(attribute: Sdf.AttributeSpec, codes: Sequence[float], values: Iterable[Any]) -> None:
    """Time samples of an attribute."""
    layer, path = attribute.layer, attribute.path
    set_sample = layer.SetTimeSample
    for code, value in zip(codes, values, strict=True):
        set_sample(path, code, value)


def author_targets(prim: Sdf.PrimSpec, name: str, targets: Sequence[str]) -> None:
    """A relationship with exactly these targets."""
    relationship = Sdf.RelationshipSpec(prim, name, custom=False)
    relationship.targetPathList.explicitItems = [Sdf.Path(target) for target in targets]


def quaternion_array(quaternions: FloatArray) -> Vt.QuatfArray:
    """`Vt.QuatfArray` of xyzw quaternions (N, 4)."""
    return Vt.QuatfArray.FromNumpy(np.ascontiguousarray(quaternions, dtype=np.float32))


def rounded_codes(codes: FloatArray) -> FloatArray:
    """Time codes without the last bits that seconds and back leave behind."""
    return np.asarray(codes, dtype=float).round(9) + 0.0
