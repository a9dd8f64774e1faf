"""Records: what the report says of a chunk, kept with the chunk so that a later run need not make it again."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Agent
from usdfoot.model.motion import ForceResults, Motion, StepResults
from usdfoot.model.report import Problem

__all__ = ["ChunkRecord", "parse_record", "problem_json", "problem_of", "record_of"]


@dataclass(frozen=True, kw_only=True)
class ChunkRecord:
    """What became of a chunk's agents."""

    agents: tuple[dict[str, Any], ...]
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
        return {agent["name"]: _step_results(agent["steps"]) for agent in self.agents}


def record_of(
    agents: Sequence[Agent],
    motions: Sequence[Motion],
    problems: Sequence[Problem],
    sources: Mapping[str, Mapping[str, float]],
    *,
    names: Sequence[str],
    trajectories: Mapping[str, Mapping[str, Any]],
    kept: Mapping[str, Mapping[str, Any]],
) -> str:
    """A chunk's record as JSON, the same whether its agents were made or kept.

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
    made = {
        motion.name: _agent_json(
            by_name[motion.name], motion, sources.get(motion.name, {}), trajectories.get(motion.name)
        )
        for motion in motions
    }
    entries = {**kept, **made}
    told = sorted(set(problems), key=lambda problem: (problem.where, problem.severity, problem.message))
    record = {
        "agents": [entries[name] for name in names if name in entries],
        "problems": [problem_json(problem) for problem in told],
    }
    return json.dumps(record, sort_keys=True, allow_nan=False)


def parse_record(text: str, *, kept_agents: int | None = None) -> ChunkRecord:
    """The record that `record_of` made.

    Args:
        text: JSON.
        kept_agents: How many of the agents an earlier run made; None = the whole chunk.
    """
    record = json.loads(text)
    problems = tuple(problem_of(problem) for problem in record["problems"])
    return ChunkRecord(
        agents=tuple(record["agents"]),
        problems=problems,
        is_kept=kept_agents is None,
        kept_agents=len(record["agents"]) if kept_agents is None else kept_agents,
    )


def problem_json(problem: Problem) -> dict[str, str]:
    """A problem's entry in the report."""
    return {"severity": problem.severity, "where": problem.where, "message": problem.message}


def problem_of(entry: Mapping[str, str]) -> Problem:
    """The problem of an entry that `problem_json` made."""
    return Problem(severity=entry["severity"], where=entry["where"], message=entry["message"])


def _agent_json(
    agent: Agent, motion: Motion, source: Mapping[str, float], trajectory: Mapping[str, Any] | None
) -> dict[str, Any]:
    results = motion.results
    ends = np.cumsum(results.clip_counts)
    clips = [
        dict(zip(results.clips[end - count : end], _numbers(results.clip_weights[end - count : end]), strict=True))
        for count, end in zip(results.clip_counts.tolist(), ends.tolist(), strict=True)
    ]
    return {
        "name": motion.name,
        "prim": agent.source,
        "plan": agent.plan.name,
        "source": dict(source),
        "trajectory": trajectory,
        "steps": {
            "status": list(results.status),
            "blendError": _numbers(results.blend_error),
            "placementError": _numbers(results.placement_error),
            "slide": _numbers(results.slide),
            "yawError": _numbers(np.degrees(results.yaw_error)),
            "hullDistance": _numbers(results.hull_distance),
            "timeWarp": _numbers(results.time_warp),
            "rootWeight": _numbers(results.root_weight),
            "beta": _numbers(results.beta),
            "rootVelocityError": _numbers(results.root_velocity_error),
            "clips": clips,
            **_forces_json(results.forces),
        },
    }


def _forces_json(forces: ForceResults | None) -> dict[str, list[float | None]]:
    """Columns of motions that physics makes; none of others."""
    if forces is None:
        return {}
    return {
        "forceImbalance": _numbers(forces.force_imbalance),
        "clampTime": _numbers(forces.clamp_time),
        "jumpHeight": _numbers(forces.jump_height),
    }


def _numbers(values: FloatArray) -> list[float | None]:
    """Seven significant digits; None for what is not finite, which JSON does not know."""
    numbers = np.asarray(values).tolist()
    rounded = map(float, (len(numbers) * "%.7g " % tuple(numbers)).split())
    return [number if isfinite(number) else None for number in rounded]


def _step_results(steps: Mapping[str, Any]) -> StepResults:
    """Figures as read from a record, which keeps seven digits of them."""
    weights = [list(step.values()) for step in steps["clips"]]
    return StepResults(
        blend_error=_values(steps["blendError"]),
        placement_error=_values(steps["placementError"]),
        slide=_values(steps["slide"]),
        yaw_error=np.radians(_values(steps["yawError"])),
        hull_distance=_values(steps["hullDistance"]),
        time_warp=_values(steps["timeWarp"]),
        root_weight=_values(steps["rootWeight"]),
        beta=_values(steps["beta"]),
        root_velocity_error=_values(steps["rootVelocityError"]),
        status=tuple(steps["status"]),
        clip_counts=np.array([len(step) for step in weights], dtype=np.intp),
        clips=tuple(name for step in steps["clips"] for name in step),
        clip_weights=np.array([weight for step in weights for weight in step], dtype=float),
        forces=_force_results(steps),
    )


def _force_results(steps: Mapping[str, Any]) -> ForceResults | None:
    if "forceImbalance" not in steps:
        return None
    return ForceResults(
        force_imbalance=_values(steps["forceImbalance"]),
        clamp_time=_values(steps["clampTime"]),
        jump_height=_values(steps["jumpHeight"]),
    )


def _values(numbers: Sequence[float | None]) -> FloatArray:
    return np.array([np.nan if number is None else number for number in numbers], dtype=float)
