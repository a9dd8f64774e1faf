"""Crowds as artists change them, and what became of that when they are made again."""

from contextlib import contextmanager

import numpy as np
from pxr import Sdf, Usd

from tests.digests import digests
from usdfoot.bridge.tokens import File
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.validate import validate


@contextmanager
def edited(folder):
    """The crowd as a stage whose edits go into overrides.usda, saved and closed when the block ends."""
    stage = Usd.Stage.Open(str(folder / File.CROWD))
    stage.Reload()
    layer = Sdf.Layer.FindOrOpen(str(folder / File.OVERRIDES))
    stage.SetEditTarget(layer)
    yield stage
    layer.Save()


def strikes(folder, name):
    """World positions [stage units] and times [codes] at which the left foot of an agent stands."""
    stage = Usd.Stage.Open(str(folder / File.CROWD))
    stage.Reload()
    prim = stage.GetPrimAtPath(f"/Crowd/Anims/{name}")
    times = prim.GetAttribute("usdfoot:contact:left:strikeTimes").Get()
    return np.array(prim.GetAttribute("usdfoot:contact:left:positions").Get()), np.array([float(t) for t in times])


def liftoffs(folder, name):
    """Times [codes] at which an agent's feet leave its footsteps, as executed."""
    stage = Usd.Stage.Open(str(folder / File.CROWD))
    stage.Reload()
    times = stage.GetAttributeAtPath(f"/Crowd/Plans/{name}.usdfoot:plan:liftoffTimes").Get()
    return np.array([float(code) for code in times])


def remake(scene, folder):
    """The crowd made again; the overrides are as they were and the figures within their targets."""
    kept = (folder / File.OVERRIDES).read_bytes()
    report = animate(scene, folder, chunk_size=1)
    assert (folder / File.OVERRIDES).read_bytes() == kept
    before = digests(folder)
    assert animate(scene, folder, chunk_size=1).kept == report.chunks and digests(folder) == before
    for path in folder.iterdir():
        layer = Sdf.Layer.Find(str(path))
        if layer:
            layer.Reload()  # the test looked at the crowd before
    assert validate(folder / File.CROWD).passed
    return report
