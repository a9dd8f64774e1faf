"""The project's stages with few of their clips, so that a test need not analyse them all."""

import shutil
from collections.abc import Collection
from pathlib import Path

import pytest
from pxr import Sdf

KEPT = ("walk_050", "walk_070", "walk_090", "walk_110", "walk_130", "walk_long", "walk_narrow", "walk_wide", "stand")


def copy_stages(stages: Path, folder: Path, *, kept: Collection[str] = KEPT) -> Path:
    """A copy of stages/, of whose clips only those kept are active."""
    if not (stages / "stepping_stones.usda").is_file():
        pytest.skip("stages/ has not been made: run make stages")
    copy = shutil.copytree(stages, folder / "stages", ignore=shutil.ignore_patterns("*.png"))
    layer = Sdf.Layer.FindOrOpen(str(copy / "clips.usdc"))
    for prim in layer.GetPrimAtPath("/HumanClips/Clips").nameChildren:
        if prim.name not in kept:
            prim.active = False
    layer.Save()
    return copy


def write_few_clips_scene(stages: Path, folder: Path) -> Path:
    """A scene over a copy of stages/stepping_stones.usda in which only the clips of KEPT are active."""
    source = copy_stages(stages, folder) / "stepping_stones.usda"
    layer = Sdf.Layer.CreateNew(str(folder / "few_clips.usda"))
    layer.subLayerPaths = [str(source)]
    scene = Sdf.Layer.FindOrOpen(str(source))
    for key in ("metersPerUnit", "upAxis", "timeCodesPerSecond", "framesPerSecond", "defaultPrim"):
        if scene.pseudoRoot.HasInfo(key):
            layer.pseudoRoot.SetInfo(key, scene.pseudoRoot.GetInfo(key))
    layer.Save()
    return Path(layer.realPath)
