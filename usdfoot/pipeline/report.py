"""Report: what was animated, how well, from what; the content of report.json."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot import __version__
from usdfoot.bridge.scene import Scene
from usdfoot.bridge.versions import library_versions
from usdfoot.engine.options import EngineOptions
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Agent
from usdfoot.model.motion import Motion, StepResults
from usdfoot.model.report import Problem

__all__ = ["AnimateReport", "provenance_of", "report_json"]


@dataclass(frozen=True, kw_only=True)
class AnimateReport:
    """Outcome of one run of `animate`."""

    crowd_file: Path
    report_file: Path
    results: Mapping[str, StepResults]
    """Figures of every written agent's steps, by agent name."""
    problems: tuple[Problem, ...]
    """What was skipped (errors) and what was used all the same (warnings)."""

    @property
    def skipped(self) -> tuple[Problem, ...]:
        """Agents and clips that could not be used."""
        return tuple(problem for problem in self.problems if problem.severity == "error")


def provenance_of(scene: Scene, options: EngineOptions, folder: Path) -> dict[str, Any]:
    """What crowd.usd says about its making: program, options, scene, and a hash of everything that was read.

    The scene's path is relative to the folder. It is a string, not an asset: the crowd does not depend on the scene,
    but `usdfoot validate` finds the terrain there.
    """
    hashes = _input_hashes(scene, folder)
    combined = hashlib.sha256("\n".join(f"{name} {value}" for name, value in hashes.items()).encode())
    return {
        "version": __version__,
        "scene": _relative(scene.stage.identifier, folder),
        "contentHash": combined.hexdigest(),
        "options": {key: value for key, value in asdict(options).items()},
    }


def report_json(
    scene: Scene,
    motions: Sequence[Motion],
    *,
    options: EngineOptions,
    problems: Sequence[Problem],
    sources: Mapping[str, Mapping[str, float]],
    folder: Path,
) -> dict[str, Any]:
    """The content of report.json: no times, no absolute paths, distances in metres.

    Args:
        scene: What was read.
        motions: What was made of it.
        options: Of the engine.
        problems: All of the run.
        sources: Figures of the source clips by agent.
        folder: Where the crowd is written.
    """
    by_name = {agent.name: agent for agent in scene.crowd.agents}
    return {
        "versions": {"usdfoot": __version__, **library_versions()},
        "options": asdict(options),
        "scene": _relative(scene.stage.identifier, folder),
        "inputs": _input_hashes(scene, folder),
        "agents": [_agent_json(by_name[motion.name], motion, sources.get(motion.name, {})) for motion in motions],
        "problems": [
            {"severity": problem.severity, "where": problem.where, "message": problem.message} for problem in problems
        ],
    }


def _agent_json(agent: Agent, motion: Motion, source: Mapping[str, float]) -> dict[str, Any]:
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
        },
    }


def _numbers(values: FloatArray) -> list[float | None]:
    """Seven significant digits; None for what is not finite, which JSON does not know."""
    return [float(f"{value:.7g}") if np.isfinite(value) else None for value in np.asarray(values).tolist()]


def _input_hashes(scene: Scene, folder: Path) -> dict[str, str]:
    """SHA-256 of every file the scene consists of, by path relative to the folder."""
    files = [layer for layer in scene.stage.layers if os.path.isfile(layer)]
    return dict(
        sorted((_relative(file, folder), hashlib.sha256(Path(file).read_bytes()).hexdigest()) for file in files)
    )


def _relative(path: str, folder: Path) -> str:
    return Path(os.path.relpath(os.path.realpath(path), os.path.realpath(folder))).as_posix()
