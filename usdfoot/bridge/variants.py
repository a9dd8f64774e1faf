"""Variants: what is selected of an asset."""

from __future__ import annotations

from pxr import Sdf

from usdfoot.bridge.scene import Variants

__all__ = ["select_variants"]


def select_variants(prim: Sdf.PrimSpec, variants: Variants) -> None:
    """Has a prim of a layer select variants."""
    for variant_set, name in variants:
        if name:
            prim.variantSelections[variant_set] = name
        else:
            prim.BlockVariantSelection(variant_set)
