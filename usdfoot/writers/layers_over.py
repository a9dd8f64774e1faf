"""Layers over a stage: they sublayer it and add opinions, so that they are read in its place."""

from __future__ import annotations

import os
from pathlib import Path

from pxr import Sdf

from usdfoot.bridge.scene import StageInfo
from usdfoot.bridge.units import StageUnits
from usdfoot.maths.types import FloatArray
from usdfoot.writers.layers import LayerFormat, author, new_layer, rounded_codes
from usdfoot.writers.paths import layer_path, relative_asset

__all__ = ["author_times", "layer_over"]


def layer_over(output: str | os.PathLike[str], info: StageInfo, *, default_prim: str) -> tuple[Path, Sdf.Layer]:
    """Real path of a file, and a layer for it in memory that has the metadata of a stage and sublayers it.

    Args:
        output: File to be written.
        info: Of the stage.
        default_prim: Name of its default prim, "" if it has none.

    Raises:
        OutputError: If the file is one of the stage's layers or has no name of a USD file.
    """
    target = layer_path(output, sources=info.layers)
    layer_format = LayerFormat(
        units=info.units,
        frames_per_second=info.frames_per_second,
        start_code=info.start_code,
        end_code=info.end_code,
    )
    layer = new_layer(layer_format, text=target.suffix != ".usdc")
    if default_prim:
        layer.defaultPrim = default_prim
    else:
        layer.ClearDefaultPrim()
    layer.subLayerPaths = [relative_asset(info.identifier, target.parent)]
    return target, layer


def author_times(prim: Sdf.PrimSpec, name: str, times: FloatArray, *, units: StageUnits) -> None:
    """A uniform timecode[] attribute of times [s]."""
    codes = rounded_codes(units.times_to_codes(times)).tolist()
    author(prim, name, Sdf.ValueTypeNames.TimeCodeArray, value=Sdf.TimeCodeArray(codes), uniform=True)
