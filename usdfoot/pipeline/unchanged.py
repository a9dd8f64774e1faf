"""Unchanged: a crowd that would come out as it is, known by the bytes of what it is made from and consists of."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from pxr import Sdf, Tf, Usd

from usdfoot import __version__
from usdfoot.batch.records import ChunkRecord, problem_of
from usdfoot.bridge.file_hashes import file_hashes
from usdfoot.bridge.scene import StageInfo
from usdfoot.bridge.tokens import PROVENANCE, File
from usdfoot.bridge.versions import library_versions
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.report import (
    AnimateReport,
    CallRecord,
    call_of,
    combined_hash,
    input_hashes,
    options_of,
    relative_path,
)
from usdfoot.readers.overrides import read_overrides
from usdfoot.readers.stage import open_stage, read_stage_info
from usdfoot.writers.root import SUBLAYERS

__all__ = ["find_unchanged"]


def find_unchanged(
    scene_file: str | os.PathLike[str], folder: Path, *, options: MotionOptions, call: CallRecord
) -> AnimateReport | None:
    """What `animate` said of the crowd in a folder if it would write the same bytes again; None if it might not.

    Nothing of the scene is read but which files it consists of. That says enough unless they are changed in memory,
    name files that are opened later (value clips, copied characters, layers below overrides.usda), or are not files.

    Args:
        scene_file: The USD scene.
        folder: Of the crowd, a real path.
        options: Of the sources of motion.
        call: What is asked for.

    Raises:
        SceneError: If the scene or overrides.usda cannot be opened.
    """
    report, crowd = _read_report(folder), _read_crowd(folder)
    if report is None or crowd is None or call.collect or (folder / File.PENDING).exists():
        return None
    said = crowd.customLayerData.get(PROVENANCE, {})
    asked = replace(call, agents=[call.agents] if isinstance(call.agents, str) else list(call.agents))
    if said.get("version") != __version__ or options_of(said) != options or call_of(said) != asked:
        return None
    stage = open_stage(scene_file)
    info = read_stage_info(stage)
    if not _is_told_by_files(stage, folder, info):
        return None
    made_from = said.get("scene"), said.get("contentHash")
    if made_from != (relative_path(info.identifier, folder), combined_hash(input_hashes(info, folder))):
        return None
    return _report_of(report, folder) if _is_whole(report, folder) else None


def _read_report(folder: Path) -> dict[str, Any] | None:
    """report.json, None if there is none that these versions wrote."""
    try:
        report = json.loads((folder / File.REPORT).read_text(encoding="utf-8"))
        return report if report["versions"] == {"usdfoot": __version__, **library_versions()} else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _read_crowd(folder: Path) -> Sdf.Layer | None:
    """crowd.usd, None if it is not as it was written."""
    path = folder / File.CROWD
    if not path.is_file() or not (folder / File.OVERRIDES).is_file():
        return None
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(path))
    except Tf.ErrorException:
        return None
    is_ours = not layer.rootPrims and list(layer.subLayerPaths) == [f"./{name}" for name in SUBLAYERS]
    return layer if is_ours else None


def _is_told_by_files(stage: Usd.Stage, folder: Path, info: StageInfo) -> bool:
    """Whether the bytes of the scene's layers and of overrides.usda say all that reading them would."""
    layers = [layer for layer in stage.GetUsedLayers() if layer != stage.GetSessionLayer()]
    overrides = read_overrides(folder, info.units).layer
    if any(layer.anonymous or layer.dirty for layer in layers):
        return False
    if overrides is not None and overrides.GetCompositionAssetDependencies():
        return False
    return not any(prim.HasAuthoredMetadata("clips") for prim in stage.TraverseAll())


def _is_whole(report: dict[str, Any], folder: Path) -> bool:
    """Whether all files of a crowd are as its report says."""
    try:
        return file_hashes({name: folder / name for name in report["files"]}) == report["files"]
    except (OSError, KeyError):
        return False


def _report_of(report: dict[str, Any], folder: Path) -> AnimateReport:
    """What a report says, for whom nothing was to be made."""
    record = ChunkRecord(agents=tuple(report["agents"]), problems=(), is_kept=True)
    anims = File.ANIMS.split(".")[0]
    chunks = sum(name.startswith(f"{anims}.") and name != File.ANIMS for name in report["files"])
    return AnimateReport(
        crowd_file=folder / File.CROWD,
        report_file=folder / File.REPORT,
        results=record.results,
        problems=tuple(problem_of(problem) for problem in report["problems"]),
        chunks=chunks,
        kept=chunks,
        kept_agents=len(record.agents),
    )
