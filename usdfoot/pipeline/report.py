"""Report: what was animated, how well, from what; the content of report.json."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from usdfoot import __version__
from usdfoot.batch.records import ChunkRecord, problem_json
from usdfoot.bridge.file_hashes import file_hashes
from usdfoot.bridge.scene import Scene, StageInfo
from usdfoot.bridge.tokens import File
from usdfoot.bridge.versions import library_versions
from usdfoot.model.motion import StepResults
from usdfoot.model.report import Outcome, Problem
from usdfoot.model.totals import StepTotals
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.readers.overrides import read_overrides

__all__ = ["AnimateReport", "combined_hash", "input_hashes", "relative_path", "report_json"]


@dataclass(frozen=True, kw_only=True)
class AnimateReport(Outcome):
    """Outcome of one run of `animate`."""

    crowd_file: Path
    report_file: Path
    results: Mapping[str, StepResults]
    """Figures of every written agent's steps, by agent name."""
    totals: StepTotals
    """Of all of them."""
    chunks: int
    """Number of chunks of agents."""
    kept: int
    """How many of them were there from an earlier run, made from the same."""
    kept_agents: int
    """How many agents were, those of these chunks and of chunks in which others changed."""


def report_json(
    scene: Scene,
    records: Sequence[ChunkRecord],
    *,
    options: MotionOptions,
    problems: Sequence[Problem],
    folder: Path,
) -> dict[str, Any]:
    """The content of report.json: no times, no absolute paths, distances in metres; agents and chunks are JSON already.

    Args:
        scene: What was read.
        records: What was made of it, by chunk.
        options: Of the sources of motion.
        problems: All of the run.
        folder: Where the crowd is written.
    """
    return {
        "versions": {"usdfoot": __version__, **library_versions()},
        "options": asdict(options),
        "scene": relative_path(scene.stage.identifier, folder),
        "inputs": input_hashes(scene.stage, folder),
        "agents": [agent.text for record in records for agent in record.agents],
        "chunks": [record.head for record in records if record.agents],
        "problems": [problem_json(problem) for problem in problems],
    }


def input_hashes(stage: StageInfo, folder: Path) -> dict[str, str]:
    """SHA-256 of every file of the scene, and of overrides.usda if it says anything, by path from the folder."""
    files = [layer for layer in stage.layers if os.path.isfile(layer)]
    if read_overrides(folder, stage.units).layer is not None:
        files.append(str(folder / File.OVERRIDES))
    return file_hashes({relative_path(file, folder): Path(file) for file in files})


def combined_hash(hashes: Mapping[str, str]) -> str:
    """One hash for those of several files."""
    return hashlib.sha256("\n".join(f"{name} {value}" for name, value in hashes.items()).encode()).hexdigest()


def relative_path(path: str, folder: Path) -> str:
    """Path of a file as seen from a folder, links resolved."""
    return Path(os.path.relpath(os.path.realpath(path), os.path.realpath(folder))).as_posix()
