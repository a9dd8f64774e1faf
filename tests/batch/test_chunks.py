"""A crowd in chunks: the same bytes whoever makes them, and only what changed is made again."""

import io
import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest
from pxr import Sdf, Usd

from tests.batch.conftest import AGENTS, delay_plan, write_crowd_scene
from tests.digests import digests
from usdfoot.analysis.examples import build_examples
from usdfoot.batch.analysed import KeptExamples, build_once, forget_examples
from usdfoot.batch.workshop import Workshop
from usdfoot.bridge.chunk_files import chunk_files
from usdfoot.bridge.tokens import File
from usdfoot.errors import OutputError
from usdfoot.model.hashing import content_hash
from usdfoot.pipeline.animate import animate, animate_chunk, count_chunks
from usdfoot.pipeline.validate import validate
from usdfoot.readers.scene import SceneReader
from usdfoot.writers.crowd import CrowdWriter


def command(*arguments):
    """The command line in a process of its own."""
    return [sys.executable, "-m", "usdfoot.cli.main", *map(str, arguments)]


def test_every_chunk_is_a_layer_and_the_crowd_is_whole(crowd):
    folder = crowd.crowd_file.parent
    stage = Usd.Stage.Open(str(crowd.crowd_file))
    names = [f"Agent_{number}" for number in range(AGENTS)]
    for number, name in enumerate(names):
        layer = Sdf.Layer.FindOrOpen(str(folder / f"anims.{number:04d}.usdc"))
        assert [prim.name for prim in layer.GetPrimAtPath("/Crowd/Anims").nameChildren] == [name]
    for scope in ("Agents", "Anims", "Plans"):
        assert sorted(prim.GetName() for prim in stage.GetPrimAtPath(f"/Crowd/{scope}").GetChildren()) == names
    assert sorted(crowd.results) == names and crowd.chunks == AGENTS and crowd.kept == 0
    assert not (folder / File.PENDING).exists()
    report = json.loads(crowd.report_file.read_text())
    assert {name for name in report["files"] if name.startswith("anims.0")} == {
        f"anims.{number:04d}.usdc" for number in range(AGENTS)
    }
    assert validate(crowd.crowd_file).passed


def test_long_shots_have_fewer_agents_a_chunk(crowd_scene, crowd, tmp_path, monkeypatch):
    frames = SceneReader(crowd_scene).frame_count
    monkeypatch.setattr("usdfoot.batch.tasks.FRAMES_AT_ONCE", 2 * frames - 1)
    assert count_chunks(crowd_scene) == AGENTS
    assert len(animate_chunk(crowd_scene, tmp_path / "out", AGENTS - 1).agents) == 1
    report = animate(crowd_scene, tmp_path / "out")
    assert (report.chunks, report.kept) == (AGENTS, 1) and sorted(report.results) == sorted(crowd.results)


def test_one_chunk_has_the_agents_of_many(crowd, crowd_scene, tmp_path):
    whole = animate(crowd_scene, tmp_path / "out")
    opened = [Usd.Stage.Open(str(report.crowd_file)) for report in (crowd, whole)]
    names, several = ({path.name for path in report.crowd_file.parent.glob("*.usdc")} for report in (whole, crowd))
    assert names == {"agents.usdc", "footsteps.usdc", "anims.0000.usdc"}
    assert several == {"agents.usdc", "footsteps.usdc", *(f"anims.{number:04d}.usdc" for number in range(AGENTS))}
    for name in ("agents.usdc", "footsteps.usdc"):
        assert not Sdf.Layer.FindOrOpen(str(crowd.crowd_file.parent / name)).subLayerPaths
    for scope in ("Agents", "Anims", "Plans"):
        for name in crowd.results:
            specs = []
            for stage in opened:
                prim = stage.GetPrimAtPath(f"/Crowd/{scope}/{name}")
                layer = Sdf.Layer.CreateAnonymous(".usda")
                source = next(spec for spec in prim.GetPrimStack() if spec.specifier == Sdf.SpecifierDef)
                Sdf.CopySpec(source.layer, source.path, layer, "/Copy")
                specs.append(layer.ExportToString())
            assert specs[0] == specs[1]


def test_processes_make_the_same_bytes(crowd, crowd_scene, worker, tmp_path, monkeypatch):
    monkeypatch.setattr("usdfoot.pipeline.shot.FEW_CHUNKS", 1)
    done = []
    animate(
        *(crowd_scene, tmp_path / "out"),
        chunk_size=1,
        executor=worker,
        beside=True,
        progress=lambda part, count, total: done.append(count) if part == "animate" else None,
    )
    assert done == list(range(AGENTS + 1))
    assert digests(tmp_path / "out") == digests(crowd.crowd_file.parent)


def test_chunks_are_joined_while_others_are_made(crowd_scene, tmp_path, monkeypatch):
    happened, add_chunk, make = [], CrowdWriter.add_chunk, Workshop.make

    def adding(self, chunk):
        happened.append(f"added {chunk.anims}")
        return add_chunk(self, chunk)

    def making(self, task):
        assert all(name.startswith((File.PENDING, File.EXAMPLES)) for name in digests(tmp_path / "out"))
        happened.append(f"made {task.files.anims}")
        return make(self, task)

    monkeypatch.setattr(CrowdWriter, "add_chunk", adding)
    monkeypatch.setattr(Workshop, "make", making)
    animate(crowd_scene, tmp_path / "out", chunk_size=1)
    names = [chunk_files(index, AGENTS).anims for index in range(AGENTS)]
    assert happened == [what for name in names for what in (f"made {name}", f"added {name}")]


def test_only_the_chunk_of_a_changed_plan_is_made_again(stages, tmp_path):
    scene = write_crowd_scene(stages, tmp_path / "scene")
    first = animate(scene, tmp_path / "out", chunk_size=1)
    before = digests(tmp_path / "out")
    assert animate(scene, tmp_path / "out", chunk_size=1).kept == AGENTS
    assert digests(tmp_path / "out") == before
    delay_plan(scene, 1, 3.0)
    again = animate(scene, tmp_path / "out", chunk_size=1)
    assert again.kept == AGENTS - 1 and sorted(again.results) == sorted(first.results)
    changed = {name for name, digest in digests(tmp_path / "out").items() if digest != before[name]}
    assert {name for name in changed if name.startswith("anims")} >= {"anims.0001.usdc"}
    assert not changed & {"anims.0000.usdc", "anims.0002.usdc", ".chunks/agents.0000.usdc"}
    animate(scene, tmp_path / "fresh", chunk_size=1)
    fresh, kept = digests(tmp_path / "fresh"), digests(tmp_path / "out")
    assert {name for name in fresh if fresh[name] != kept[name]} <= {File.OVERRIDES}


def test_of_a_chunk_with_a_changed_agent_the_others_are_kept(stages, tmp_path):
    scene = write_crowd_scene(stages, tmp_path / "scene")
    animate(scene, tmp_path / "out")
    delay_plan(scene, 0, 3.0)
    again = animate(scene, tmp_path / "out")
    assert (again.kept, again.kept_agents) == (0, AGENTS - 1)
    animate(scene, tmp_path / "fresh")
    fresh, kept = digests(tmp_path / "fresh"), digests(tmp_path / "out")
    assert {name for name in fresh if fresh[name] != kept[name]} <= {File.OVERRIDES}


def test_agents_are_found_in_the_chunks_of_a_crowd_that_was_cut_otherwise(crowd_scene, pairs, tmp_path):
    animate(crowd_scene, tmp_path / "out", agents="Agent_[12]")
    again = animate(crowd_scene, tmp_path / "out", chunk_size=2)
    assert (again.kept, again.kept_agents) == (0, AGENTS - 1)
    fresh, kept = digests(pairs.crowd_file.parent), digests(tmp_path / "out")
    assert {name for name in fresh if fresh[name] != kept[name]} <= {File.OVERRIDES}


def test_other_options_make_every_chunk_again_and_a_smaller_crowd_leaves_no_chunks_behind(stages, crowd, tmp_path):
    scene = write_crowd_scene(stages, tmp_path / "scene")
    animate(scene, tmp_path / "out", chunk_size=1)
    report = animate(scene, tmp_path / "out", chunk_size=2)
    assert report.kept == 0 and report.chunks == 2
    assert not (tmp_path / "out" / "anims.0002.usdc").exists()
    report = animate(scene, tmp_path / "out", chunk_size=2, agents="Agent_[01]")
    assert report.chunks == 1 and not list((tmp_path / "out").glob("*.0001.usdc"))


def test_a_killed_run_leaves_the_old_crowd_and_the_next_goes_on(stages, crowd, tmp_path):
    scene = write_crowd_scene(stages, tmp_path / "scene")
    animate(scene, tmp_path / "out", agents="Agent_0")
    before = digests(tmp_path / "out")
    arguments = command("animate", scene, "-o", tmp_path / "out", "--workers", 1, "-q", "--chunk-size", 1)
    process = subprocess.Popen(arguments, stdout=subprocess.DEVNULL)
    pending = tmp_path / "out" / File.PENDING
    deadline = time.monotonic() + 120.0
    while not list(pending.glob("anims.*.usdc")) and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.005)
    process.kill()
    process.wait()
    assert process.returncode == -signal.SIGKILL
    assert {n: d for n, d in digests(tmp_path / "out").items() if not n.startswith(File.PENDING)} == before
    report = animate(scene, tmp_path / "out", chunk_size=1)
    assert 1 <= report.kept < AGENTS
    animate(scene, tmp_path / "fresh", chunk_size=1)
    assert digests(tmp_path / "out") == digests(tmp_path / "fresh")


DIES_AT_A_RENAME = """
import os, signal, sys
from usdfoot.pipeline.animate import animate
rename, left = os.replace, int(sys.argv[3])
def replace(source, target):
    global left
    left -= ".pending" not in str(target)  # where chunks wait
    if left == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    rename(source, target)
os.replace = replace
animate(sys.argv[1], sys.argv[2], chunk_size=1)
"""


@pytest.mark.parametrize("renames", [1, 3, 6])
def test_a_run_killed_while_it_renames_leaves_old_and_new_files_and_the_next_mends_all(stages, tmp_path, renames):
    scene, out = write_crowd_scene(stages, tmp_path / "scene"), tmp_path / "out"
    animate(scene, out, chunk_size=1)
    before = digests(out)
    for agent in range(AGENTS):
        delay_plan(scene, agent, 2.0)
    animate(scene, tmp_path / "fresh", chunk_size=1)
    fresh = digests(tmp_path / "fresh")
    script = [sys.executable, "-c", DIES_AT_A_RENAME, str(scene), str(out), str(renames)]
    assert subprocess.run(script, check=False).returncode == -signal.SIGKILL
    found = digests(out)
    assert all(found[name] in (before[name], fresh[name]) for name in before)
    assert Usd.Stage.Open(str(out / File.CROWD)).GetPrimAtPath("/Crowd/Agents").GetChildren()
    animate(scene, out, chunk_size=1)
    assert digests(out) == fresh | {File.OVERRIDES: before[File.OVERRIDES]}


def test_a_crowd_is_whole_where_only_one_of_several_chunks_has_anybody(stages, tmp_path):
    scene = write_crowd_scene(stages, tmp_path / "scene")
    stage = Usd.Stage.Open(str(scene))
    stage.GetPrimAtPath("/World/Crowd/Plan_2").GetAttribute("positions").Set([])
    stage.Save()
    report = animate(scene, tmp_path / "out", chunk_size=2)
    assert list(report.results) == ["Agent_0", "Agent_1"] and report.chunks == 1
    crowd = Usd.Stage.Open(str(report.crowd_file))
    for scope in ("Agents", "Anims", "Plans"):
        assert [prim.GetName() for prim in crowd.GetPrimAtPath(f"/Crowd/{scope}").GetChildren()] == [
            "Agent_0",
            "Agent_1",
        ]


def test_half_a_chunk_is_made_again(stages, tmp_path):
    scene = write_crowd_scene(stages, tmp_path / "scene")
    animate(scene, tmp_path / "out", chunk_size=1)
    before = digests(tmp_path / "out")
    broken = tmp_path / "out" / "anims.0001.usdc"
    broken.write_bytes(broken.read_bytes()[:1000])
    assert animate(scene, tmp_path / "out", chunk_size=1).kept == AGENTS - 1
    assert digests(tmp_path / "out") == before


def test_a_vanished_worker_is_reported_and_the_next_run_goes_on(crowd, crowd_scene, tmp_path):
    with (
        ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=os._exit, initargs=(3,)) as executor,
        pytest.raises(OutputError, match=r"3 of 3 chunks were not made: .*its worker vanished.*run again"),
    ):
        animate(crowd_scene, tmp_path / "out", chunk_size=1, executor=executor)
    animate(crowd_scene, tmp_path / "out", chunk_size=1)
    assert digests(tmp_path / "out") == digests(crowd.crowd_file.parent)


def test_what_workers_do_not_begin_is_made_beside_them(crowd, crowd_scene, tmp_path, monkeypatch):
    monkeypatch.setattr("usdfoot.pipeline.shot.FEW_CHUNKS", 1)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=os._exit, initargs=(3,)) as executor:
        animate(crowd_scene, tmp_path / "out", chunk_size=1, executor=executor, beside=True)
    assert digests(tmp_path / "out") == digests(crowd.crowd_file.parent)


def test_a_full_disk_is_reported_and_the_next_run_goes_on(crowd, crowd_scene, tmp_path):
    resource = pytest.importorskip("resource")

    def little_space():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))

    done = subprocess.run(
        command("animate", crowd_scene, "-o", tmp_path / "out", "--chunk-size", 1, "--workers", 1, "-q"),
        capture_output=True,
        text=True,
        preexec_fn=little_space,
    )
    assert done.returncode == 2 and "cannot be written" in done.stderr, done.stderr
    assert not list((tmp_path / "out").glob("*.usd*"))
    animate(crowd_scene, tmp_path / "out", chunk_size=1)
    assert digests(tmp_path / "out") == digests(crowd.crowd_file.parent)


def test_the_clips_analysis_is_kept_and_what_comes_of_it_is_the_same(crowd_scene, crowd, tmp_path, monkeypatch):
    monkeypatch.setattr("usdfoot.batch.tasks.LARGE_CROWD", 2)
    animate(crowd_scene, tmp_path / "out", chunk_size=2)
    (kept,) = (tmp_path / "out" / File.EXAMPLES).iterdir()
    whole = digests(tmp_path / "out")
    (tmp_path / "out" / "anims.0001.usdc").unlink()
    forget_examples()
    with monkeypatch.context() as patch:
        patch.setattr("usdfoot.batch.analysed.build_examples", None)  # must not be called
        again = animate(crowd_scene, tmp_path / "out", chunk_size=2)
    assert (again.kept, again.kept_agents) == (1, 2) and digests(tmp_path / "out") == whole
    kept.write_bytes(kept.read_bytes()[:-2000])
    (tmp_path / "out" / "anims.0000.usdc").unlink()
    forget_examples()
    animate(crowd_scene, tmp_path / "out", chunk_size=2)
    assert digests(tmp_path / "out") == whole
    animate(crowd_scene, tmp_path / "out")
    assert not (tmp_path / "out" / File.EXAMPLES).exists()


def test_a_process_cuts_the_steps_of_a_library_once_and_those_of_another_anew(crowd_scene):
    (library,), (same,) = (SceneReader(crowd_scene).read().crowd.libraries for _ in range(2))
    fewer = replace(library, clips=library.clips[1:])
    forget_examples()
    examples, problems = build_once(library, samples=33)
    problems.clear()  # a caller's own list
    assert build_once(same, samples=33)[0] is examples
    for other, samples in ((fewer, 33), (library, 17)):
        expected, told = build_examples(other, samples=samples)
        found, problems = build_once(other, samples=samples)
        assert content_hash(found) == content_hash(expected) != content_hash(examples) and problems == told


def test_a_kept_analysis_that_is_damaged_is_made_again(crowd_scene, tmp_path, monkeypatch):
    (library,) = SceneReader(crowd_scene).read().crowd.libraries
    expected = content_hash(KeptExamples(tmp_path).build(library, samples=17)[0])
    (kept,) = (tmp_path / File.EXAMPLES).iterdir()
    whole = kept.read_bytes()
    with np.load(kept, allow_pickle=False) as found:
        arrays = dict(found)

    def packed(**changed):
        stream = io.BytesIO()
        np.savez_compressed(stream, **(arrays | changed))
        return stream.getvalue()

    compressed = bytearray(packed())
    compressed[2000:2100] = b"\xff" * 100
    for damaged in (
        b"",
        whole[:-2000],
        bytes(compressed),
        packed(text=np.array('{"words": [], "problems": []}')),
        packed(landings=np.array([{"pickled": 1}], dtype=object)),
        packed(landings=arrays["landings"][1:]),
        packed(rotations=arrays["rotations"][:, :, 1:]),
    ):
        kept.write_bytes(damaged)
        assert content_hash(KeptExamples(tmp_path).build(library, samples=17)[0]) == expected
        assert kept.read_bytes() == whole
    monkeypatch.setattr("usdfoot.batch.analysed.build_once", None)  # must not be called
    assert content_hash(KeptExamples(tmp_path).build(library, samples=17)[0]) == expected


def test_an_agent_counts_as_kept_only_if_it_could_be_taken(crowd_scene, tmp_path):
    animate(crowd_scene, tmp_path / "out")
    whole = digests(tmp_path / "out")
    (tmp_path / "out" / "footsteps.usdc").unlink()  # the animations still say whom they have
    again = animate(crowd_scene, tmp_path / "out")
    assert (again.kept, again.kept_agents) == (0, 0) and digests(tmp_path / "out") == whole
