"""Unchanged: a crowd that would come out as it is, known by the bytes of what it is made from and consists of."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from usdfoot import __version__
from usdfoot.batch.entries import EntryResults
from usdfoot.batch.records import ChunkRecord, problem_of, read_records
from usdfoot.bridge.file_hashes import intact_files
from usdfoot.bridge.tokens import File
from usdfoot.bridge.versions import library_versions
from usdfoot.errors import UsdfootError
from usdfoot.model.totals import add_totals
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.provenance import CallRecord, call_of, options_of
from usdfoot.pipeline.report import AnimateReport, combined_hash, input_hashes, relative_path
from usdfoot.readers.provenance import has_value_clips, read_provenance, read_scene_files
from usdfoot.writers.root import SUBLAYERS

__all__ = ["EarlierCrowd", "find_earlier"]

_AGENTS, _NEXT, _END = b'\n "agents": [\n  ', b",\n  ", b"\n ]"
"""What a report has before its agents, a line each, between and after them."""


@dataclass(frozen=True, kw_only=True)
class EarlierCrowd:
    """The crowd that is in a folder already."""

    unchanged: AnimateReport | None = None
    """What `animate` said of it if it would write the same bytes again; None if it might not."""
    intact: Mapping[str, str] | None = None
    """SHA-256 of its files that are as they were written, by name; None = its report does not tell."""
    records: Mapping[str, ChunkRecord] = field(default_factory=dict)
    """What its report says of its chunks, by the file of their animations."""

    @property
    def is_there(self) -> bool:
        """Whether there is one, so that little may be to be made."""
        return self.intact is not None


def find_earlier(scene: Any, folder: Path, *, options: MotionOptions, call: CallRecord) -> EarlierCrowd:
    """The crowd of a folder, and whether it is what would be made.

    Nothing of the scene is read but which files it consists of, and nothing of the crowd's files that the report's own
    time vouches for.

    Args:
        scene: File or open stage.
        folder: Of the crowd, a real path.
        options: Of the sources of motion.
        call: What is asked for.

    Raises:
        SceneError: If the scene or overrides.usda cannot be opened.
    """
    is_same = _is_same(scene, folder, options, call)
    read = _read_report(folder)
    if read is None:
        return EarlierCrowd()
    report, records = read
    intact = intact_files(report["files"], folder, marked=folder / File.REPORT)
    if is_same and intact == report["files"]:
        return EarlierCrowd(unchanged=_report_of(report, records, folder), intact=intact)
    return EarlierCrowd(intact=intact, records={record.anims: record for record in records})


def _is_same(scene: Any, folder: Path, options: MotionOptions, call: CallRecord) -> bool:
    """Whether a crowd says it was made of what is there now. Copied characters have files beyond these."""
    said = read_provenance(folder, sublayers=SUBLAYERS)
    if said is None or call.collect or (folder / File.PENDING).exists():
        return False
    if said.get("version") != __version__ or not _is_asked(said, options, call):
        return False
    info = read_scene_files(scene, folder)
    if info is None:
        return False
    made_from = relative_path(info.identifier, folder), combined_hash(input_hashes(info, folder))
    if made_from != (said.get("scene"), said.get("contentHash")):
        return False
    return not has_value_clips(scene, most_prims=call.limits.prims)  # last, as every prim is looked at


def _read_report(folder: Path) -> tuple[dict[str, Any], list[ChunkRecord]] | None:
    """report.json without its agents, which are most of it, and its chunks' records; None if of other versions."""
    try:
        text = (folder / File.REPORT).read_bytes()
        start = text.index(_AGENTS) + len(_AGENTS)
        end = text.index(_END, start)
        agents, report = text[start:end], json.loads(text[:start] + text[end:])
        is_ours = report["versions"] == {"usdfoot": __version__, **library_versions()}
        is_ours = is_ours and isinstance(report["files"], dict)
        return (report, read_records(report["chunks"], agents.split(_NEXT))) if is_ours else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _is_asked(said: Mapping[str, Any], options: MotionOptions, call: CallRecord) -> bool:
    """Whether a crowd says it was asked for in this way."""
    asked = replace(call, agents=[call.agents] if isinstance(call.agents, str) else list(call.agents))
    try:
        return options_of(said) == options and call_of(said) == asked
    except (UsdfootError, TypeError, ValueError):  # somebody wrote into it
        return False


def _report_of(report: Mapping[str, Any], records: Sequence[ChunkRecord], folder: Path) -> AnimateReport:
    """What a report says, for whom nothing was to be made."""
    agents = [agent for record in records for agent in record.agents]
    return AnimateReport(
        crowd_file=folder / File.CROWD,
        report_file=folder / File.REPORT,
        results=EntryResults(agents),
        totals=add_totals(record.totals for record in records),
        problems=tuple(problem_of(problem) for problem in report["problems"]),
        chunks=len(records),
        kept=len(records),
        kept_agents=len(agents),
    )
