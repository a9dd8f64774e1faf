"""A crowd of people on the stepping stones, one after the other, and the crowd made of it in one process."""

from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from tests.few_clips import write_few_clips_scene
from usdfoot.pipeline.animate import animate

AGENTS = 3


def write_crowd_scene(stages: Path, folder: Path) -> Path:
    """The stepping stones, walked by AGENTS people half a metre apart, on level ground."""
    path = write_few_clips_scene(stages, folder)
    stage = Usd.Stage.Open(str(path))
    stage.GetPrimAtPath("/World/Terrain").SetActive(False)
    walker = stage.GetPrimAtPath("/World/Walker")
    cast = {name: walker.GetRelationship(f"usdfoot:agent:{name}").GetTargets() for name in ("character", "clips")}
    walker.SetActive(False)
    for number in range(AGENTS):
        plan = stage.DefinePrim(f"/World/Crowd/Plan_{number}")
        plan.GetReferences().AddInternalReference("/World/Plans/Stones")
        UsdGeom.Xformable(plan).AddTranslateOp(opSuffix="row").Set(Gf.Vec3d(0.5 * number, 0.0, 0.0))
        agent = UsdGeom.Xform.Define(stage, f"/World/Crowd/Agent_{number}").GetPrim()
        agent.AddAppliedSchema("UsdfootAgentAPI")
        for name, targets in (*cast.items(), ("plan", [plan.GetPath()])):
            agent.CreateRelationship(f"usdfoot:agent:{name}", custom=False).SetTargets(targets)
    stage.Save()
    return path


def delay_plan(scene: Path, number: int, codes: float) -> None:
    """Retime one agent's plan, as an artist would: a stronger opinion on its times."""
    stage = Usd.Stage.Open(str(scene))
    stage.Reload()
    plan = stage.GetPrimAtPath(f"/World/Crowd/Plan_{number}")
    for name in ("strikeTimes", "liftoffTimes"):
        attribute = plan.GetAttribute(f"usdfoot:plan:{name}")
        attribute.Set(Sdf.TimeCodeArray([Sdf.TimeCode(float(code) + codes) for code in attribute.Get()]))
    stage.Save()


@pytest.fixture(scope="session")
def crowd_scene(stages, tmp_path_factory):
    """Not to be changed."""
    return write_crowd_scene(stages, tmp_path_factory.mktemp("crowd"))


@pytest.fixture(scope="session")
def crowd(crowd_scene, tmp_path_factory):
    """Report of the crowd, each agent a chunk, made in this process."""
    return animate(crowd_scene, tmp_path_factory.mktemp("made") / "out", chunk_size=1)


@pytest.fixture
def shot(stages, tmp_path):
    """A crowd that has been made, its scene and its folder."""
    scene = write_crowd_scene(stages, tmp_path / "scene")
    animate(scene, tmp_path / "out", chunk_size=1)
    return scene, tmp_path / "out"


@pytest.fixture(scope="session")
def pairs(crowd_scene, tmp_path_factory):
    """Report of the crowd in chunks of two agents, made in this process."""
    return animate(crowd_scene, tmp_path_factory.mktemp("pairs") / "out", chunk_size=2)


@pytest.fixture(scope="session")
def worker() -> Iterator[Executor]:
    """A worker in a process of its own."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as executor:
        yield executor
