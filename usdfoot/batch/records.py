"""Records: what the report says of a chunk, kept with the chunk so that a later run need not make it again."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from usdfoot.batch.entries import AgentEntry, entry_of, json_line, read_totals, totals_json
from usdfoot.model.agent import Agent
from usdfoot.model.motion import Motion
from usdfoot.model.report import Problem
from usdfoot.model.totals import StepTotals, add_totals

__all__ = [
    "NOBODY",
    "ChunkRecord",
    "kept_record",
    "parse_record",
    "problem_json",
    "problem_of",
    "read_records",
    "record_of",
]


@dataclass(frozen=True, kw_only=True)
class ChunkRecord:
    """What became of a chunk's agents."""

    head: bytes
    """What the report says of the chunk, a line of JSON: who is in it, its problems and the totals of its steps."""
    anims: str
    """Name of the file with its animations."""
    content_hash: str
    """Of all that the chunk was made from."""
    agents: tuple[AgentEntry, ...]
    """Entries of the report, one an agent that was written."""
    problems: tuple[Problem, ...]
    """Of the agents and the clips they use."""
    totals: StepTotals
    """Of the agents' steps."""
    is_kept: bool
    """Whether an earlier run made the chunk."""
    kept_agents: int
    """How many of the agents an earlier run made."""


def record_of(
    agents: Sequence[Agent],
    motions: Sequence[Motion],
    problems: Sequence[Problem],
    *,
    sources: Mapping[str, Mapping[str, float]],
    names: Sequence[str],
    trajectories: Mapping[str, Mapping[str, Any]],
    kept: Mapping[str, AgentEntry],
    anims: str,
    content_hash: str,
) -> str:
    """A chunk's record, the same whether its agents were made or kept.

    Its first line is JSON of who is in it, of the problems and of the totals; each further line is an agent's.

    Args:
        agents: Those of the motions, and perhaps others.
        motions: As written.
        problems: Of the chunk, in any order and as often as they come.
        sources: Figures of the source clips by agent.
        names: Of all agents in the order of the report, and perhaps of some that could not be animated.
        trajectories: How near those that follow one keep to it, by agent.
        kept: Entries of agents that were made before, by name.
        anims: Name of the file with the chunk's animations.
        content_hash: Of all that the chunk is made from.
    """
    by_name = {agent.name: agent for agent in agents}
    entries = dict(kept)
    for motion in motions:
        name = motion.name
        entries[name] = entry_of(by_name[name], motion, source=sources.get(name, {}), trajectory=trajectories.get(name))
    told = sorted(set(problems), key=lambda problem: (problem.where, problem.severity, problem.message))
    present = [entries[name] for name in names if name in entries]
    head = {
        "agents": [(entry.name, entry.prim) for entry in present],
        "anims": anims,
        "contentHash": content_hash,
        "problems": [problem_json(problem) for problem in told],
        "totals": totals_json(present),
    }
    return "\n".join([json_line(head), *(entry.text.decode() for entry in present)])


def parse_record(text: str, *, kept_agents: int | None = None) -> ChunkRecord:
    """The record that `record_of` made.

    Args:
        text: Its lines.
        kept_agents: How many of the agents an earlier run made; None = the whole chunk.
    """
    head, *lines = text.encode().split(b"\n")
    return _record(head, json.loads(head), lines, kept_agents=kept_agents)


def kept_record(text: str | None) -> ChunkRecord | None:
    """The record of a chunk that an earlier run made; None where there is none, or somebody wrote into it."""
    try:
        return None if text is None else parse_record(text)
    except (AttributeError, LookupError, TypeError, ValueError):
        return None


def read_records(heads: Sequence[Mapping[str, Any]], lines: Sequence[bytes]) -> list[ChunkRecord]:
    """Records of chunks that are kept as a report has them: the chunks' entries, and a line for each of their agents.

    Raises:
        KeyError, TypeError, ValueError: If somebody wrote into the report.
    """
    rest = iter(lines)
    records = [_record(json_line(head).encode(), head, [next(rest, b"") for _ in head["agents"]]) for head in heads]
    if next(rest, None) is not None or any(not agent.text for record in records for agent in record.agents):
        raise ValueError("the chunks have other agents than the report")
    return records


def _record(
    text: bytes, head: Mapping[str, Any], lines: Sequence[bytes], *, kept_agents: int | None = None
) -> ChunkRecord:
    return ChunkRecord(
        head=text,
        anims=str(head["anims"]),
        content_hash=str(head["contentHash"]),
        agents=tuple(
            AgentEntry(name=name, prim=prim, text=line)
            for (name, prim), line in zip(head["agents"], lines, strict=True)
        ),
        problems=tuple(problem_of(problem) for problem in head["problems"]),
        totals=read_totals(head["totals"]),
        is_kept=kept_agents is None,
        kept_agents=len(lines) if kept_agents is None else kept_agents,
    )


def problem_json(problem: Problem) -> dict[str, str]:
    """A problem's entry in the report."""
    return {"severity": problem.severity, "where": problem.where, "message": problem.message}


def problem_of(entry: Mapping[str, str]) -> Problem:
    """The problem of an entry that `problem_json` made."""
    return Problem(severity=entry["severity"], where=entry["where"], message=entry["message"])


NOBODY = ChunkRecord(
    head=b"",
    anims="",
    content_hash="",
    agents=(),
    problems=(),
    totals=add_totals(()),
    is_kept=False,
    kept_agents=0,
)
"""Record of a chunk without anybody who could be read."""
