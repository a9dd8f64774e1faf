"""Synthetic clips as SkelAnimations beside the recorded ones, marked as what they are."""

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

__all__ = ["MadeClip", "define_clip"]

ValueTypes = Sdf.ValueTypeNames


@dataclass(frozen=True, kw_only=True)
class MadeClip:
    """A clip to be written, on the character it was made for."""

    clip: Clip
    """Named by the prim path it gets."""
    character: Character


def define_clip(layer: Sdf.Layer, made: MadeClip, units: StageUnits) -> None:
    """Author a clip's samples, its range and that it is synthetic; style and events are written as for all clips.

    Args:
        layer: Layer to author in.
        made: The clip.
        units: Of the layer.
    """
    clip, character = made.clip, made.character
    prim = Sdf.CreatePrimInLayer(layer, clip.name)
    prim.specifier, prim.typeName = Sdf.SpecifierDef, "SkelAnimation"
    prim.customData = {"synthetic": True}
    names = tokens.Clip
    author(prim, names.SOURCE, ValueTypes.Token, tokens.ClipSource.SYNTHETIC, uniform=True)
    author(prim, names.ROOT_MOTION, ValueTypes.Token, clip.root_motion, uniform=True)
    author(prim, names.CYCLIC, ValueTypes.Bool, bool(clip.cyclic), uniform=True)
    author(prim, names.MIRROR, ValueTypes.Bool, clip.mirror, uniform=True)
    for name, time in ((names.START, clip.range_start), (names.END, clip.range_end)):
        if time is not None:
            code = rounded_codes(units.times_to_codes(np.array([time])))[0]
            author(prim, name, ValueTypes.TimeCode, Sdf.TimeCode(float(code)), uniform=True)
    author_targets(prim, names.SKELETON, [character.skeleton.name])
    _write_samples(prim, clip, character, units)


def _write_samples(prim: Sdf.PrimSpec, clip: Clip, character: Character, units: StageUnits) -> None:
    """Joint transforms in the units and axes of the Skeleton."""
    skeleton = character.skeleton
    translations, rotations = unfold_from_joints(
        character.skeleton_to_agent, skeleton.parents, clip.translations, clip.rotations
    )
    translations = (translations / character.inherited_scales[:, None]).astype(np.float32)
    codes = rounded_codes(units.times_to_codes(clip.times)).tolist()
    author(prim, "joints", ValueTypes.TokenArray, Vt.TokenArray(skeleton.joints), uniform=True)
    author_samples(
        author(prim, "translations", ValueTypes.Float3Array), codes, [Vt.Vec3fArray.FromNumpy(t) for t in translations]
    )
    author_samples(author(prim, "rotations", ValueTypes.QuatfArray), codes, [quaternion_array(r) for r in rotations])
    scales = Vt.Vec3hArray.FromNumpy(np.ascontiguousarray(character.rest_scales, dtype=np.float16))
    author(prim, "scales", ValueTypes.Half3Array, scales)
