"""Kept: agents of a chunk that an earlier run made from the same, so that only the others are made again."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from usdfoot.batch.entries import AgentEntry
from usdfoot.batch.records import kept_record
from usdfoot.batch.tasks import ChunkTask
from usdfoot.model.report import Problem
from usdfoot.writers.chunks import ChunkPrims, read_chunk

__all__ = ["KeptAgents", "keep_agents"]


@dataclass(frozen=True, kw_only=True)
class KeptAgents:
    """Agents that need not be made."""

    prims: ChunkPrims | None = None
    """Theirs, and perhaps others; None = nobody is kept."""
    entries: Mapping[str, AgentEntry] = field(default_factory=dict)
    """What the report says of them, by agent."""
    problems: tuple[Problem, ...] = ()
    """Theirs, without those of their clips."""


def keep_agents(task: ChunkTask) -> KeptAgents:
    """The agents of a chunk that are in an earlier chunk as the task wants them: the one that has most."""
    places = Counter(files for files in task.earlier if files).most_common(1)
    if not places:
        return KeptAgents()
    try:
        prims, notes = read_chunk(Path(task.folder), places[0][0])
    except (OSError, TypeError, ValueError, LookupError, struct.error):  # somebody wrote it with another program
        return KeptAgents()
    record = kept_record(notes.record)
    if record is None:
        return KeptAgents()
    asked = zip(task.agents, task.hashes, strict=True)
    names = {name for name, content_hash in asked if notes.agent_hashes.get(name) == content_hash}
    entries = {entry.name: entry for entry in record.agents if entry.name in names}
    where = {entry.prim for entry in entries.values()}
    problems = tuple(problem for problem in record.problems if problem.where in where)
    return KeptAgents(prims=prims, entries=entries, problems=problems) if entries else KeptAgents()
