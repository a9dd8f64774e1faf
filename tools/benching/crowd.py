"""Crowds of growing size: time, memory and bytes on the way from a plan to disk, and how they grow."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from pxr import Usd, UsdSkel

from benching.disk import author_samples, read_samples
from benching.scene import write_scene
from usdfoot.engine.animate import PreparedLibraries, animate_crowd
from usdfoot.engine.options import EngineOptions
from usdfoot.pipeline.provenance import CHUNK_SIZE
from usdfoot.readers.scene import SceneReader

__all__ = ["crowd_times", "draw_growth", "growth_exponent"]


def crowd_times(stages: Path, *, agents: int, frames: int) -> dict[str, float]:
    """Figures of one crowd of walking people.

    Args:
        stages: Folder of human.usdc and clips.usdc.
        agents: People.
        frames: Samples of each, at 30 a second.

    Returns:
        "synthesis [agent-frames/s]" without reading or writing, "end to end [agent-frames/s]", the durations [s] of the
        command with one and two processes (what it uses on two cores unless told otherwise), of authoring and saving
        the same samples alone in one process, and of opening the crowd and posing everybody with UsdSkel; "memory [MB]"
        at most, of any process; bytes on disk an agent-frame.
    """
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        scene = folder / "scene.usda"
        write_scene(scene, stages, agents, frames)
        synthesis = _synthesis_time(scene)
        two, _ = _command_time(scene, folder / "two", workers=2)
        one, memory = _command_time(scene, folder / "one", workers=1)
        floor = _floor_time(folder / "one", folder / "alone.usdc")
        size = sum(path.stat().st_size for path in (folder / "one").glob("a*.usdc"))
        opened = _open_time(folder / "one" / "crowd.usd")
    count = agents * frames
    return {
        "synthesis [agent-frames/s]": count / synthesis,
        "end to end [agent-frames/s]": count / one,
        "one process [s]": one,
        "two processes [s]": two,
        "one / two": one / two,
        "author alone [s]": floor,
        "ratio": one / floor,
        "ratio, two processes": two / floor,
        "memory [MB]": memory,
        "bytes an agent-frame": size / count,
        "open and pose with UsdSkel [s]": opened,
    }


def growth_exponent(figures: Mapping[int, Mapping[str, float]], name: str) -> float:
    """Slope of a duration over the number of agents, both logarithmic: 1 = as the crowd grows."""
    agents = np.log(list(figures))
    return float(np.polyfit(agents, np.log([row[name] for row in figures.values()]), 1)[0])


def draw_growth(figures: Mapping[int, Mapping[str, float]], names: Sequence[str], path: Path) -> None:
    """Durations over the number of agents, both axes logarithmic, as a picture."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.0, 4.5), layout="constrained")
    axes = figure.add_subplot()
    for name in names:
        slope = growth_exponent(figures, name)
        axes.loglog(list(figures), [row[name] for row in figures.values()], "o-", label=f"{name}: exponent {slope:.2f}")
    axes.set_xlabel("agents")
    axes.set_ylabel("seconds")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=120)


def _synthesis_time(scene: Path) -> float:
    """Seconds to animate all agents in memory, chunk by chunk, their clips analysed before."""
    reader, options = SceneReader(scene), EngineOptions()
    libraries = PreparedLibraries(options)
    names = reader.names
    animate_crowd(reader.read(names=names[:1]).crowd, options=options, libraries=libraries)
    total = 0.0
    for start in range(0, len(names), CHUNK_SIZE):
        crowd = reader.read(names=names[start : start + CHUNK_SIZE]).crowd
        begin = time.perf_counter()
        animate_crowd(crowd, options=options, libraries=libraries)
        total += time.perf_counter() - begin
    return total


def _command_time(scene: Path, folder: Path, *, workers: int) -> tuple[float, float]:
    """Seconds that the command takes, and the most memory any of its processes had [MB]."""
    command = [sys.executable, "-m", "usdfoot.cli.main", "animate", scene, "-o", folder, "-q", "--workers", workers]
    compiled = {
        name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"
    }  # as if installed
    begin = time.perf_counter()
    process = subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL, env=compiled)
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise RuntimeError(f"animate ended with {os.waitstatus_to_exitcode(status)}")
    scale = 1e6 if sys.platform == "darwin" else 1e3
    return time.perf_counter() - begin, usage.ru_maxrss / scale


def _floor_time(folder: Path, alone: Path) -> float:
    """Seconds to author and save the samples of a crowd alone, chunk by chunk."""
    total = 0.0
    for anims in sorted(folder.glob("anims.*.usdc")):
        number = anims.name.split(".")[1]
        agents = folder / f".chunks/agents.{number}.usdc"
        samples = read_samples([anims, agents if agents.exists() else folder / "agents.usdc"])
        begin = time.perf_counter()
        author_samples(samples, alone)
        total += time.perf_counter() - begin
        alone.unlink()
    return total


def _open_time(crowd: Path) -> float:
    """Seconds to open a crowd and have UsdSkel compute the pose of everybody halfway."""
    begin = time.perf_counter()
    stage = Usd.Stage.Open(str(crowd))
    halfway = (stage.GetStartTimeCode() + stage.GetEndTimeCode()) / 2.0
    cache = UsdSkel.Cache()
    predicate = Usd.TraverseInstanceProxies()
    for prim in stage.GetPrimAtPath("/Crowd/Agents").GetChildren():
        cache.Populate(UsdSkel.Root(prim), predicate)
        below = Usd.PrimRange(prim, predicate)
        skeleton = next(UsdSkel.Skeleton(part) for part in below if part.IsA(UsdSkel.Skeleton))
        cache.GetSkelQuery(skeleton).ComputeSkinningTransforms(halfway)
    return time.perf_counter() - begin
