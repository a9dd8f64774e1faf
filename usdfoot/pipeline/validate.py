"""Validate: every figure of design.md section 10 recomputed from the written files, against its target."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot.bridge.tokens import File
from usdfoot.errors import UsdfootError
from usdfoot.maths.types import FloatArray
from usdfoot.model.ground import Ground
from usdfoot.model.report import Problem
from usdfoot.pipeline import shares
from usdfoot.pipeline.measures import AgentMeasures, measure_agent
from usdfoot.pipeline.omissions import find_omissions
from usdfoot.readers.written import WrittenCrowd, agent_names, read_agent, read_written_crowd

__all__ = ["AgentFigures", "Figure", "Validation", "figures_of", "read_sources", "validate"]


@dataclass(frozen=True, kw_only=True)
class Figure:
    """One number against its target."""

    name: str
    unit: str
    value: float
    """In `unit`; NaN = nothing to measure."""
    target: float
    """In `unit`."""
    at_least: bool = False
    """Whether the value must not be below the target, instead of not above."""

    @property
    def passed(self) -> bool:
        """Whether the target is met; what could not be measured is not held against it."""
        if not np.isfinite(self.value):
            return True
        return self.value >= self.target if self.at_least else self.value <= self.target


@dataclass(frozen=True, kw_only=True)
class AgentFigures:
    """Figures of one agent, or of the whole crowd."""

    name: str
    steps: int
    """Footsteps whose placement is promised."""
    figures: tuple[Figure, ...]
    unpromised: tuple[tuple[int, str, float], ...]
    """Footsteps that promise nothing: index, status, placement error [m]."""


@dataclass(frozen=True, kw_only=True)
class Validation:
    """What was measured."""

    agents: tuple[AgentFigures, ...]
    total: AgentFigures
    problems: tuple[Problem, ...]

    @property
    def passed(self) -> bool:
        """Whether every figure of every agent meets its target and every agent could be measured."""
        met = all(figure.passed for agent in (*self.agents, self.total) for figure in agent.figures)
        return met and not any(problem.severity == "error" for problem in self.problems)

    def to_json(self) -> dict[str, Any]:
        """Plain dictionaries for `--json`."""
        return {
            "passed": self.passed,
            "total": _figures_to_json(self.total),
            "agents": {agent.name: _figures_to_json(agent) for agent in self.agents},
            "problems": [f"{problem.severity}: {problem.message}" for problem in self.problems],
        }


def validate(
    crowd_file: str | os.PathLike[str],
    *,
    executor: Executor | None = None,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> Validation:
    """Measure all agents of a written crowd.

    Args:
        crowd_file: A crowd.usd written by `usdfoot animate`.
        executor: Whose workers measure many agents; None = this process does.
        progress: Told "measure", how many agents are done, and of how many.

    Raises:
        SceneError: If the file cannot be opened or has no agents.
        UsdfootError: If a worker vanished.
    """
    crowd = read_written_crowd(crowd_file)
    problems = []
    if crowd.terrain is None:
        where = crowd.scene or str(crowd_file)
        problems.append(_problem("warning", where, "scene not found: penetration and clearance are not measured"))
    sources = read_sources(crowd.folder / File.REPORT)
    names = agent_names(crowd)
    if executor is None or len(names) <= shares.SHARE:
        found = _measured(crowd, names, progress)
    else:
        found = shares.in_shares(_measure_share, crowd_file, names, executor=executor, progress=progress)
    outcomes = list(found)
    measured = [measures for measures, _ in outcomes if measures is not None]
    problems += [problem for _, some in outcomes for problem in some]
    if measured and not all(measure.name in sources for measure in measured):
        message = f"{File.REPORT} beside the crowd does not tell the source clips' figures: smoothness is not measured"
        problems.append(_problem("warning", str(crowd_file), message))
    return Validation(
        agents=tuple(figures_of([measure], measure.name, sources) for measure in measured),
        total=figures_of(measured, "total", sources),
        problems=tuple(problems),
    )


def _measure_share(crowd_file: str, names: Sequence[str]) -> list[tuple[AgentMeasures | None, list[Problem]]]:
    """What a worker does."""
    return list(_measured(read_written_crowd(crowd_file), names, lambda stage, done, total: None))


def _measured(
    crowd: WrittenCrowd, names: Sequence[str], progress: Callable[[str, int, int], None]
) -> Iterator[tuple[AgentMeasures | None, list[Problem]]]:
    """Figures of some agents, None of who cannot be measured, and what is wrong with each."""
    ground = None if crowd.terrain is None else Ground(crowd.terrain)
    for number, name in enumerate(names):
        progress("measure", number, len(names))
        try:
            agent = read_agent(crowd, name)
            measures = measure_agent(agent, crowd.units, ground)
            slim = replace(measures, sole_heights=np.zeros((0, 2, 2)))  # of every frame, so a large crowd's are many
            yield slim, find_omissions(agent, crowd)
        except UsdfootError as error:
            yield None, [_problem("error", error.where, str(error))]


def figures_of(
    measures: Sequence[AgentMeasures], name: str, sources: Mapping[str, Mapping[str, float]]
) -> AgentFigures:
    """Figures over all footsteps of some agents.

    Args:
        measures: Of the agents.
        name: What the result is called.
        sources: Figures of the source clips by agent, from `read_sources`.
    """
    promised = _joined([measure.promised for measure in measures]).astype(bool)
    placement = _joined([measure.placement_error for measure in measures])
    kept = {
        name: _joined([getattr(measure, name) for measure in measures])[promised]
        for name in ("slide", "subframe_slide", "heel_slide", "yaw_error", "clearance", "timing_faults", "blend_error")
    }
    inside = _joined([measure.inside_hull for measure in measures]).astype(bool)[promised]
    ratios = {
        figure: np.array([_ratio(getattr(m, figure), sources.get(m.name, {}).get(key)) for m in measures])
        for figure, key in (
            ("knee_speed", "kneeSpeedP99"),
            ("joint_jerk", "jointJerkP99"),
            ("seam_jump", "seamJumpP99"),
        )
    }
    lowest = np.array([measure.lowest_sole for measure in measures])
    figures = (
        Figure(name="placement mean", unit="mm", value=1e3 * _mean(placement[promised]), target=1.0),
        Figure(name="placement worst", unit="mm", value=1e3 * _worst(placement[promised]), target=3.0),
        Figure(name="slide", unit="mm", value=1e3 * _worst(kept["slide"]), target=1.0),
        Figure(name="slide in subframes", unit="mm", value=1e3 * _worst(kept["subframe_slide"]), target=2.0),
        Figure(name="heel slide", unit="mm", value=1e3 * _worst(kept["heel_slide"]), target=5.0),
        Figure(name="yaw error", unit="deg", value=float(np.degrees(_worst(kept["yaw_error"]))), target=0.5),
        Figure(name="timing faults", unit="", value=float(kept["timing_faults"].sum()), target=0.0),
        Figure(name="lowest sole", unit="mm", value=-1e3 * _worst(-lowest), target=-2.0, at_least=True),
        Figure(name="clearance", unit="mm", value=-1e3 * _worst(-kept["clearance"]), target=10.0, at_least=True),
        Figure(name="blend error mean", unit="mm", value=1e3 * _mean(kept["blend_error"][inside]), target=1.0),
        Figure(name="knee speed / clips", unit="x", value=_worst(ratios["knee_speed"]), target=3.0),
        Figure(name="joint jerk / clips", unit="x", value=_worst(ratios["joint_jerk"]), target=1.2),
        Figure(name="seam jump / clips", unit="x", value=_worst(ratios["seam_jump"]), target=1.0),
    )
    statuses = [status for measure in measures for status in measure.status]
    unpromised = [(int(i), statuses[i], float(placement[i])) for i in np.flatnonzero(~promised)]
    return AgentFigures(name=name, steps=int(promised.sum()), figures=figures, unpromised=tuple(unpromised))


def read_sources(path: Path) -> dict[str, dict[str, float]]:
    """Figures of the source clips by agent, from the report beside the crowd."""
    try:
        report = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return {agent["name"]: agent["source"] for agent in report.get("agents", []) if "source" in agent}


def _figures_to_json(agent: AgentFigures) -> dict[str, Any]:
    def number(value: float) -> float | None:
        return value if np.isfinite(value) else None

    return {
        "steps": agent.steps,
        "figures": {
            figure.name: {
                "value": number(figure.value),
                "unit": figure.unit,
                "target": figure.target,
                "atLeast": figure.at_least,
                "passed": figure.passed,
            }
            for figure in agent.figures
        },
        "unpromised": [
            {"step": step, "status": status, "placementError": number(error)}
            for step, status, error in agent.unpromised
        ],
    }


def _problem(severity: str, where: str, message: str) -> Problem:
    return Problem(severity=severity, where=where, message=message)


def _joined(parts: Sequence[Any]) -> FloatArray:
    return np.concatenate(parts) if len(parts) else np.zeros(0)


def _mean(values: FloatArray) -> float:
    values = values[np.isfinite(values)]
    return float(values.mean()) if values.size else np.nan


def _worst(values: FloatArray) -> float:
    values = values[np.isfinite(values)]
    return float(values.max()) if values.size else np.nan


def _ratio(value: float, reference: float | None) -> float:
    return value / reference if reference else np.nan
