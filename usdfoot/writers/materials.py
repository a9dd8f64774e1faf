"""The materials' layer: those of the scene that agents are bound to, referenced where they are or copied."""

from __future__ import annotations

from pathlib import Path

from pxr import Sdf

from usdfoot.bridge.names import unique_name
from usdfoot.bridge.own_attributes import OwnBinding
from usdfoot.bridge.scene import Scene
from usdfoot.bridge.tokens import File
from usdfoot.writers.characters import CharacterCopy, copy_material
from usdfoot.writers.layers import LayerFormat, define_prim, new_layer
from usdfoot.writers.paths import relative_asset

__all__ = ["material_layers"]


def material_layers(scene: Scene, folder: Path, *, layer_format: LayerFormat, collect: bool) -> list[CharacterCopy]:
    """The layer of a crowd's materials and the copies that it refers to; none without materials.

    Args:
        scene: As read.
        folder: Real path of the crowd's folder.
        layer_format: Stage metadata of the crowd.
        collect: Copy the materials with their textures.
    """
    bindings = [said for own in scene.own_attributes.values() for said in own.values() if isinstance(said, OwnBinding)]
    sources = {binding.material: binding.source for binding in bindings if binding.source}
    copies: list[CharacterCopy] = []
    names: set[str] = set()
    layer = new_layer(layer_format, text=True)
    for path, source in sorted(sources.items()):
        prim = define_prim(layer, path, "Material")
        file, place = source
        if collect:
            name = unique_name(Sdf.Path(path).name, names)
            copies.append(copy_material(source, name, folder=folder, layer_format=layer_format))
            reference = Sdf.Reference(f"./{copies[-1].name}", f"/{name}")
        else:
            reference = Sdf.Reference(relative_asset(file, folder), place)
        prim.referenceList.prependedItems = [reference]
    return [*copies, CharacterCopy(name=File.MATERIALS, layer=layer)] if sources else []
