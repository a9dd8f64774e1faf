"""Animate: a scene's footsteps become a crowd on disk."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from usdfoot.batch.entries import EntryResults
from usdfoot.batch.records import NOBODY, ChunkRecord, kept_record, parse_record
from usdfoot.errors import OutputError, SceneError
from usdfoot.model.levels import DetailLevels
from usdfoot.model.limits import DEFAULT_LIMITS, Limits
from usdfoot.model.report import Problem
from usdfoot.model.totals import add_totals
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.provenance import CHUNK_SIZE, CallRecord, provenance_of
from usdfoot.pipeline.report import AnimateReport, report_json
from usdfoot.pipeline.shot import make_chunks, open_shot
from usdfoot.pipeline.unchanged import find_earlier
from usdfoot.readers.chunks import read_record
from usdfoot.readers.stage import open_stage
from usdfoot.writers.folder_lock import lock_folder
from usdfoot.writers.paths import folder_path

__all__ = ["animate", "animate_chunk", "count_chunks"]


def animate(
    scene_file: str | os.PathLike[str],
    folder: str | os.PathLike[str],
    *,
    agents: str | Sequence[str] = "*",
    frames: tuple[int, int] | None = None,
    options: MotionOptions | None = None,
    collect: bool = False,
    levels: DetailLevels | None = None,
    chunk_size: int = CHUNK_SIZE,
    limits: Limits = DEFAULT_LIMITS,
    executor: Executor | None = None,
    beside: bool = False,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> AnimateReport:
    """Read a scene, animate its agents, write the crowd (design.md sections 2 and 3).

    An agent that cannot be animated is reported and skipped; the crowd goes on. Chunks of agents that an earlier run
    made from the same scene, clips, characters and options are kept, and of the other chunks the agents that were.

    Args:
        scene_file: The USD scene, or an open stage; never changed.
        folder: Where crowd.usd and its layers go.
        agents: Glob on agents' names or paths, or several.
        frames: First and last time code to write; None = all of the plans.
        options: Of the sources of motion.
        collect: Copy the characters' files into the folder.
        levels: Of detail (UsdLod), for characters that have such variants.
        chunk_size: Agents a chunk, fewer where the shot is long; a worker has no more than one chunk in memory.
        limits: How much of a scene is read before it is refused.
        executor: Whose workers make the chunks, if there are several and the scene is saved; None = this process does.
        beside: Whether this process makes chunks beside the executor's workers, and a few without them.
        progress: Told what begins or goes on, how much of it is done, and of how much: "read", "animate", "write".

    Returns:
        What was written, what was kept and what was skipped.

    Raises:
        SceneError: If the scene cannot be opened or no agent can be used.
        OutputError: If the folder cannot be written to, another run is writing into it, the output would replace the
            input, or a worker vanished.
    """
    progress("read", 0, 0)
    stage, target = open_stage(scene_file), folder_path(folder)
    options = (options or MotionOptions()).at_rate(stage.GetTimeCodesPerSecond())
    call = CallRecord(
        agents=agents, frames=frames, chunk_size=chunk_size, collect=collect, levels=levels, limits=limits
    )
    with lock_folder(target):
        return _animate(stage, target, call, options=options, executor=executor, beside=beside, progress=progress)


def _animate(
    stage: Any,
    folder: Path,
    call: CallRecord,
    *,
    options: MotionOptions,
    executor: Executor | None,
    beside: bool,
    progress: Callable[[str, int, int], None],
) -> AnimateReport:
    """What is asked for of an open stage, in a folder that nobody else writes into; otherwise as `animate`."""
    earlier = find_earlier(stage, folder, options=options, call=call)
    if earlier.unchanged:
        return earlier.unchanged
    shot = open_shot(stage, folder, call, options=options, executor=None if earlier.is_there else executor)
    from usdfoot.batch.analysed import tidy_examples
    from usdfoot.writers.crowd import open_crowd

    with open_crowd(shot.scene, shot.folder, intact=earlier.intact or {}) as crowd:
        records = make_chunks(shot, crowd, earlier=earlier, executor=executor, beside=beside, progress=progress)
        found = (*shot.scene.crowd.problems, *(problem for record in records for problem in record.problems))
        _require_agents(shot.scene.stage.identifier, records, problems := _distinct(found))
        progress("write", 0, 0)
        report = report_json(shot.scene, records, options=shot.options, problems=problems, folder=shot.folder)
        crowd_file, report_file = crowd.finish(
            [agent.name for record in records for agent in record.agents],
            characters=shot.characters,
            collect=call.collect,
            provenance=provenance_of(shot.scene, shot.options, shot.folder, call=call, inputs=report["inputs"]),
            report=report,
        )
    tidy_examples(shot.folder, shot.scene.crowd.libraries if shot.keep else (), samples=options.samples)
    return AnimateReport(
        crowd_file=crowd_file,
        report_file=report_file,
        results=EntryResults(agent for record in records for agent in record.agents),
        totals=add_totals(record.totals for record in records),
        problems=problems,
        chunks=len(records),
        kept=sum(record.is_kept for record in records),
        kept_agents=sum(record.kept_agents for record in records),
    )


def animate_chunk(
    scene_file: str | os.PathLike[str],
    folder: str | os.PathLike[str],
    index: int,
    *,
    agents: str | Sequence[str] = "*",
    frames: tuple[int, int] | None = None,
    options: MotionOptions | None = None,
    collect: bool = False,
    levels: DetailLevels | None = None,
    chunk_size: int = CHUNK_SIZE,
    limits: Limits = DEFAULT_LIMITS,
) -> ChunkRecord:
    """One chunk of what `animate` with the same arguments makes, which then keeps it: the task of a render farm.

    Args:
        scene_file: The USD scene; never changed.
        folder: Where crowd.usd will be.
        index: Of the chunk.
        agents: As of `animate`.
        frames: As of `animate`.
        options: As of `animate`.
        collect: As of `animate`.
        levels: As of `animate`.
        chunk_size: As of `animate`.
        limits: As of `animate`.

    Raises:
        SceneError: If the scene cannot be opened, no agent can be used, or there is no such chunk.
        OutputError: If the folder cannot be written to, `animate` is writing into it, or the output would replace the
            input.
    """
    from usdfoot.batch.earlier import find_agents, with_earlier
    from usdfoot.batch.tasks import agents_a_chunk

    stage, target = open_stage(scene_file), folder_path(folder)
    options = (options or MotionOptions()).at_rate(stage.GetTimeCodesPerSecond())
    call = CallRecord(
        agents=agents, frames=frames, chunk_size=chunk_size, collect=collect, levels=levels, limits=limits
    )
    with lock_folder(target, is_shared=True):
        shot = open_shot(stage, target, call, options=options)
        count = len(range(0, len(shot.reader.names), agents_a_chunk(chunk_size, frames=shot.reader.frame_count)))
        if not 0 <= index < count:
            raise SceneError(scene_file, f"has no chunk {index}", f"give one of 0 to {count - 1}")
        task = next((task for task in shot.tasks if task.index == index), None)
        if task is None:
            return NOBODY
        kept = kept_record(read_record(shot.folder, task.files, task.content_hash))
        if kept is not None:
            return kept
        task = with_earlier(task, find_agents(shot.folder))
        made = shot.workshop.make(task)
        return parse_record(made.record, kept_agents=made.kept_agents)


def count_chunks(
    scene_file: str | os.PathLike[str],
    *,
    agents: str = "*",
    frames: tuple[int, int] | None = None,
    chunk_size: int = CHUNK_SIZE,
    motion: str | None = None,
    limits: Limits = DEFAULT_LIMITS,
) -> int:
    """How many chunks `animate` with the same arguments makes.

    Raises:
        SceneError: If the scene cannot be opened or the glob matches nobody.
    """
    from usdfoot.batch.tasks import agents_a_chunk
    from usdfoot.readers.scene import SceneReader

    reader = SceneReader(scene_file, agents=agents, frames=frames, motion=motion, limits=limits)
    return len(range(0, len(reader.names), agents_a_chunk(chunk_size, frames=reader.frame_count)))


def _distinct(problems: Iterable[Problem]) -> tuple[Problem, ...]:
    """Problems in order, each once: chunks that share clips share their problems."""
    return tuple(dict.fromkeys(problems))


def _require_agents(
    scene_file: str | os.PathLike[str], records: Sequence[ChunkRecord], problems: Sequence[Problem]
) -> None:
    """Raises OutputError if there is nothing to write."""
    if not any(record.agents for record in records):
        reasons = [problem.message for problem in problems if problem.severity == "error"]
        raise OutputError(scene_file, "nothing is written, as no agent could be animated", names=reasons)
