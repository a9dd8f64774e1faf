"""Retargeted clips: a stage with the character that they move and one SkelAnimation a clip."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf

from usdfoot.bridge import tokens
from usdfoot.bridge.scene import Character
from usdfoot.bridge.units import StageUnits
from usdfoot.model.clip import Clip
from usdfoot.model.contacts import Contacts
from usdfoot.writers.agents import stance_attributes
from usdfoot.writers.attributes import Attribute, author_attributes
from usdfoot.writers.clip_prims import author_clip
from usdfoot.writers.events import author_events
from usdfoot.writers.layers import (
    LayerFormat,
    apply_schemas,
    author_targets,
    define_prim,
    new_layer,
    rounded_codes,
)
from usdfoot.writers.paths import layer_path
from usdfoot.writers.placing import place_characters
from usdfoot.writers.staging import staged_files

__all__ = ["WrittenClip", "write_retargeted"]

ValueTypes = Sdf.ValueTypeNames
ROOT = "/Retargeted"
CHARACTER = f"{ROOT}/Character"
CLIPS = f"{ROOT}/Clips"


@dataclass(frozen=True, kw_only=True)
class WrittenClip:
    """One clip to write."""

    name: str
    """Of its prim, unique."""
    clip: Clip
    """On the character's joints, canonical."""
    contacts: Contacts
    """When its feet stand."""


def write_retargeted(
    output: str | os.PathLike[str],
    clips: Sequence[WrittenClip],
    character: Character,
    *,
    units: StageUnits,
    frames_per_second: float,
    sources: Sequence[str],
    provenance: Mapping[str, Any],
) -> Path:
    """Write a stage in which the character plays the first clip, and the others wait below /Retargeted/Clips.

    The character is referenced where it is; one whose Skeleton is bound to an animation of its own is copied beside the
    file. Contacts become UsdfootClipAPI attributes.

    Args:
        output: .usd, .usda or .usdc to write, replaced if it exists; .usd is binary.
        clips: At least one.
        character: What they move.
        units: Of the stage: lengths and axes of the character's, time codes of the clips'.
        frames_per_second: Playback rate.
        sources: Files that must not be replaced.
        provenance: For `customLayerData["usdfoot"]`.

    Raises:
        OutputError: If the file's name is no USD layer's, would replace a source, or cannot be written.
    """
    target = layer_path(output, sources=sources)
    times = [times for clip in clips for times in (clip.clip.times[0], clip.clip.times[-1])]
    codes = rounded_codes(units.times_to_codes(np.array(times)))
    layer_format = LayerFormat(
        units=units,
        frames_per_second=frames_per_second,
        start_code=float(codes.min()),
        end_code=float(codes.max()),
    )
    (placed,) = place_characters([character], target.parent, layer_format=layer_format, collect=False)
    layer = new_layer(layer_format, text=target.suffix == ".usda")
    layer.defaultPrim = Sdf.Path(ROOT).name
    layer.customLayerData = {tokens.PROVENANCE: dict(provenance)}
    with Sdf.ChangeBlock():
        Sdf.CreatePrimInLayer(layer, ROOT).typeName = "Xform"
        layer.GetPrimAtPath(ROOT).specifier = Sdf.SpecifierDef
        _write_character(layer, character, placed.reference, f"{CLIPS}/{clips[0].name}")
    for clip in clips:
        with Sdf.ChangeBlock():
            _write_clip(layer, clip, character, units)
    with staged_files(target.parent) as files:
        for copied in placed.copies:
            files.add_layer(copied.name, copied.layer)
        files.add_layer(target.name, layer)
    return target


def _write_character(layer: Sdf.Layer, character: Character, reference: Sdf.Reference, animation: str) -> None:
    """The character at the origin, playing an animation."""
    prim = define_prim(layer, CHARACTER, "SkelRoot")
    prim.referenceList.prependedItems = [reference]
    apply_schemas(prim, ["SkelBindingAPI"])
    author_targets(prim, "skel:animationSource", [animation])
    stance = stance_attributes(character)
    author_attributes(prim, {**stance, "xformOpOrder": Attribute("token[]", list(stance), uniform=True)})


def _write_clip(layer: Sdf.Layer, written: WrittenClip, character: Character, units: StageUnits) -> None:
    """One SkelAnimation with UsdfootClipAPI."""
    prim = define_prim(layer, f"{CLIPS}/{written.name}", "SkelAnimation")
    apply_schemas(prim, [tokens.Schema.CLIP])
    author_clip(prim, written.clip, character, units=units)
    author_events(prim, written.contacts, units)
    author_targets(prim, tokens.Clip.SKELETON, ["/".join(filter(None, [CHARACTER, character.skeleton_path]))])
