"""The whole way on disk against authoring and saving the same samples alone."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

from pxr import Sdf, Usd, UsdGeom, Vt

from benching.rigs import straight_plan
from usdfoot.engine.animate import prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.pipeline.animate import animate
from usdfoot.readers.libraries import read_libraries

__all__ = ["disk_times"]

PLAN_TIMES = {"strike": "strike_times", "liftoff": "liftoff_times"}


def disk_times(stages: Path, *, agents: int = 100, frames: int = 240, repeats: int = 3) -> dict[str, float]:
    """Seconds to animate a scene of walking people, and to author and save the samples it wrote.

    Args:
        stages: Folder of human.usdc and clips.usdc.
        agents: People.
        frames: Samples of each, at 30 a second.
        repeats: Shortest of so many runs of either, in turn.

    Returns:
        The parts of animating by name, "whole" (read, plan, synthesise, author, save), "author alone" and their
        "ratio"; then "library", what it takes to read and analyse the clips, which is the same for one agent or ten
        thousand, and "ratio without library".
    """
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        scene = folder / "scene.usda"
        _write_scene(scene, stages, agents, frames)
        animate(scene, folder / "out")  # kernels are compiled and files are in the system's cache
        samples = _read_samples(folder / "out")
        runs, library_times = [], []
        for number in range(repeats):
            library_times.append(_timed(lambda: _prepare_libraries(stages)))
            parts = _timed_animate(scene, folder / f"out{number}")
            runs.append((parts, _timed(lambda n=number: _author(samples, folder / f"alone{n}.usdc"))))  # type: ignore[misc]
    parts = min((run[0] for run in runs), key=lambda run: sum(run.values()))
    whole, alone = sum(parts.values()), min(run[1] for run in runs)
    library = min(library_times)
    return {
        **parts,
        "whole": whole,
        "author alone": alone,
        "ratio": whole / alone,
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
    return {part: end - begin for (part, begin), (_, end) in pairwise(marks)}


def _write_scene(path: Path, stages: Path, agents: int, frames: int) -> None:
    """People in a row that walk straight plans."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(30.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    stage.DefinePrim("/World/Library/Motion").GetReferences().AddReference(str(stages / "clips.usdc"))
    stage.DefinePrim("/World/Library/Character").GetReferences().AddReference(str(stages / "human.usdc"))
    for number in range(agents):
        _write_plan(stage, number, frames / 30.0)
        agent = UsdGeom.Xform.Define(stage, f"/World/Agent_{number}").GetPrim()
        agent.AddAppliedSchema("UsdfootAgentAPI")
        for name, target in (
            ("plan", f"/World/Plans/Walk_{number}"),
            ("character", "/World/Library/Character"),
            ("clips", "/World/Library/Motion/Clips"),
        ):
            agent.CreateRelationship(f"usdfoot:agent:{name}", custom=False).SetTargets([target])
    stage.Save()


def _write_plan(stage: Usd.Stage, number: int, duration: float) -> None:
    plan = straight_plan(number, duration)
    instancer = UsdGeom.PointInstancer.Define(stage, plan.name)
    prints = [UsdGeom.Cube.Define(stage, f"{plan.name}/Prints/{name}").GetPath() for name in ("Left", "Right")]
    instancer.CreatePrototypesRel().SetTargets(prints)
    instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy(plan.sides.astype("int32")))
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(plan.positions.astype("float32")))
    instancer.CreateOrientationsAttr(Vt.QuathArray.FromNumpy(plan.orientations.astype("float16")))
    prim = instancer.GetPrim()
    prim.AddAppliedSchema("UsdfootPlanAPI")
    for event, field in PLAN_TIMES.items():
        codes = Sdf.TimeCodeArray([float(code) for code in 30.0 * getattr(plan, field)])
        kind = Sdf.ValueTypeNames.TimeCodeArray
        prim.CreateAttribute(f"usdfoot:plan:{event}Times", kind, False, Sdf.VariabilityUniform).Set(codes)


Samples = list[tuple[str, str, Sdf.ValueTypeName, list[float], list[object]]]


def _read_samples(folder: Path) -> Samples:
    """Prim, name, type, codes and values of every time-sampled attribute of a written crowd."""
    samples: Samples = []
    for path in sorted((*folder.glob("anims.*.usdc"), *folder.glob("agents*.usdc"))):
        layer = Sdf.Layer.FindOrOpen(os.fspath(path))

        def visit(path: Sdf.Path, layer: Sdf.Layer = layer) -> None:
            codes = layer.ListTimeSamplesForPath(path) if path.IsPropertyPath() else []
            if codes:
                kind = layer.GetAttributeAtPath(path).typeName
                values = [layer.QueryTimeSample(path, code) for code in codes]
                samples.append((str(path.GetPrimPath()), path.name, kind, list(codes), values))

        layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    return samples


def _author(samples: Samples, path: Path) -> None:
    """Author the samples into a new layer and save it."""
    layer = Sdf.Layer.CreateNew(os.fspath(path))
    with Sdf.ChangeBlock():
        for prim_path, name, kind, codes, values in samples:
            prim = Sdf.CreatePrimInLayer(layer, prim_path)
            prim.specifier = Sdf.SpecifierDef
            attribute = Sdf.AttributeSpec(prim, name, kind)
            for code, value in zip(codes, values, strict=True):
                layer.SetTimeSample(attribute.path, code, value)
    layer.Save()
