"""Analyze: what clips contain, and their contact events in a layer that an artist can correct."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from usdfoot.analysis.summary import ClipSummary, summarise
from usdfoot.model.report import Problem
from usdfoot.readers.libraries import read_libraries
from usdfoot.writers.events import write_clip_events

__all__ = ["AnalyzeReport", "analyze"]


@dataclass(frozen=True, kw_only=True)
class AnalyzeReport:
    """Outcome of one run of `analyze`."""

    summaries: tuple[ClipSummary, ...]
    """One for each clip, with its contacts."""
    problems: tuple[Problem, ...]
    """Clips that could not be used."""
    output: Path | None
    """Layer written, if any."""


def analyze(
    clips_file: str | os.PathLike[str],
    *,
    output: str | os.PathLike[str] | None = None,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> AnalyzeReport:
    """Find the contacts and steps of every clip of a stage; write the contacts over it if asked to.

    Args:
        clips_file: USD file with SkelAnimations; never changed.
        output: Layer to write: it sublayers the clips' file and adds the events as UsdfootClipAPI attributes, and
            gives them back when it is read in the clips' place.
        progress: Told which skeleton's clips begin, how many are done, and of how many.

    Raises:
        SceneError: If the file cannot be opened or has no clips.
        OutputError: If the layer cannot be written or would replace the clips' file.
    """
    progress("read", 0, 0)
    clips = read_libraries(clips_file)
    summaries: list[ClipSummary] = []
    for done, library in enumerate(clips.libraries):
        progress(library.skeleton.name, done, len(clips.libraries))
        summaries += summarise(library)
    unusable = [
        Problem(severity="error", where=summary.name, message="; ".join(summary.warnings))
        for summary in summaries
        if summary.contacts is None
    ]
    written = None
    if output is not None:
        contacts = {summary.name: summary.contacts for summary in summaries if summary.contacts is not None}
        written = write_clip_events(output, contacts, info=clips.info, default_prim=clips.default_prim)
    return AnalyzeReport(summaries=tuple(summaries), problems=(*clips.problems, *unusable), output=written)
