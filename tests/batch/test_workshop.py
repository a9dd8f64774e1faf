"""Workers open and list a scene before they are told what to make of it, once as long as its files stay as they are."""

from dataclasses import replace
from pathlib import Path

import pytest

from tests.batch.conftest import AGENTS, delay_plan, write_crowd_scene
from tests.digests import digests
from usdfoot.batch import analysed, workshop
from usdfoot.batch.analysed import forget_examples
from usdfoot.batch.tasks import EarlyTask, cut_chunks, early_task, inputs_of
from usdfoot.bridge.tokens import File
from usdfoot.errors import SceneError
from usdfoot.model.limits import DEFAULT_LIMITS
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.animate import animate
from usdfoot.readers.listing import list_scene
from usdfoot.readers.scene import SceneReader


@pytest.fixture
def scene(stages, tmp_path):
    return write_crowd_scene(stages, tmp_path / "scene")


def tasks_of(scene: Path, folder: Path):
    reader = SceneReader(scene, crowd=folder)
    read = reader.read()
    references = [(str(scene), character.path) for character in read.characters]
    options = MotionOptions()
    return cut_chunks(
        read, references, names=reader.names, folder=folder, options=options, limits=DEFAULT_LIMITS, size=1
    )


def test_what_a_worker_listed_early_is_what_its_chunks_are_made_from(scene, tmp_path, monkeypatch):
    tasks = tasks_of(scene, tmp_path / "out")
    listed = []
    monkeypatch.setattr(workshop, "list_scene", lambda *given, **how: listed.append(given) or list_scene(*given, **how))
    workshop.open_early(early_task(tasks[0]))
    for task in tasks:
        workshop.make_chunk(task)
    assert len(tasks) == AGENTS and listed == [(str(scene),)]


def test_a_worker_lists_a_scene_again_that_changed_after_it_was_opened_early(scene, worker, tmp_path):
    listed = list_scene(scene)
    early = EarlyTask(
        scene=str(scene),
        inputs=inputs_of(listed.info.layers, tmp_path / "out"),
        options=MotionOptions(),
        limits=DEFAULT_LIMITS,
        folder=str(tmp_path / "out"),
        chunk_size=1,
        agents=tuple(source.name for source in listed.chosen),
    )
    worker.submit(workshop.open_early, early).result()
    delay_plan(scene, 1, 3.0)
    animate(scene, tmp_path / "out", chunk_size=1, executor=worker)
    animate(scene, tmp_path / "fresh", chunk_size=1)
    made, fresh = digests(tmp_path / "out"), digests(tmp_path / "fresh")
    assert {name for name in fresh if fresh[name] != made[name]} <= {File.OVERRIDES}


def test_what_a_worker_analysed_early_is_not_analysed_for_its_chunks(scene, tmp_path, monkeypatch):
    tasks = tasks_of(scene, tmp_path / "out")
    forget_examples()
    workshop.open_early(early_task(tasks[0]))
    assert not (tmp_path / "out").exists()
    monkeypatch.setattr(analysed, "build_examples", None)
    assert [workshop.make_chunk(task).kept_agents for task in tasks] == [0] * AGENTS


def test_what_one_process_cut_of_the_clips_another_neither_cuts_nor_writes_otherwise(scene, tmp_path, monkeypatch):
    tasks = [replace(task, keeps_examples=True) for task in tasks_of(scene, tmp_path / "out")]
    early = replace(early_task(tasks[0]), gives_examples=True)
    given = workshop.open_early(early)
    assert len(given) == 1 and not (tmp_path / "out").exists() and not workshop.open_early(early_task(tasks[0]))
    forget_examples()
    monkeypatch.setattr(analysed, "build_examples", None)
    own = workshop.Workshop(
        SceneReader(scene, crowd=tmp_path / "out"), MotionOptions(), keep=tmp_path / "out", given=lambda: given
    )
    assert [own.make(task).kept_agents for task in tasks] == [0] * AGENTS
    assert {name: (tmp_path / "out" / name).read_bytes() for name in given} == given
    assert not workshop.open_early(early), "it is there already"


def test_a_worker_that_cannot_open_a_scene_early_tells_it_with_the_chunk(scene, tmp_path):
    task = replace(tasks_of(scene, tmp_path / "out")[0], agents=("Nobody",))
    with pytest.raises(SceneError):
        workshop.open_early(early_task(task))
    with pytest.raises(SceneError):
        workshop.make_chunk(task)
