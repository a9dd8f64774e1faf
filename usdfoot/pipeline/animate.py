"""Animate: a scene's footsteps become a crowd on disk."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from pathlib import Path

from usdfoot.batch.records import ChunkRecord, parse_record
from usdfoot.batch.running import run_chunks
from usdfoot.batch.tasks import ChunkTask, cut_chunks
from usdfoot.batch.workshop import Workshop
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import OutputError
from usdfoot.model.report import Problem
from usdfoot.pipeline.report import AnimateReport, provenance_of, report_json
from usdfoot.readers.chunks import read_record
from usdfoot.readers.scene import SceneReader
from usdfoot.writers.characters import place_characters
from usdfoot.writers.crowd import check_output, crowd_format, write_crowd

__all__ = ["CHUNK_SIZE", "animate"]

CHUNK_SIZE = 100
"""Agents a chunk unless told otherwise."""


def animate(
    scene_file: str | os.PathLike[str],
    folder: str | os.PathLike[str],
    *,
    agents: str = "*",
    frames: tuple[int, int] | None = None,
    options: EngineOptions | None = None,
    collect: bool = False,
    chunk_size: int = CHUNK_SIZE,
    executor: Executor | None = None,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> AnimateReport:
    """Read a scene, animate its agents, write the crowd (design.md sections 2 and 3).

    An agent that cannot be animated is reported and skipped; the crowd goes on. Chunks of agents that an earlier run
    made from the same scene, clips, characters and options are kept.

    Args:
        scene_file: The USD scene; never changed.
        folder: Where crowd.usd and its layers go.
        agents: Glob on agents' names or paths.
        frames: First and last time code to write; None = all of the plans.
        options: Of the engine.
        collect: Copy the characters' files into the folder.
        chunk_size: Agents a chunk; one worker makes a chunk, and no more than a worker's chunk is in memory.
        executor: Whose workers make the chunks, in this or other processes; None = this process does.
        progress: Told what begins or goes on and how much of it is done: "read", "animate", "write".

    Returns:
        What was written, what was kept and what was skipped.

    Raises:
        SceneError: If the scene cannot be opened or no agent can be used.
        OutputError: If the folder cannot be written to, the output would replace the input, or a worker vanished.
    """
    options = options or EngineOptions()
    target = Path(os.path.realpath(folder))
    progress("read", 0, 0)
    reader = SceneReader(scene_file, agents=agents, frames=frames)
    scene = reader.read()
    check_output(scene, target)
    characters = place_characters(scene.characters, target, layer_format=crowd_format(scene), collect=collect)
    references = [(placed.reference.assetPath, str(placed.reference.primPath)) for placed in characters]
    tasks = cut_chunks(scene, references, folder=target, options=options, size=chunk_size)
    kept = {index: record for index, task in enumerate(tasks) if (record := _kept(target, task))}
    made = _make(tasks, kept, executor or Workshop(reader, options), progress)
    records = [parse_record({**kept, **made}[index]) for index in range(len(tasks))]
    problems = _distinct((*scene.crowd.problems, *(problem for record in records for problem in record.problems)))
    _require_agents(scene_file, records, problems)
    progress("write", 0, 0)
    report = report_json(scene, records, options=options, problems=problems, folder=target)
    crowd_file, report_file = write_crowd(
        scene,
        [agent["name"] for record in records for agent in record.agents],
        target,
        chunks=[task.files for task, record in zip(tasks, records, strict=True) if record.agents],
        characters=characters,
        provenance=provenance_of(scene, options, target),
        report=report,
    )
    return AnimateReport(
        crowd_file=crowd_file,
        report_file=report_file,
        results={name: results for record in records for name, results in record.results.items()},
        problems=problems,
        chunks=len(tasks),
        kept=len(kept),
    )


def _kept(folder: Path, task: ChunkTask) -> str | None:
    """The record of a chunk that need not be made again."""
    return read_record(folder, task.files, task.content_hash)


def _make(
    tasks: Sequence[ChunkTask],
    kept: dict[int, str],
    workers: Executor | Workshop,
    progress: Callable[[str, int, int], None],
) -> dict[int, str]:
    """Records of the chunks that are not kept, by index."""
    pending = [index for index in range(len(tasks)) if index not in kept]
    made: dict[int, str] = {}
    progress("animate", 0, len(pending))
    for done, record in run_chunks([tasks[index] for index in pending], workers):
        made[pending[done]] = record
        progress("animate", len(made), len(pending))
    return made


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
