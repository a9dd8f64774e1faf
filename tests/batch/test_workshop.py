"""Workers open and list a scene before they are told what to make of it, once as long as its files stay as they are."""

from pathlib import Path

import pytest

from tests.batch.conftest import AGENTS, delay_plan, digests, write_crowd_scene
from usdfoot.batch import workshop
from usdfoot.batch.tasks import cut_chunks, inputs_of
from usdfoot.bridge.tokens import File
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
    workshop.open_early(tasks[0].scene, tasks[0].inputs, DEFAULT_LIMITS)
    for task in tasks:
        workshop.make_chunk(task)
    assert len(tasks) == AGENTS and listed == [(str(scene),)]


def test_a_worker_lists_a_scene_again_that_changed_after_it_was_opened_early(scene, worker, tmp_path):
    inputs = inputs_of(list_scene(scene).info, tmp_path / "out")
    worker.submit(workshop.open_early, str(scene), inputs, DEFAULT_LIMITS).result()
    delay_plan(scene, 1, 3.0)
    animate(scene, tmp_path / "out", chunk_size=1, executor=worker)
    animate(scene, tmp_path / "fresh", chunk_size=1)
    made, fresh = digests(tmp_path / "out"), digests(tmp_path / "fresh")
    assert {name for name in fresh if fresh[name] != made[name]} <= {File.OVERRIDES}
