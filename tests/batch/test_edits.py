"""Whatever is edited between runs, in scene or crowd: the crowd has the bytes of one made from nothing."""

import os
import shutil

from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd, UsdGeom

from tests.batch.conftest import AGENTS, delay_plan, write_crowd_scene
from tests.digests import digests
from usdfoot.bridge.tokens import File
from usdfoot.errors import UsdfootError
from usdfoot.pipeline.animate import animate

numbers = st.integers(0, AGENTS - 1)


def toggle(scene, path):
    stage = Usd.Stage.Open(str(scene))
    prim = stage.GetPrimAtPath(path)
    prim.SetActive(not prim.IsActive())
    stage.Save()


def move_plan(scene, number, aside):
    stage = Usd.Stage.Open(str(scene))
    plan = UsdGeom.Xformable(stage.GetPrimAtPath(f"/World/Crowd/Plan_{number}"))
    plan.GetOrderedXformOps()[0].Set(Gf.Vec3d(0.5 * number + aside, 0.0, 0.0))
    stage.Save()


def say_of_agent(scene, number, name, value):
    stage = Usd.Stage.Open(str(scene))
    kind = Sdf.ValueTypeNames.Token if isinstance(value, str) else Sdf.ValueTypeNames.Float
    stage.GetPrimAtPath(f"/World/Crowd/Agent_{number}").CreateAttribute(name, kind, custom=False).Set(value)
    stage.Save()


def override(folder, number):
    """Mutes an agent, or has it back."""
    layer = Sdf.Layer.FindOrOpen(str(folder / File.OVERRIDES))
    prim = Sdf.CreatePrimInLayer(layer, f"/Crowd/Agents/Agent_{number}")
    prim.active = not prim.active
    layer.Save()


def files_of(folder):
    return sorted(path for path in folder.rglob("*.*") if path.is_file() and path.name != File.OVERRIDES)


def damage(folder, number, *, is_old):
    """Takes the end of one of the crowd's files, whose time may stay what it was."""
    paths = files_of(folder)
    path = paths[number % len(paths)]
    status = path.stat()
    path.write_bytes(path.read_bytes()[:-100])
    if is_old:
        os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


def swap(folder):
    """Puts the animations of each of two chunks where the other's are."""
    one, other = (folder / f"anims.{number:04d}.usdc" for number in (0, 1))
    if one.exists() and other.exists():
        one.rename(folder / "third")
        other.rename(one)
        (folder / "third").rename(other)


edits = st.one_of(
    st.builds(
        lambda k, codes: lambda scene, _: delay_plan(scene, k, codes), numbers, st.sampled_from([-1.0, 0.5, 3.0])
    ),
    st.builds(lambda k, aside: lambda scene, _: move_plan(scene, k, aside), numbers, st.sampled_from([0.0, 0.25])),
    st.builds(
        lambda k, said: lambda scene, _: say_of_agent(scene, k, *said),
        numbers,
        st.sampled_from([("usdfoot:agent:rootWeight", 0.5), ("usdfoot:agent:motion", "physics")]),
    ),
    st.builds(lambda k: lambda scene, _: toggle(scene, f"/World/Crowd/Agent_{k}"), numbers),
    st.builds(lambda k: lambda _, folder: override(folder, k), numbers),
    st.builds(lambda k, is_old: lambda _, folder: damage(folder, k, is_old=is_old), st.integers(0, 20), st.booleans()),
    st.sampled_from(
        [
            lambda scene, _: toggle(scene, "/World/Terrain"),
            lambda scene, _: toggle(scene, "/World/Library/Motion/Clips/walk_090"),
            lambda _, folder: swap(folder),
        ]
    ),
)


def outcome(scene, folder):
    """Bytes of the crowd's files, or why it cannot be made."""
    try:
        animate(scene, folder, chunk_size=2)
    except UsdfootError as error:
        return error.what
    return digests(folder)


@settings(max_examples=4)
@given(st.lists(st.lists(edits, min_size=1, max_size=2), min_size=2, max_size=3))
def test_a_crowd_made_again_after_any_edits_is_as_new(stages, tmp_path_factory, rounds):
    place = tmp_path_factory.mktemp("edits")
    scene, folder = write_crowd_scene(stages, place / "scene"), place / "out"
    animate(scene, folder, chunk_size=2)
    for edited in rounds:
        for edit in edited:
            edit(scene, folder)
        fresh = folder.with_name("fresh")
        shutil.rmtree(fresh, ignore_errors=True)
        fresh.mkdir()
        shutil.copyfile(folder / File.OVERRIDES, fresh / File.OVERRIDES)
        again = outcome(scene, folder)
        assert again == outcome(scene, fresh)
        if not isinstance(again, dict):
            return
