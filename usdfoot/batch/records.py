"""Records: what the report says of a chunk, kept with the chunk so that a later run need not make it again."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from usdfoot.bridge.chunks import JsonText
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Agent
from usdfoot.model.motion import ForceResults, Motion, StepResults
from usdfoot.model.report import Problem

__all__ = ["AgentEntry", "ChunkRecord", "parse_record", "problem_json", "problem_of", "record_of", "step_results"]

_COLUMNS = {
    "blendError": "blend_error",
    "placementError": "placement_error",
    "slide": "slide",
    "yawError": "yaw_error",
    "hullDistance": "hull_distance",
    "timeWarp": "time_warp",
    "rootWeight": "root_weight",
    "beta": "beta",
    "rootVelocityError": "root_velocity_error",
}
"""Fields of `StepResults` by what the report calls them; its angles are in degrees."""
_FORCES = {"forceImbalance": "force_imbalance", "clampTime": "clamp_time", "jumpHeight": "jump_height"}
"""Fields of `ForceResults`, which only motions have that physics makes."""
_IN_DEGREES = "yawError"


@dataclass(frozen=True, kw_only=True)
class AgentEntry:
    """What the report says of an agent."""

    name: str
    prim: str
    text: JsonText
    """The whole entry, a line."""


@dataclass(frozen=True, kw_only=True)
class ChunkRecord:
    """What became of a chunk's agents."""

    agents: tuple[AgentEntry, ...]
    """Entries of the report, one an agent that was written."""
    problems: tuple[Problem, ...]
    """Of the agents and the clips they use."""
    is_kept: bool
    """Whether an earlier run made the chunk."""
    kept_agents: int
    """How many of the agents an earlier run made."""

    @property
    def results(self) -> dict[str, StepResults]:
        """Figures of every agent's steps, by agent name."""
        return {agent.name: step_results(json.loads(agent.text)["steps"]) for agent in self.agents}


def record_of(
    agents: Sequence[Agent],
    motions: Sequence[Motion],
    problems: Sequence[Problem],
    sources: Mapping[str, Mapping[str, float]],
    *,
    names: Sequence[str],
    trajectories: Mapping[str, Mapping[str, Any]],
    kept: Mapping[str, AgentEntry],
) -> str:
    """A chunk's record, the same whether its agents were made or kept.

    Its first line is JSON of who is in it and of the problems; each further line is the entry of an agent.

    Args:
        agents: Those of the motions, and perhaps others.
        motions: As written.
        problems: Of the chunk, in any order and as often as they come.
        sources: Figures of the source clips by agent.
        names: Of all agents in the order of the report, and perhaps of some that could not be animated.
        trajectories: How near those that follow one keep to it, by agent.
        kept: Entries of agents that were made before, by name.
    """
    by_name = {agent.name: agent for agent in agents}
    entries = dict(kept)
    for motion in motions:
        name, agent = motion.name, by_name[motion.name]
        entry = _agent_json(agent, motion, sources.get(name, {}), trajectories.get(name))
        entries[name] = AgentEntry(name=name, prim=agent.source, text=JsonText(_line(entry)))
    told = sorted(set(problems), key=lambda problem: (problem.where, problem.severity, problem.message))
    present = [entries[name] for name in names if name in entries]
    head = {
        "agents": [(entry.name, entry.prim) for entry in present],
        "problems": [problem_json(problem) for problem in told],
    }
    return "\n".join([_line(head), *(entry.text for entry in present)])


def parse_record(text: str, *, kept_agents: int | None = None) -> ChunkRecord:
    """The record that `record_of` made.

    Args:
        text: Its lines.
        kept_agents: How many of the agents an earlier run made; None = the whole chunk.
    """
    first, *lines = text.split("\n")
    head = json.loads(first)
    agents = tuple(
        AgentEntry(name=name, prim=prim, text=JsonText(line))
        for (name, prim), line in zip(head["agents"], lines, strict=True)
    )
    return ChunkRecord(
        agents=agents,
        problems=tuple(problem_of(problem) for problem in head["problems"]),
        is_kept=kept_agents is None,
        kept_agents=len(agents) if kept_agents is None else kept_agents,
    )


def problem_json(problem: Problem) -> dict[str, str]:
    """A problem's entry in the report."""
    return {"severity": problem.severity, "where": problem.where, "message": problem.message}


def problem_of(entry: Mapping[str, str]) -> Problem:
    """The problem of an entry that `problem_json` made."""
    return Problem(severity=entry["severity"], where=entry["where"], message=entry["message"])


def step_results(steps: Mapping[str, Any]) -> StepResults:
    """Figures of an agent's steps as its entry has them, which keeps seven digits of them."""
    weights = [list(step.values()) for step in steps["clips"]]
    columns = _read_columns(steps, _COLUMNS)
    columns[_COLUMNS[_IN_DEGREES]] = np.radians(columns[_COLUMNS[_IN_DEGREES]])
    return StepResults(
        **columns,
        status=tuple(steps["status"]),
        clip_counts=np.array([len(step) for step in weights], dtype=np.intp),
        clips=tuple(name for step in steps["clips"] for name in step),
        clip_weights=np.array([weight for step in weights for weight in step], dtype=float),
        forces=ForceResults(**_read_columns(steps, _FORCES)) if next(iter(_FORCES)) in steps else None,
    )


def _agent_json(
    agent: Agent, motion: Motion, source: Mapping[str, float], trajectory: Mapping[str, Any] | None
) -> dict[str, Any]:
    results = motion.results
    ends, weights = np.cumsum(results.clip_counts).tolist(), _numbers(results.clip_weights)
    parts = [slice(end - count, end) for count, end in zip(results.clip_counts.tolist(), ends, strict=True)]
    return {
        "name": motion.name,
        "prim": agent.source,
        "plan": agent.plan.name,
        "source": dict(source),
        "trajectory": trajectory,
        "steps": {
            "status": list(results.status),
            **_columns_json(results, _COLUMNS),
            "clips": [dict(zip(results.clips[part], weights[part], strict=True)) for part in parts],
            **(_columns_json(results.forces, _FORCES) if results.forces else {}),
        },
    }


def _columns_json(results: StepResults | ForceResults, names: Mapping[str, str]) -> dict[str, Sequence[float | None]]:
    """Figures by what the report calls them, one a step."""
    columns = np.array([getattr(results, field) for field in names.values()], dtype=float)
    angles = [name == _IN_DEGREES for name in names]
    columns[angles] = np.degrees(columns[angles])
    numbers, steps = _numbers(columns.ravel()), columns.shape[1]
    return {name: numbers[row * steps : (row + 1) * steps] for row, name in enumerate(names)}


def _read_columns(steps: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, FloatArray]:
    """Figures by field; what JSON does not know is not a number."""
    columns = np.array([steps[name] for name in names], dtype=float)
    return dict(zip(names.values(), columns, strict=True))


def _numbers(values: FloatArray) -> Sequence[float | None]:
    """Seven significant digits; None for what is not finite, which JSON does not know."""
    numbers = values.tolist()
    rounded = list(map(float, (len(numbers) * "%.7g " % tuple(numbers)).split()))
    return rounded if np.isfinite(values).all() else [number if isfinite(number) else None for number in rounded]


def _line(value: object) -> str:
    """JSON without line breaks."""
    return json.dumps(value, sort_keys=True, allow_nan=False)
