"""Shot: a scene as read, cut into chunks, and how these are made."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from usdfoot.batch.executors import Starting, examples_of, open_scene_early
from usdfoot.batch.records import ChunkRecord, kept_record, parse_record
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.provenance import CallRecord
from usdfoot.pipeline.unchanged import EarlierCrowd
from usdfoot.readers.chunks import is_intact, read_record
from usdfoot.readers.stage import has_marked, identifier_of, is_as_saved, layers_of

if TYPE_CHECKING:  # imported where something is to be made: that takes longer than to find that nothing is
    from usdfoot.batch.tasks import ChunkTask
    from usdfoot.batch.workshop import Workshop
    from usdfoot.bridge.scene import Scene
    from usdfoot.readers.scene import SceneReader
    from usdfoot.writers.crowd import CrowdWriter
    from usdfoot.writers.placing import PlacedCharacter

__all__ = ["Shot", "make_chunks", "open_shot"]

FEW_CHUNKS = 3
"""So many chunks are made without workers, whose start takes as long; else they open the scene while it is read."""


@dataclass(frozen=True, kw_only=True)
class Shot:
    """A scene as read, and the chunks to make of it."""

    reader: SceneReader
    scene: Scene
    folder: Path
    options: MotionOptions
    characters: Sequence[PlacedCharacter]
    tasks: Sequence[ChunkTask]
    starting: Sequence[Starting]
    """Workers who open the scene already."""

    @cached_property
    def workshop(self) -> Workshop:
        """Of this process, loaded when it is asked for: workers begin meanwhile."""
        from usdfoot.batch.workshop import Workshop

        return Workshop(self.reader, self.options, keep=self.keep, given=lambda: examples_of(self.starting))

    @property
    def keep(self) -> Path | None:
        """Folder in which the clips' analysis is kept; None = the crowd is too small for that."""
        return self.folder if any(task.keeps_examples for task in self.tasks) else None


def open_shot(
    stage: Any, folder: Path, call: CallRecord, *, options: MotionOptions, executor: Executor | None = None
) -> Shot:
    """What is asked for of an open stage, read and cut into chunks; folder: of the crowd, a real path."""
    from usdfoot.batch.tasks import EarlyTask, agents_a_chunk, cut_chunks, inputs_of
    from usdfoot.readers.listing import list_scene

    starting: list[Starting] = []
    many = 2 * FEW_CHUNKS * call.chunk_size  # an agent and its plan are two prims
    if executor and is_as_saved(stage) and call.agents == "*" and has_marked(stage, more_than=many):
        early = EarlyTask(
            scene=identifier_of(stage.GetRootLayer()),
            inputs=inputs_of(layers_of(stage), folder),
            options=options,
            limits=call.limits,
            folder=str(folder),
            chunk_size=call.chunk_size,
        )
        starting = open_scene_early(executor, early)
    listed = list_scene(stage, agents=call.agents, limits=call.limits)
    from usdfoot.batch.analysed import build_once
    from usdfoot.readers.scene import SceneReader
    from usdfoot.writers.crowd import check_output, crowd_format
    from usdfoot.writers.placing import place_characters

    reader = SceneReader(
        listed,
        frames=call.frames,
        motion=options.motion,
        tuning=options.tuning,
        crowd=folder,
        limits=call.limits,
        sampling=options.sampling,
        build=build_once,
    )
    scene = reader.read()
    check_output(scene, folder)
    characters = place_characters(
        scene.characters, folder, layer_format=crowd_format(scene), collect=call.collect, levels=call.levels
    )
    references = [(placed.reference.assetPath, str(placed.reference.primPath)) for placed in characters]
    tasks = cut_chunks(
        *(scene, references),
        names=reader.names,
        folder=folder,
        options=options,
        limits=call.limits,
        size=agents_a_chunk(call.chunk_size, frames=reader.frame_count),
    )
    return Shot(
        reader=reader,
        scene=scene,
        folder=folder,
        options=options,
        characters=characters,
        tasks=tasks,
        starting=starting,
    )


def make_chunks(
    shot: Shot,
    crowd: CrowdWriter,
    *,
    earlier: EarlierCrowd,
    executor: Executor | None,
    beside: bool,
    progress: Callable[[str, int, int], None],
) -> tuple[ChunkRecord, ...]:
    """Records of all chunks, kept or made, which the crowd gets as they come."""
    from usdfoot.batch.earlier import find_agents, with_earlier
    from usdfoot.batch.running import run_chunks
    from usdfoot.batch.tasks import early_task

    tasks = shot.tasks
    records = [_kept_record(task, shot.folder, earlier) for task in tasks]
    pending = [index for index, record in enumerate(records) if record is None]
    settled = [task.files for task, record in zip(tasks, records, strict=True) if record is not None]
    made_before = find_agents(shot.folder, intact=earlier.intact, kept=settled) if pending else {}
    tasks = [with_earlier(task, made_before) for task in tasks]
    few = FEW_CHUNKS if beside else 1
    executor = executor if len(pending) > few and shot.scene.stage.as_saved else None  # workers open the file
    if executor and beside and not shot.starting:
        shot = replace(shot, starting=open_scene_early(executor, early_task(tasks[pending[0]])))
    made = run_chunks(
        [tasks[index] for index in pending],
        lambda task: shot.workshop.make(task),
        executor=executor,
        starting=shot.starting if beside else None,
    )
    progress("animate", 0, len(pending))
    added = 0
    for done, (index, chunk) in enumerate(made):
        records[pending[index]] = parse_record(chunk.record, kept_agents=chunk.kept_agents)
        progress("animate", done + 1, len(pending))
        added = _add_chunks(crowd, tasks, records, since=added)
    _add_chunks(crowd, tasks, records, since=added)
    return tuple(record for record in records if record is not None)


def _add_chunks(
    crowd: CrowdWriter, tasks: Sequence[ChunkTask], records: Sequence[ChunkRecord | None], *, since: int
) -> int:
    """Adds chunks to the crowd up to the first that is not there yet, whose index it gives back."""
    for task, record in zip(tasks[since:], records[since:], strict=True):
        if record is None:
            break
        if record.agents:
            crowd.add_chunk(task.files)
        since += 1
    return since


def _kept_record(task: ChunkTask, folder: Path, earlier: EarlierCrowd) -> ChunkRecord | None:
    """Of a chunk that is there already, by the crowd's report or by itself; None if it is to be made."""
    known = earlier.records.get(task.files.anims)
    if known and is_intact(folder, task.files, earlier.intact or ()):  # its files say the same
        return known if known.content_hash == task.content_hash else None
    return kept_record(read_record(folder, task.files, task.content_hash, intact=earlier.intact))
