"""Levels of detail: one asset whose children are the variants of a character, between which renderers choose (UsdLod).

The schemas of UsdLod are authored by name, so that files are the same whether or not the USD at hand has the module.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pxr import Sdf, Usd, Vt

from usdfoot.bridge import tokens
from usdfoot.bridge.scene import Variants
from usdfoot.bridge.variants import select_variants
from usdfoot.model.levels import DetailLevels
from usdfoot.writers.layers import LayerFormat, apply_schemas, author, author_targets, define_prim, new_layer

__all__ = ["LEVELS", "level_layer", "level_set", "place_in_levels", "select_levels"]

ValueTypes = Sdf.ValueTypeNames

LEVELS = ".levels.usda"
"""How files with levels are named after the prim in them."""


def place_in_levels(reference: tuple[str, str]) -> str:
    """Where below a prim with this reference the character is that is shown first; "" = it is the prim.

    Args:
        reference: Asset and prim path.
    """
    asset, prim = reference
    return "/Levels/Level0" if asset == f".{prim}{LEVELS}" else ""


def level_set(prim: Usd.Prim, levels: DetailLevels) -> str | None:
    """The variant set of a character that has all the levels; None = no set has."""
    sets = prim.GetVariantSets()
    for name in sets.GetNames():
        if set(levels.variants) <= set(sets.GetVariantSet(name).GetVariantNames()):
            return str(name)
    return None


def select_levels(prim: Usd.Prim, variant_set: str, levels: DetailLevels) -> Iterator[str]:
    """Names the levels one by one, with the prim's stage showing each by its session layer."""
    stage = prim.GetStage()
    stage.SetEditTarget(stage.GetSessionLayer())
    for variant in levels.variants:
        stage.GetPrimAtPath(prim.GetPath()).GetVariantSet(variant_set).SetVariantSelection(variant)
        yield variant


def level_layer(
    name: str,
    references: Sequence[Sdf.Reference],
    levels: DetailLevels,
    *,
    selects: str | None,
    besides: Variants = (),
    layer_format: LayerFormat,
) -> Sdf.Layer:
    """The asset: ``/<name>`` with the levels below ``Levels`` and what chooses between them beside that.

    Programs that know nothing of levels show the first: the others are invisible, as UsdLod recommends.

    Args:
        name: Of the character.
        references: To the character, one a level.
        levels: Variants and distances.
        selects: Variant set to select the levels in; None = each reference is to another asset.
        besides: What else is selected of the asset.
        layer_format: Stage metadata.
    """
    layer = new_layer(layer_format, text=True)
    layer.defaultPrim = name
    with Sdf.ChangeBlock():
        define_prim(layer, f"/{name}", "SkelRoot").kind = "component"
        root = define_prim(layer, f"/{name}/Levels", "Xform")
        apply_schemas(root, [tokens.Lod.ROOT])
        author_targets(root, tokens.Lod.HEURISTICS, [f"/{name}/Distance"])
        author(root, tokens.Lod.DEFAULT_INDEX, ValueTypes.Int, value=0)
        for number, (variant, reference) in enumerate(zip(levels.variants, references, strict=True)):
            prim = define_prim(layer, f"/{name}/Levels/Level{number}", "SkelRoot")
            prim.referenceList.prependedItems = [reference]
            prim.kind = "subcomponent"
            if selects is not None:
                select_variants(prim, tuple({**dict(besides), selects: variant}.items()))
            author(prim, "xformOpOrder", ValueTypes.TokenArray, value=Vt.TokenArray(), uniform=True)  # agents say where
            if number:
                author(prim, "visibility", ValueTypes.Token, value="invisible")
        distance = define_prim(layer, f"/{name}/Distance", tokens.Lod.DISTANCE)
        author(distance, tokens.Lod.DOMAIN, ValueTypes.Token, value="imaging", uniform=True)
        scale = layer_format.units.meters_per_unit
        thresholds = Vt.FloatArray([metres / scale for metres in levels.distances])
        author(distance, tokens.Lod.THRESHOLDS, ValueTypes.FloatArray, value=thresholds, uniform=True)
    return layer
