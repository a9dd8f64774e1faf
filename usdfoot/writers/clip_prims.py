"""Clips as SkelAnimation prims on the Skeleton of a character."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pxr import Sdf, Vt

from usdfoot.bridge import tokens
from usdfoot.bridge.scene import Character
from usdfoot.bridge.similarity import unfold_from_joints
from usdfoot.bridge.units import StageUnits
from usdfoot.model.clip import Clip
from usdfoot.writers.layers import author, author_samples, author_targets, quaternion_array, rounded_codes

__all__ = ["MadeClip", "author_clip", "define_clip"]

ValueTypes = Sdf.ValueTypeNames


@dataclass(frozen=True, kw_only=True)
class MadeClip:
    """A clip to be added to the stage of the clips it was made from."""

    clip: Clip
    """Named by the prim path it gets."""
    character: Character
    """What it was made for."""


def define_clip(layer: Sdf.Layer, made: MadeClip, units: StageUnits) -> None:
    """Make the clip's prim, which has its events already, a SkelAnimation of its character's Skeleton."""
    prim = Sdf.CreatePrimInLayer(layer, made.clip.name)
    prim.specifier, prim.typeName = Sdf.SpecifierDef, "SkelAnimation"
    author_clip(prim, made.clip, made.character, units=units)
    author_targets(prim, tokens.Clip.SKELETON, [made.character.skeleton.name])


def author_clip(prim: Sdf.PrimSpec, clip: Clip, character: Character, *, units: StageUnits) -> None:
    """Samples in the units and axes of the character's Skeleton, and what UsdfootClipAPI says beside events.

    Args:
        prim: A SkelAnimation without any of it.
        clip: On the character's joints, canonical.
        character: What it moves.
        units: Of the layer.
    """
    skeleton = character.skeleton
    author(prim, "joints", ValueTypes.TokenArray, value=Vt.TokenArray(skeleton.joints), uniform=True)
    translations, rotations = unfold_from_joints(
        character.skeleton_to_agent, skeleton.parents, translations=clip.translations, rotations=clip.rotations
    )
    translations = (translations / character.inherited_scales[:, None]).astype(np.float32)
    codes = rounded_codes(units.times_to_codes(clip.times)).tolist()
    places = [Vt.Vec3fArray.FromNumpy(frame) for frame in translations]
    author_samples(author(prim, "translations", ValueTypes.Float3Array), codes, places)
    turns = [quaternion_array(frame) for frame in rotations]
    author_samples(author(prim, "rotations", ValueTypes.QuatfArray), codes, turns)
    scales = Vt.Vec3hArray.FromNumpy(np.ascontiguousarray(character.rest_scales, dtype=np.float16))
    author(prim, "scales", ValueTypes.Half3Array, value=scales)
    _author_attributes(prim, clip, units)


def _author_attributes(prim: Sdf.PrimSpec, clip: Clip, units: StageUnits) -> None:
    """Style, range, where it comes from and the rest."""
    names = tokens.Clip
    author(prim, names.STYLE, ValueTypes.Token, value=clip.style, uniform=True)
    author(prim, names.ROOT_MOTION, ValueTypes.Token, value=clip.root_motion, uniform=True)
    author(prim, names.MIRROR, ValueTypes.Bool, value=clip.mirror, uniform=True)
    if clip.cyclic is not None:
        author(prim, names.CYCLIC, ValueTypes.Bool, value=clip.cyclic, uniform=True)
    for name, time in ((names.START, clip.range_start), (names.END, clip.range_end)):
        if time is not None:
            code = Sdf.TimeCode(float(rounded_codes(units.times_to_codes(np.array(time)))))
            author(prim, name, ValueTypes.TimeCode, value=code, uniform=True)
    if clip.synthetic:
        author(prim, names.SOURCE, ValueTypes.Token, value=tokens.ClipSource.SYNTHETIC, uniform=True)
        prim.customData = {"synthetic": True}
