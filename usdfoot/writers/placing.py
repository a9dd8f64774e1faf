"""Placing: how a crowd refers to its characters, and to their levels of detail."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pxr import Sdf, Tf, Usd

from usdfoot.bridge.names import unique_name
from usdfoot.bridge.scene import Character
from usdfoot.bridge.variants import select_variants
from usdfoot.errors import SceneError
from usdfoot.model.levels import DetailLevels
from usdfoot.writers.characters import FOLDER, CharacterCopy, copy_character, is_bound, must_be_copied, open_asset
from usdfoot.writers.layers import LayerFormat, define_prim, new_layer
from usdfoot.writers.levels import LEVELS, level_layer, level_set, select_levels
from usdfoot.writers.paths import relative_asset

__all__ = ["PlacedCharacter", "place_characters"]

_logger = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class PlacedCharacter:
    """How agents refer to a character."""

    reference: Sdf.Reference
    copies: tuple[CharacterCopy, ...] = ()
    """What must be written for that."""


def place_characters(
    characters: Sequence[Character],
    folder: Path,
    *,
    layer_format: LayerFormat,
    collect: bool,
    levels: DetailLevels | None = None,
) -> list[PlacedCharacter]:
    """How a crowd in `folder` refers to its characters.

    They are referenced where they are, by way of a layer that selects what the scene does of their variants. Copies are
    made if asked for, and of assets whose Skeleton is bound to an animation of its own: that binding is stronger than
    the agent's, and instances cannot override it.

    Args:
        characters: Of the scene.
        folder: Real path of the crowd's folder.
        layer_format: Stage metadata of the copies.
        collect: Copy all, with their textures.
        levels: Of detail, for characters that have such variants; None = one each.

    Raises:
        SceneError: If no character has the variants.
    """
    placing = _Placing(folder=folder, layer_format=layer_format, collect=collect)
    placed = [placing.with_levels(character, levels) if levels else None for character in characters]
    if levels and not any(placed):
        wanted = f"no character has a variant set with {', '.join(levels.variants)}"
        raise SceneError("levels", wanted, "name variants that they have", _variants(characters))
    return [
        leveled or placing.place(open_asset(character), character, _name(character))
        for leveled, character in zip(placed, characters, strict=True)
    ]


@dataclass(frozen=True, kw_only=True)
class _Placing:
    """Places characters one by one."""

    folder: Path
    layer_format: LayerFormat
    collect: bool
    names: set[str] = field(default_factory=set)
    """Taken by copies."""

    def place(self, stage: Usd.Stage, character: Character, name: str, *, is_level: bool = False) -> PlacedCharacter:
        """A character as the stage of its asset shows it, a copy of it named like that if it must be one.

        As a level it comes below the agent's prim, where a binding of its own prim would be stronger too.
        """
        bound = must_be_copied(stage, character) or (is_level and is_bound(stage.GetPrimAtPath(character.asset_prim)))
        if not self.collect and not bound and (is_level or not character.variants):
            asset = relative_asset(character.asset, self.folder)
            return PlacedCharacter(reference=Sdf.Reference(asset, character.asset_prim))
        name = unique_name(name, self.names)
        if not self.collect and not bound:
            selecting = self._selecting(character, name)
            return PlacedCharacter(reference=Sdf.Reference(f"./{selecting.name}", f"/{name}"), copies=(selecting,))
        copied = copy_character(
            stage, character, name, folder=self.folder, layer_format=self.layer_format, collect=self.collect
        )
        if not self.collect:
            _logger.info("%s: copied to %s, as its Skeleton is bound to an animation", character.path, copied.name)
        return PlacedCharacter(reference=Sdf.Reference(f"./{copied.name}", f"/{name}"), copies=(copied,))

    def _selecting(self, character: Character, name: str) -> CharacterCopy:
        """A layer that refers to a character and selects its variants, which no two agents should do by themselves."""
        layer = new_layer(self.layer_format, text=True)
        layer.defaultPrim = name
        prim = define_prim(layer, f"/{name}", "SkelRoot")
        asset = relative_asset(character.asset, self.folder / FOLDER)
        prim.referenceList.prependedItems = [Sdf.Reference(asset, character.asset_prim)]
        select_variants(prim, character.variants)
        return CharacterCopy(name=f"{FOLDER}/{name}.usda", layer=layer)

    def with_levels(self, character: Character, levels: DetailLevels) -> PlacedCharacter | None:
        """An asset beside the crowd that refers to a character once a level; None if it has no such variants."""
        stage = open_asset(character)
        prim = stage.GetPrimAtPath(character.asset_prim)
        variant_set, name = level_set(prim, levels), _name(character)
        if variant_set is None:
            return None
        items = [
            self.place(stage, character, f"{name}_level{number}", is_level=True)
            for number, _ in enumerate(select_levels(prim, variant_set, levels))
        ]
        copies = tuple(copied for item in items for copied in item.copies)
        name = unique_name(name, self.names)
        layer = level_layer(
            name,
            [item.reference for item in items],
            levels,
            selects=None if copies else variant_set,
            besides=character.variants,
            layer_format=self.layer_format,
        )
        whole = CharacterCopy(name=f"{name}{LEVELS}", layer=layer)
        return PlacedCharacter(reference=Sdf.Reference(f"./{whole.name}", f"/{name}"), copies=(*copies, whole))


def _name(character: Character) -> str:
    """Of a character's copy: whose variants are selected it is the asset's, whichever agent comes first."""
    if not character.variants:
        return Sdf.Path(character.path).name
    selected = [name for _, name in character.variants if name]
    return str(Tf.MakeValidIdentifier("_".join([Sdf.Path(character.asset_prim).name, *selected])))


def _variants(characters: Sequence[Character]) -> list[str]:
    """What variant sets the characters have."""
    found = []
    for character in characters:
        stage = open_asset(character)
        sets = stage.GetPrimAtPath(character.asset_prim).GetVariantSets()
        for name in sets.GetNames():
            found.append(f"{character.path} {name}: {', '.join(sets.GetVariantSet(name).GetVariantNames())}")
    return found
