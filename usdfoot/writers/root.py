"""The root layers: crowd.usd, its expanded variant, and the artists' empty layer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pxr import Sdf

from usdfoot.bridge.tokens import PROVENANCE, File, Prim
from usdfoot.writers.layers import LayerFormat, define_prim, new_layer

__all__ = ["SUBLAYERS", "expanded_layer", "root_layer", "scope_layer", "stacked_layer"]

SUBLAYERS = (File.OVERRIDES, File.AGENTS, File.FOOTSTEPS, File.ANIMS)
"""Layers of crowd.usd, strongest first; materials may come after them."""


def root_layer(layer_format: LayerFormat, provenance: Mapping[str, Any], *, has_materials: bool = False) -> Sdf.Layer:
    """crowd.usd: metadata and sublayers, nothing else."""
    layer = stacked_layer(layer_format, (*SUBLAYERS, *[File.MATERIALS] * has_materials))
    layer.customLayerData = {PROVENANCE: dict(provenance)}
    return layer


def stacked_layer(layer_format: LayerFormat, names: Sequence[str]) -> Sdf.Layer:
    """A text layer with the files beside it as sublayers, strongest first."""
    layer = new_layer(layer_format, text=True)
    layer.subLayerPaths = [f"./{name}" for name in names]
    return layer


def scope_layer(layer_format: LayerFormat, scope: str) -> Sdf.Layer:
    """A binary layer with a scope of the crowd, and nobody in it."""
    layer = new_layer(layer_format)
    define_prim(layer, scope, "Scope")
    return layer


def expanded_layer(layer_format: LayerFormat, agents: Sequence[str]) -> Sdf.Layer:
    """crowd.expanded.usda: the crowd without instances, for programs that cannot skin them."""
    layer = stacked_layer(layer_format, [File.CROWD])
    for name in agents:
        Sdf.CreatePrimInLayer(layer, f"{Prim.AGENTS}/{name}").instanceable = False
    return layer
