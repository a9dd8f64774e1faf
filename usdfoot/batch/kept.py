"""Kept: agents of a chunk that an earlier run made from the same, so that only the others are made again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from usdfoot.batch.entries import AgentEntry
from usdfoot.batch.records import parse_record
from usdfoot.batch.tasks import ChunkTask
from usdfoot.bridge.chunks import ChunkLayers
from usdfoot.model.report import Problem
from usdfoot.readers.chunks import open_chunk

__all__ = ["KeptAgents", "keep_agents"]


@dataclass(frozen=True, kw_only=True)
class KeptAgents:
    """Agents that need not be made."""

    layers: ChunkLayers | None = None
    """Who have them; None = nobody is kept."""
    entries: Mapping[str, AgentEntry] = field(default_factory=dict)
    """What the report says of them, by agent."""
    problems: tuple[Problem, ...] = ()
    """Theirs, without those of their clips."""


def keep_agents(task: ChunkTask) -> KeptAgents:
    """The agents of a chunk that are in an earlier chunk as the task wants them: the one that has most.

    Specs are edited where they are and never copied from layer to layer, which would leave their fields in another
    order and the file with other bytes than those of a chunk made at once. Hence agents that changed places and what
    is no longer there are to be made.
    """
    places = Counter(files for files in task.earlier if files).most_common(1)
    found = open_chunk(Path(task.folder), places[0][0]) if places else None
    if found is None:
        return KeptAgents()
    layers, notes = found
    record = parse_record(notes.record)
    names = {name for name, _ in notes.agent_hashes.items() & set(zip(task.agents, task.hashes, strict=True))}
    entries = {entry.name: entry for entry in record.agents if entry.name in names}
    prims = {entry.prim for entry in entries.values()}
    problems = tuple(problem for problem in record.problems if problem.where in prims)
    in_order = list(entries) == [name for name in task.agents if name in entries]
    return KeptAgents(layers=layers, entries=entries, problems=problems) if entries and in_order else KeptAgents()
