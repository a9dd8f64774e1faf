"""Provenance: what a crowd says of its making, and which files a scene consists of, without reading either."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pxr import Sdf, Tf, Usd

from usdfoot.bridge.scene import StageInfo
from usdfoot.bridge.tokens import PROVENANCE, File
from usdfoot.model.limits import DEFAULT_LIMITS
from usdfoot.readers.overrides import read_overrides
from usdfoot.readers.stage import open_stage, read_stage_info, walk_stage

__all__ = ["has_value_clips", "read_provenance", "read_scene_files"]


def read_provenance(folder: Path, *, sublayers: Sequence[str]) -> Mapping[str, Any] | None:
    """What crowd.usd says of its making; None if it is not as it was written, or overrides.usda is missing.

    Args:
        folder: Of the crowd.
        sublayers: Files that crowd.usd consists of, strongest first, beside its materials.
    """
    path = folder / File.CROWD
    if not path.is_file() or not (folder / File.OVERRIDES).is_file():
        return None
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(path))
    except Tf.ErrorException:
        return None
    paths = [path for path in layer.subLayerPaths if path != f"./{File.MATERIALS}"]
    is_whole = not layer.rootPrims and paths == [f"./{name}" for name in sublayers]
    return dict(layer.customLayerData.get(PROVENANCE, {})) if is_whole else None


def read_scene_files(scene: str | os.PathLike[str] | Usd.Stage, folder: Path) -> StageInfo | None:
    """Metadata of a scene, with its layers; None if their bytes and those of overrides.usda do not say all of it.

    They do not where the stage is not as saved, and where files are named that are opened later: layers below
    overrides.usda, and value clips, which `has_value_clips` looks for.

    Args:
        scene: File or open stage.
        folder: Of the crowd made of it.

    Raises:
        SceneError: If the scene or overrides.usda cannot be opened.
    """
    stage = open_stage(scene)
    info = read_stage_info(stage)
    overrides = read_overrides(folder, info.units).layer
    if not info.as_saved:
        return None
    if overrides is not None and (overrides.dirty or overrides.GetCompositionAssetDependencies()):
        return None
    return info


def has_value_clips(scene: str | os.PathLike[str] | Usd.Stage, *, most_prims: int = DEFAULT_LIMITS.prims) -> bool:
    """Whether a scene names files that USD opens when a value is asked for.

    Args:
        scene: File or open stage.
        most_prims: How many prims the scene may have.

    Raises:
        SceneError: If the scene cannot be opened, or there are more prims.
    """
    return any(prim.HasAuthoredMetadata("clips") for prim in walk_stage(open_stage(scene), most=most_prims))
