"""Unchanged: a crowd that would come out as it is, known by the bytes of what it is made from and consists of."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from usdfoot import __version__
from usdfoot.batch.records import problem_of, step_results
from usdfoot.bridge.file_hashes import file_hashes
from usdfoot.bridge.tokens import File
from usdfoot.bridge.versions import library_versions
from usdfoot.errors import UsdfootError
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.provenance import CallRecord, call_of, options_of
from usdfoot.pipeline.report import AnimateReport, combined_hash, input_hashes, relative_path
from usdfoot.readers.provenance import read_provenance, read_scene_files
from usdfoot.writers.root import SUBLAYERS

__all__ = ["find_unchanged"]


def find_unchanged(scene: Any, folder: Path, *, options: MotionOptions, call: CallRecord) -> AnimateReport | None:
    """What `animate` said of the crowd in a folder if it would write the same bytes again; None if it might not.

    Nothing of the scene is read but which files it consists of. Copied characters have files beyond these.

    Args:
        scene: File or open stage.
        folder: Of the crowd, a real path.
        options: Of the sources of motion.
        call: What is asked for.

    Raises:
        SceneError: If the scene or overrides.usda cannot be opened.
    """
    said = read_provenance(folder, sublayers=SUBLAYERS)
    if said is None or call.collect or (folder / File.PENDING).exists():
        return None
    if said.get("version") != __version__ or not _is_asked(said, options, call):
        return None
    info = read_scene_files(scene, folder)
    if info is None:
        return None
    made_from = relative_path(info.identifier, folder), combined_hash(input_hashes(info, folder))
    if made_from != (said.get("scene"), said.get("contentHash")):
        return None
    report = _read_report(folder)
    return _report_of(report, folder) if report and _is_whole(report, folder) else None


def _read_report(folder: Path) -> dict[str, Any] | None:
    """report.json, None if there is none that these versions wrote."""
    try:
        report = json.loads((folder / File.REPORT).read_text(encoding="utf-8"))
        return report if report["versions"] == {"usdfoot": __version__, **library_versions()} else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _is_asked(said: Mapping[str, Any], options: MotionOptions, call: CallRecord) -> bool:
    """Whether a crowd says it was asked for in this way."""
    asked = replace(call, agents=[call.agents] if isinstance(call.agents, str) else list(call.agents))
    try:
        return options_of(said) == options and call_of(said) == asked
    except (UsdfootError, TypeError, ValueError):  # somebody wrote into it
        return False


def _is_whole(report: dict[str, Any], folder: Path) -> bool:
    """Whether all files of a crowd are as its report says."""
    try:
        return file_hashes({name: folder / name for name in report["files"]}) == report["files"]
    except (OSError, KeyError):
        return False


def _report_of(report: dict[str, Any], folder: Path) -> AnimateReport:
    """What a report says, for whom nothing was to be made."""
    agents = report["agents"]
    anims = File.ANIMS.split(".")[0]
    chunks = sum(name.startswith(f"{anims}.") and name != File.ANIMS for name in report["files"])
    return AnimateReport(
        crowd_file=folder / File.CROWD,
        report_file=folder / File.REPORT,
        results={agent["name"]: step_results(agent["steps"]) for agent in agents},
        problems=tuple(problem_of(problem) for problem in report["problems"]),
        chunks=chunks,
        kept=chunks,
        kept_agents=len(agents),
    )
