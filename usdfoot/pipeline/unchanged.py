"""Unchanged: a crowd that would come out as it is, known by the bytes of what it is made from and consists of."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from usdfoot import __version__
from usdfoot.batch.records import problem_of, step_results
from usdfoot.bridge.file_hashes import intact_files
from usdfoot.bridge.tokens import File
from usdfoot.bridge.versions import library_versions
from usdfoot.errors import UsdfootError
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.provenance import CallRecord, call_of, options_of
from usdfoot.pipeline.report import AnimateReport, combined_hash, input_hashes, relative_path
from usdfoot.readers.provenance import read_provenance, read_scene_files
from usdfoot.writers.root import SUBLAYERS

__all__ = ["EarlierCrowd", "find_earlier"]

_AGENTS = re.compile(r"(?<=\n \"agents\": \[)\n(?:  .*\n)*(?= \])")
"""Entries of a report's agents, a line each."""


@dataclass(frozen=True, kw_only=True)
class EarlierCrowd:
    """The crowd that is in a folder already."""

    unchanged: AnimateReport | None = None
    """What `animate` said of it if it would write the same bytes again; None if it might not."""
    intact: Mapping[str, str] | None = None
    """SHA-256 of its files that are as they were written, by name; None = its report does not tell."""


def find_earlier(scene: Any, folder: Path, *, options: MotionOptions, call: CallRecord) -> EarlierCrowd:
    """The crowd of a folder, and whether it is what would be made.

    Nothing of the scene is read but which files it consists of. Of a crowd that might come out otherwise, files are
    not read that are older than its report.

    Args:
        scene: File or open stage.
        folder: Of the crowd, a real path.
        options: Of the sources of motion.
        call: What is asked for.

    Raises:
        SceneError: If the scene or overrides.usda cannot be opened.
    """
    is_same = _is_same(scene, folder, options, call)
    report = _read_report(folder, with_agents=is_same)
    if report is None:
        return EarlierCrowd()
    intact = intact_files(report["files"], folder, since=None if is_same else folder / File.REPORT)
    is_whole = is_same and intact == report["files"]
    return EarlierCrowd(unchanged=_report_of(report, folder) if is_whole else None, intact=intact)


def _is_same(scene: Any, folder: Path, options: MotionOptions, call: CallRecord) -> bool:
    """Whether a crowd says it was made of what is there now. Copied characters have files beyond these."""
    said = read_provenance(folder, sublayers=SUBLAYERS)
    if said is None or call.collect or (folder / File.PENDING).exists():
        return False
    if said.get("version") != __version__ or not _is_asked(said, options, call):
        return False
    info = read_scene_files(scene, folder, most_prims=call.limits.prims)
    if info is None:
        return False
    made_from = relative_path(info.identifier, folder), combined_hash(input_hashes(info, folder))
    return made_from == (said.get("scene"), said.get("contentHash"))


def _read_report(folder: Path, *, with_agents: bool) -> dict[str, Any] | None:
    """report.json, None if there is none that these versions wrote; its agents are most of it."""
    try:
        text = (folder / File.REPORT).read_text(encoding="utf-8")
        report = json.loads(text if with_agents else _AGENTS.sub("", text))
        is_ours = report["versions"] == {"usdfoot": __version__, **library_versions()}
        return report if is_ours and isinstance(report["files"], dict) else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _is_asked(said: Mapping[str, Any], options: MotionOptions, call: CallRecord) -> bool:
    """Whether a crowd says it was asked for in this way."""
    asked = replace(call, agents=[call.agents] if isinstance(call.agents, str) else list(call.agents))
    try:
        return options_of(said) == options and call_of(said) == asked
    except (UsdfootError, TypeError, ValueError):  # somebody wrote into it
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
