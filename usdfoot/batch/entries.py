"""Entries: what the report says of an agent, a line of JSON."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Agent
from usdfoot.model.motion import ForceResults, Motion, StepResults
from usdfoot.model.totals import FIGURES, StepTotals, Total, sum_steps

__all__ = ["AgentEntry", "EntryResults", "entry_of", "json_line", "read_totals", "totals_json"]

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
_ENCODER = json.JSONEncoder(sort_keys=True, allow_nan=False)
_IN_DEGREES = "yawError"
_SUMMED = [(name, field) for name, field in _COLUMNS.items() if field in FIGURES]


@dataclass(frozen=True, kw_only=True)
class AgentEntry:
    """What the report says of an agent."""

    name: str
    prim: str
    text: bytes
    """The whole entry, a line of JSON."""


class EntryResults(Mapping[str, StepResults]):
    """Figures of agents' steps by name, read from the report's entries when they are asked for.

    Args:
        entries: Of the report.
    """

    def __init__(self, entries: Iterable[AgentEntry]) -> None:
        self._texts = {entry.name: entry.text for entry in entries}

    def __getitem__(self, name: str) -> StepResults:
        return _step_results(json.loads(self._texts[name])["steps"])

    def __iter__(self) -> Iterator[str]:
        return iter(self._texts)

    def __len__(self) -> int:
        return len(self._texts)


def entry_of(
    agent: Agent, motion: Motion, *, source: Mapping[str, float], trajectory: Mapping[str, Any] | None
) -> AgentEntry:
    """An agent's entry.

    Args:
        agent: Of the motion.
        motion: As written.
        source: Figures of the source clips.
        trajectory: How near an agent that follows one keeps to it.
    """
    told = {
        "name": motion.name,
        "prim": agent.source,
        "plan": agent.plan.name,
        "source": dict(source),
        "trajectory": trajectory,
    }
    texts = {**{key: json_line(value) for key, value in told.items()}, "steps": _steps_text(motion.results)}
    return AgentEntry(name=motion.name, prim=agent.source, text=_object(texts).encode())


def _steps_text(results: StepResults) -> str:
    """Figures of steps as JSON, seven digits of each: from numbers, its encoder would take most of an entry's time."""
    weights, quoted = _numbers(results.clip_weights), {name: json_line(name) for name in set(results.clips)}
    clips = [f"{quoted[name]}: {weight}" for name, weight in zip(results.clips, weights, strict=True)]
    counts = results.clip_counts.tolist()
    ends = np.cumsum(results.clip_counts).tolist()
    parts = ["{" + ", ".join(clips[end - count : end]) + "}" for count, end in zip(counts, ends, strict=True)]
    texts = {"status": json_line(results.status), "clips": f"[{', '.join(parts)}]", **_columns(results, _COLUMNS)}
    return _object({**texts, **(_columns(results.forces, _FORCES) if results.forces else {})})


def _columns(results: StepResults | ForceResults, names: Mapping[str, str]) -> dict[str, str]:
    """Lists of figures by what the report calls them, one a step."""
    columns = np.array([getattr(results, field) for field in names.values()], dtype=float)
    angles = [name == _IN_DEGREES for name in names]
    columns[angles] = np.degrees(columns[angles])
    numbers, steps = _numbers(columns.ravel()), columns.shape[1]
    return {name: f"[{', '.join(numbers[row * steps : (row + 1) * steps])}]" for row, name in enumerate(names)}


def _numbers(values: FloatArray) -> Sequence[str]:
    """Seven significant digits; null for what is not finite, which JSON does not know."""
    numbers = (len(values) * "%.7g " % tuple(values.tolist())).split()
    for index in np.flatnonzero(~np.isfinite(values)).tolist():
        numbers[index] = "null"
    return numbers


def _object(texts: Mapping[str, str]) -> str:
    """JSON of values that are JSON already."""
    return "{" + ", ".join(f'"{key}": {texts[key]}' for key in sorted(texts)) + "}"


def json_line(value: object) -> str:
    """JSON without line breaks."""
    return _ENCODER.encode(value)


def _step_results(steps: Mapping[str, Any]) -> StepResults:
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


def _read_columns(steps: Mapping[str, Any], names: Mapping[str, str]) -> dict[str, FloatArray]:
    """Figures by field; what JSON does not know is not a number."""
    columns = np.array([steps[name] for name in names], dtype=float)
    return dict(zip(names.values(), columns, strict=True))


def totals_json(entries: Sequence[AgentEntry]) -> dict[str, Any]:
    """Totals of agents' steps by what the report calls the figures, each with how many, their sum and the most."""
    columns = {field: np.array(_listed(entries, name), dtype=float) for name, field in _SUMMED}
    totals = sum_steps(_listed(entries, "status"), columns)
    figures = {name: list(totals.figures[field]) for name, field in _SUMMED}
    return {"steps": totals.steps, "promised": totals.promised, **figures}


def _listed(entries: Sequence[AgentEntry], name: str) -> list[Any]:
    """What all entries list under a name, in one; the rest of them, of which clips are most, is not read."""
    start = f'"{name}": ['.encode()
    parts = [entry.text.partition(start)[2].partition(b"]")[0] for entry in entries]
    listed: list[Any] = json.loads(b"[" + b", ".join(part for part in parts if part) + b"]")
    return listed


def read_totals(totals: Mapping[str, Any]) -> StepTotals:
    """Totals as `totals_json` told them."""
    figures = {field: Total(*totals[name]) for name, field in _SUMMED}
    return StepTotals(steps=int(totals["steps"]), promised=int(totals["promised"]), figures=figures)
