"""The project's stepping stones with few of its clips, so that a test need not analyse them all."""

import shutil
from pathlib import Path

import pytest
from pxr import Sdf, Usd

KEPT = ("walk_050", "walk_070", "walk_090", "walk_110", "walk_130", "walk_long", "walk_narrow", "walk_wide", "stand")


def write_few_clips_scene(stages: Path, folder: Path) -> Path:
    """A scene over a copy of stages/stepping_stones.usda in which only the clips of KEPT are active."""
    if not (stages / "stepping_stones.usda").is_file():
        pytest.skip("stages/ has not been made: run make stages")
    source = shutil.copytree(stages, folder / "stages") / "stepping_stones.usda"
    layer = Sdf.Layer.CreateNew(str(folder / "few_clips.usda"))
    layer.subLayerPaths = [str(source)]
    scene = Sdf.Layer.FindOrOpen(str(source))
    for key in ("metersPerUnit", "upAxis", "timeCodesPerSecond", "framesPerSecond", "defaultPrim"):
        if scene.pseudoRoot.HasInfo(key):
            layer.pseudoRoot.SetInfo(key, scene.pseudoRoot.GetInfo(key))
    stage = Usd.Stage.Open(layer)
    for prim in stage.GetPrimAtPath("/World/Library/Motion/Clips").GetChildren():
        if prim.GetName() not in KEPT:
            stage.OverridePrim(prim.GetPath()).SetActive(False)
    stage.Save()
    return Path(layer.realPath)
