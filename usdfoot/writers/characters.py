"""Characters: referenced where they are, or copied beside the crowd where that cannot be."""

from __future__ import annotations

import glob
import hashlib
import logging
import os
from dataclasses import dataclass, field
from pathlib import Path

from pxr import Ar, Sdf, Usd, UsdUtils

from usdfoot.bridge.scene import Character
from usdfoot.bridge.tokens import Schema
from usdfoot.bridge.variants import select_variants
from usdfoot.writers.layers import LayerFormat, new_layer
from usdfoot.writers.paths import relative_asset

__all__ = ["FOLDER", "CharacterCopy", "copy_character", "copy_material", "is_bound", "must_be_copied", "open_asset"]

_logger = logging.getLogger(__name__)

FOLDER = "characters"
"""Folder of copies within the crowd's."""
_PLACING = ("xformOp", "usdfoot:agent:", "skel:animationSource")
"""Properties of a character prim that its agents author anew."""


@dataclass(frozen=True, kw_only=True)
class CharacterCopy:
    """A character on its own, to be written into the crowd's folder."""

    name: str
    """File name relative to the crowd's folder."""
    layer: Sdf.Layer
    files: dict[str, Path] = field(default_factory=dict)
    """Textures and other files to copy, by name relative to the crowd's folder."""


def open_asset(character: Character) -> Usd.Stage:
    """The character's asset in its variants, as little of it as there is to the character."""
    mask = Usd.StagePopulationMask([character.asset_prim])
    stage = Usd.Stage.OpenMasked(Sdf.Layer.FindOrOpen(character.asset), mask)
    if character.variants:
        select_variants(Sdf.CreatePrimInLayer(stage.GetSessionLayer(), character.asset_prim), character.variants)
    stage.ExpandPopulationMask()
    return stage


def must_be_copied(stage: Usd.Stage, character: Character) -> bool:
    """Whether a reference would not do: the Skeleton is the prim itself, or bound to an animation below the prim."""
    if not character.skeleton_path:
        return True
    top = Sdf.Path(character.asset_prim)
    prim = stage.GetPrimAtPath(top.AppendPath(character.skeleton_path))
    while prim and prim.GetPath() != top:
        if is_bound(prim):
            return True
        prim = prim.GetParent()
    return False


def is_bound(prim: Usd.Prim) -> bool:
    """Whether the prim itself says which animation it has."""
    relationship = prim.GetRelationship("skel:animationSource")
    return bool(relationship and relationship.HasAuthoredTargets())


def copy_character(
    stage: Usd.Stage, character: Character, name: str, *, folder: Path, layer_format: LayerFormat, collect: bool
) -> CharacterCopy:
    """The character flattened into a layer of its own, without its place and animation.

    Args:
        stage: Of the asset.
        character: What to copy.
        name: Of the copy's root prim and file.
        folder: Real path of the crowd's folder.
        layer_format: Stage metadata of the copy.
        collect: Copy its textures too, instead of pointing at them.
    """
    layer = new_layer(layer_format)
    target = Sdf.Path(f"/{name}")
    if not character.skeleton_path:
        root = Sdf.CreatePrimInLayer(layer, target)
        root.specifier, root.typeName = Sdf.SpecifierDef, "SkelRoot"
        target = target.AppendChild("Skeleton")
    _copy_prim(stage, character.asset_prim, layer, target)
    _release(layer.GetPrimAtPath(target))
    return _with_files(f"{FOLDER}/{name}.usdc", layer, folder=folder, collect=collect)


def copy_material(source: tuple[str, str], name: str, *, folder: Path, layer_format: LayerFormat) -> CharacterCopy:
    """A material flattened into a layer of its own, with its textures.

    Args:
        source: Layer and prim path.
        name: Of the copy's file and root prim.
        folder: Real path of the crowd's folder.
        layer_format: Stage metadata of the copy.
    """
    file, path = source
    stage = Usd.Stage.OpenMasked(Sdf.Layer.FindOrOpen(file), Usd.StagePopulationMask([path]))
    layer = new_layer(layer_format)
    _copy_prim(stage, path, layer, Sdf.Path(f"/{name}"))
    return _with_files(f"{FOLDER}/materials/{name}.usdc", layer, folder=folder, collect=True)


def _copy_prim(stage: Usd.Stage, path: str, layer: Sdf.Layer, target: Sdf.Path) -> None:
    """Copy a prim, flattened, and have it be the layer's default."""
    flat = stage.Flatten(addSourceFileComment=False)
    layer.defaultPrim = target.GetPrefixes()[0].name
    for key in ("metersPerUnit", "upAxis", "timeCodesPerSecond", "framesPerSecond"):
        if flat.pseudoRoot.HasInfo(key):
            layer.pseudoRoot.SetInfo(key, flat.pseudoRoot.GetInfo(key))
    Sdf.CopySpec(flat, Sdf.Path(path), layer, target)
    for prim in flat.rootPrims:
        if prim.name.startswith("Flattened_Prototype"):
            Sdf.CopySpec(flat, prim.path, layer, prim.path)


def _with_files(name: str, layer: Sdf.Layer, *, folder: Path, collect: bool) -> CharacterCopy:
    """A layer with asset paths as they must stand in a file of that name in the folder."""
    copied = CharacterCopy(name=name, layer=layer)
    UsdUtils.ModifyAssetPaths(layer, lambda path: _moved(path, copied, folder, collect))
    return copied


def _release(prim: Sdf.PrimSpec) -> None:
    """Remove what places and animates a flattened character, here and below."""
    for name in [prop.name for prop in prim.properties if prop.name.startswith(_PLACING)]:
        del prim.properties[name]
    schemas = prim.GetInfo("apiSchemas")
    kept = [item for item in schemas.ApplyOperations([]) if item != Schema.AGENT]
    if len(kept) != len(schemas.ApplyOperations([])):
        prim.SetInfo("apiSchemas", Sdf.TokenListOp.CreateExplicit(kept))

    def unbind(path: Sdf.Path) -> None:
        spec = prim.layer.GetObjectAtPath(path)
        if isinstance(spec, Sdf.RelationshipSpec) and spec.name == "skel:animationSource":
            bindings.append(spec)

    bindings: list[Sdf.RelationshipSpec] = []
    prim.layer.Traverse(prim.path, unbind)
    for spec in bindings:
        owner = spec.owner
        del owner.properties[spec.name]


def _moved(path: str, copied: CharacterCopy, folder: Path, collect: bool) -> str:
    """Asset path as it must stand in the copy; files to be collected are noted."""
    if not path or not os.path.isabs(path):
        return path
    if not collect:
        return relative_asset(path, folder / os.path.dirname(copied.name))
    path, packaged = Ar.SplitPackageRelativePathOuter(path)  # a package comes along whole
    home = copied.name.removesuffix(".usdc")
    digest = hashlib.sha256(os.path.dirname(path).encode()).hexdigest()[:8]
    tiles = [tile for tile in glob.glob(glob.escape(path).replace("<UDIM>", "[0-9][0-9][0-9][0-9]")) if _is_asset(tile)]
    if not tiles:
        _logger.warning("%s: is no file to collect, %s keeps its path. see that it is there", path, copied.name)
    for tile in tiles:
        copied.files[f"{home}/{digest}/{os.path.basename(tile)}"] = Path(tile)
    moved = f"./{os.path.basename(home)}/{digest}/{os.path.basename(path)}" if tiles else path
    return Ar.JoinPackageRelativePath(moved, packaged) if packaged else moved


def _is_asset(path: str) -> bool:
    """Whether it is a file of some kind: a device would never end, and keys and passwords seldom have a suffix."""
    return bool(os.path.isfile(path) and os.path.splitext(path)[1])
