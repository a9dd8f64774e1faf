"""The whole way on disk against authoring and saving the same samples alone."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable, Iterable
from itertools import pairwise
from pathlib import Path

from pxr import Sdf

from benching.scene import write_scene
from usdfoot.batch.analysed import forget_examples
from usdfoot.engine.animate import prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.pipeline.animate import animate
from usdfoot.readers.libraries import read_libraries

__all__ = ["author_samples", "disk_times", "read_samples"]


def disk_times(stages: Path, *, agents: int = 100, frames: int = 240, repeats: int = 3) -> dict[str, float]:
    """Seconds to animate a scene of walking people, and to author and save the samples it wrote.

    Args:
        stages: Folder of human.usdc and clips.usdc.
        agents: People.
        frames: Samples of each, at 30 a second.
        repeats: Shortest of so many runs of either, in turn.

    Returns:
        The parts of animating by name, "whole" (read, plan, synthesise, author, save), "author alone" and their
        "ratio"; the same "again" in a process that has analysed these clips before; then "library", what it takes to
        read and analyse the clips, which is the same for one agent or ten thousand, and "ratio without library".
    """
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        scene = folder / "scene.usda"
        write_scene(scene, stages, agents, frames)
        animate(scene, folder / "out")  # kernels are compiled and files are in the system's cache
        samples = read_samples(sorted((folder / "out").glob("a*.usdc")))
        runs, again, library_times = [], [], []
        for number in range(repeats):
            library_times.append(_timed(lambda: _prepare_libraries(stages)))
            forget_examples()
            parts = _timed_animate(scene, folder / f"out{number}")
            again.append(sum(_timed_animate(scene, folder / f"again{number}").values()))
            runs.append((parts, _timed(lambda n=number: author_samples(samples, folder / f"alone{n}.usdc"))))  # type: ignore[misc]
    parts = min((run[0] for run in runs), key=lambda run: sum(run.values()))
    whole, alone = sum(parts.values()), min(run[1] for run in runs)
    library = min(library_times)
    return {
        **parts,
        "whole": whole,
        "author alone": alone,
        "ratio": whole / alone,
        "again": min(again),
        "ratio again": min(again) / alone,
        "library": library,
        "ratio without library": (whole - library) / alone,
    }


def _prepare_libraries(stages: Path) -> None:
    """Read and analyse the clips as `animate` does."""
    for library in read_libraries(stages / "clips.usdc").libraries:
        prepare_library(library, EngineOptions())


def _timed(run: Callable[[], object]) -> float:
    begin = time.perf_counter()
    run()
    return time.perf_counter() - begin


def _timed_animate(scene: Path, folder: Path) -> dict[str, float]:
    """Durations of the parts that `animate` names [s]."""
    marks: list[tuple[str, float]] = []
    animate(scene, folder, progress=lambda part, done, total: marks.append((part, time.perf_counter())))
    marks.append(("", time.perf_counter()))
    durations: dict[str, float] = {}
    for (part, begin), (_, end) in pairwise(marks):
        durations[part] = durations.get(part, 0.0) + end - begin
    return durations


Samples = list[tuple[str, str, Sdf.ValueTypeName, list[float], list[object]]]


def read_samples(files: Iterable[Path]) -> Samples:
    """Prim, name, type, codes and values of every time-sampled attribute of written layers."""
    samples: Samples = []
    for path in files:
        layer = Sdf.Layer.FindOrOpen(os.fspath(path))

        def visit(path: Sdf.Path, layer: Sdf.Layer = layer) -> None:
            codes = layer.ListTimeSamplesForPath(path) if path.IsPropertyPath() else []
            if codes:
                kind = layer.GetAttributeAtPath(path).typeName
                values = [layer.QueryTimeSample(path, code) for code in codes]
                samples.append((str(path.GetPrimPath()), path.name, kind, list(codes), values))

        layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    return samples


def author_samples(samples: Samples, path: Path) -> None:
    """Author the samples into a new layer and save it."""
    layer = Sdf.Layer.CreateNew(os.fspath(path))
    with Sdf.ChangeBlock():
        for prim_path, name, kind, codes, values in samples:
            prim = Sdf.CreatePrimInLayer(layer, prim_path)
            prim.specifier = Sdf.SpecifierDef
            attribute = Sdf.AttributeSpec(prim, name, kind)
            attribute_path = attribute.path
            for code, value in zip(codes, values, strict=True):
                layer.SetTimeSample(attribute_path, code, value)
    layer.Save()
