"""Clips as a stage: for each skeleton a SkelRoot with its Skeleton, and a SkelAnimation for each of its clips."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Vt

from usdfoot.bridge import tokens
from usdfoot.bridge.names import unique_name, valid_name
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import OutputError
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.capture import Capture
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton, forward_kinematics
from usdfoot.writers.layers import (
    LayerFormat,
    apply_schemas,
    author,
    author_samples,
    author_targets,
    define_prim,
    new_layer,
    quaternion_array,
    rounded_codes,
)
from usdfoot.writers.paths import layer_path
from usdfoot.writers.staging import staged_files

__all__ = ["CLIPS_PRIM", "write_clips"]

ValueTypes = Sdf.ValueTypeNames

CLIPS_PRIM = "/Clips"
"""The default prim."""
MOTION = f"{CLIPS_PRIM}/Motion"
"""What the animations are in, whatever their skeleton."""


def write_clips(
    file: str | os.PathLike[str],
    captures: Mapping[str, Capture],
    *,
    sources: Sequence[str | os.PathLike[str]] = (),
    provenance: Mapping[str, Any] | None = None,
) -> Path:
    """Write clips with their skeletons as a USD stage in metres, +Y up, at the rate of the densest clip.

    Args:
        file: .usd, .usda or .usdc to write, replaced if it exists; text only if it is named .usda.
        captures: Skeletons with clips, by the names their SkelRoots shall have.
        sources: Files that must not be replaced.
        provenance: For `customLayerData["usdfoot"]`.

    Raises:
        OutputError: If the file's name is no USD layer's, would replace a source, or cannot be written.
    """
    target = layer_path(file, sources=sources)
    clips = [clip for capture in captures.values() for clip in capture.clips]
    if not clips:
        raise OutputError(file, "there is no clip to write", "import a file with motion")
    rate = max(clip.rate for clip in clips)
    units = StageUnits(meters_per_unit=1.0, up_axis="Y", time_codes_per_second=rate)
    codes = rounded_codes(units.times_to_codes(np.array([clip.times[[0, -1]] for clip in clips])))
    layer_format = LayerFormat(
        units=units,
        frames_per_second=rate,
        start_code=float(np.min(codes)),
        end_code=float(np.max(codes)),
    )
    layer = new_layer(layer_format, text=target.suffix == ".usda")
    layer.defaultPrim = Sdf.Path(CLIPS_PRIM).name
    layer.customLayerData = {tokens.PROVENANCE: dict(provenance or {})}
    with Sdf.ChangeBlock():
        define_prim(layer, CLIPS_PRIM, "Xform")
    rigs, motions = {"Motion"}, set[str]()
    for name, capture in captures.items():
        rig = f"{CLIPS_PRIM}/{unique_name(valid_name(name), rigs)}"
        paths = [f"{MOTION}/{unique_name(valid_name(clip.name), motions)}" for clip in capture.clips]
        with Sdf.ChangeBlock():
            skeleton = _write_skeleton(layer, rig, capture.skeleton)
            author_targets(skeleton, "skel:animationSource", paths[:1])
        for path, clip in zip(paths, capture.clips, strict=True):
            with Sdf.ChangeBlock():
                _write_clip(layer, path, clip, capture.skeleton, units)
                author_targets(layer.GetPrimAtPath(path), tokens.Clip.SKELETON, [str(skeleton.path)])
    with staged_files(target.parent) as files:
        files.add_layer(target.name, layer)
    return target


def _write_skeleton(layer: Sdf.Layer, path: str, skeleton: Skeleton) -> Sdf.PrimSpec:
    """A SkelRoot at the path with the Skeleton below, bound as it rests; gives back the Skeleton."""
    positions, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    root = define_prim(layer, path, "SkelRoot")
    author(
        root, "extent", ValueTypes.Float3Array, value=_points(np.stack([positions.min(axis=0), positions.max(axis=0)]))
    )
    prim = define_prim(layer, f"{path}/Skeleton", "Skeleton")
    apply_schemas(prim, ["SkelBindingAPI"])
    author(prim, "joints", ValueTypes.TokenArray, value=Vt.TokenArray(skeleton.joints), uniform=True)
    for name, matrices in (
        ("bindTransforms", _matrices(positions, turns)),
        ("restTransforms", _matrices(skeleton.rest_translations, skeleton.rest_rotations)),
    ):
        author(prim, name, ValueTypes.Matrix4dArray, value=Vt.Matrix4dArray.FromNumpy(matrices), uniform=True)
    return prim


def _write_clip(layer: Sdf.Layer, path: str, clip: Clip, skeleton: Skeleton, units: StageUnits) -> None:
    prim = define_prim(layer, path, "SkelAnimation")
    apply_schemas(prim, [tokens.Schema.CLIP])
    frames, joints = clip.rotations.shape[:2]
    codes = rounded_codes(units.times_to_codes(clip.times)).tolist()
    slices = [slice(frame * joints, (frame + 1) * joints) for frame in range(frames)]
    translations = _points(clip.translations.reshape(-1, 3))
    rotations = quaternion_array(clip.rotations.reshape(-1, 4))
    author(prim, "joints", ValueTypes.TokenArray, value=Vt.TokenArray(skeleton.joints), uniform=True)
    author_samples(author(prim, "translations", ValueTypes.Float3Array), codes, [translations[s] for s in slices])
    author_samples(author(prim, "rotations", ValueTypes.QuatfArray), codes, [rotations[s] for s in slices])
    scales = Vt.Vec3hArray.FromNumpy(np.ones((joints, 3), dtype=np.float16))
    author(prim, "scales", ValueTypes.Half3Array, value=scales)
    if clip.style != "default":
        author(prim, tokens.Clip.STYLE, ValueTypes.Token, value=clip.style, uniform=True)


def _matrices(translations: FloatArray, rotations: FloatArray) -> FloatArray:
    """Row-vector matrices (J, 4, 4)."""
    matrices = np.tile(np.eye(4), (len(translations), 1, 1))
    matrices[:, :3, :3] = np.swapaxes(quaternion.to_matrix(rotations), -1, -2)
    matrices[:, 3, :3] = translations
    return matrices


def _points(points: FloatArray) -> Any:
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(points, dtype=np.float32))
