"""Analyze: what clips contain, and their contact events in a layer that an artist can correct."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath

from usdfoot import __version__
from usdfoot.analysis.styles import group_styles
from usdfoot.analysis.summary import ClipSummary, summarise
from usdfoot.engine.animate import prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import ClipError
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.coverage import SpaceCoverage
from usdfoot.model.report import Problem
from usdfoot.physics.fill import FilledLibrary, fill_library
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.coverage import cover_library, draw_coverage
from usdfoot.pipeline.plots import has_matplotlib, plot_spaces, require_matplotlib
from usdfoot.planning.reach import reach_of_biped
from usdfoot.readers.libraries import StageClips, read_libraries
from usdfoot.spaces.holes import HoleOptions
from usdfoot.writers.clip_prims import MadeClip
from usdfoot.writers.coverage import write_coverage
from usdfoot.writers.events import write_clip_events
from usdfoot.writers.paths import folder_path

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
    plots: tuple[Path, ...]
    """Pictures drawn."""
    coverage: tuple[SpaceCoverage, ...] = ()
    """Where the steps of every style, gait and foot land, if asked for."""
    coverage_file: Path | None = None
    """Stage that shows it."""
    filled: tuple[FilledLibrary, ...] = ()
    """Holes of the libraries' footstep spaces and the clips made for them, if asked for."""


def analyze(
    clips_file: str | os.PathLike[str],
    *,
    output: str | os.PathLike[str] | None = None,
    styles: bool = False,
    plots: str | os.PathLike[str] | None = None,
    fill: HoleOptions | None = None,
    coverage: str | os.PathLike[str] | None = None,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> AnalyzeReport:
    """Find the contacts and steps of every clip of a stage; write the contacts over it if asked to.

    Args:
        clips_file: USD file with SkelAnimations; never changed.
        output: Layer to write: it sublayers the clips' file and adds the events as UsdfootClipAPI attributes, and
            gives them back when it is read in the clips' place.
        styles: Group the clips that have no style by what their bodies do; write the styles found as well.
        fill: Make steps for the holes of the footstep spaces, and write them too; they are among the summaries.
        plots: Folder for pictures of the parametric spaces of every skeleton.
        coverage: Stage to write that shows where the steps can land, how well, and where none does; with matplotlib
            also as a picture of the same name, .png.
        progress: Told which skeleton's clips begin, how many are done, and of how many.

    Raises:
        SceneError: If the file cannot be opened or has no clips.
        OutputError: If the layer cannot be written or would replace the clips' file.
    """
    progress("read", 0, 0)
    clips = read_libraries(clips_file)
    summaries: list[ClipSummary] = []
    pictures: list[Path] = []
    covered: list[SpaceCoverage] = []
    drawings = None if plots is None else folder_path(plots)
    if drawings is not None:
        require_matplotlib()
    filled: list[FilledLibrary] = []
    for done, library in enumerate(clips.libraries):
        progress(library.skeleton.name, done, len(clips.libraries))
        own = summarise(library)
        found = group_styles(own) if styles else {}
        library = _styled(library, found)
        if fill is not None:
            filled.append(_fill(library, fill, first=_synthetic_count(clips.libraries, filled)))
            own += summarise(replace(library, clips=filled[-1].clips))
        summaries += [replace(summary, style=found.get(summary.name, summary.style)) for summary in own]
        if drawings is not None:
            pictures += _plot(filled[-1].filled if filled else library, drawings)
        if coverage is not None:
            covered += cover_library(filled[-1].filled if filled else library)
    unusable = [
        Problem(severity="error", where=summary.name, message="; ".join(summary.warnings))
        for summary in summaries
        if summary.contacts is None
    ]
    written = None if output is None else _write_events(output, clips, summaries, filled, styled=styles)
    shown = None
    if coverage is not None and covered:
        shown = _write_coverage(coverage, clips, covered)
        if has_matplotlib():
            pictures.append(draw_coverage(covered, shown.with_suffix(".png")))
    return AnalyzeReport(
        summaries=tuple(summaries),
        problems=(*clips.problems, *unusable, *(problem for each in filled for problem in each.problems)),
        output=written,
        plots=tuple(pictures),
        filled=tuple(filled),
        coverage=tuple(covered),
        coverage_file=shown,
    )


def _write_events(
    output: str | os.PathLike[str],
    clips: StageClips,
    summaries: Sequence[ClipSummary],
    filled: Sequence[FilledLibrary],
    *,
    styled: bool,
) -> Path:
    """The layer with events, styles if they were grouped, and the clips that were made."""
    made = [
        MadeClip(clip=clip, character=character)
        for each, character in zip(filled, clips.characters, strict=bool(filled))
        for clip in each.clips
    ]
    known = {summary.name: summary for summary in summaries if summary.contacts is not None}
    found = set(known) - {each.clip.name for each in made}
    return write_clip_events(
        output,
        {name: summary.contacts for name, summary in known.items() if summary.contacts is not None},
        info=clips.info,
        default_prim=clips.default_prim,
        styles={name: known[name].style for name in known if styled and name in found},
        made=made,
    )


def _write_coverage(output: str | os.PathLike[str], clips: StageClips, covered: Sequence[SpaceCoverage]) -> Path:
    """The stage that shows where the steps can land."""
    return write_coverage(
        output,
        covered,
        units=clips.info.units,
        sources=clips.info.layers,
        provenance={"version": __version__, "verb": "analyze", "clips": Path(clips.info.identifier).name},
    )


def _styled(library: ClipLibrary, styles: Mapping[str, str]) -> ClipLibrary:
    """The library with its clips in the styles found for them."""
    return replace(
        library, clips=tuple(replace(clip, style=styles.get(clip.name, clip.style)) for clip in library.clips)
    )


def _fill(library: ClipLibrary, holes: HoleOptions, *, first: int) -> FilledLibrary:
    """A library with steps of physics where its legs reach and no clip steps; none if there is no usable step.

    Args:
        library: Of one skeleton.
        holes: What a hole is.
        first: Number of the first synthetic clip, which is named beside the first of the library.
    """
    options = MotionOptions()
    try:
        prepared = prepare_library(library, options)
    except ClipError:
        return FilledLibrary(source=library, holes=(), clips=(), problems=())
    outline = reach_of_biped(library.biped).outline
    name = str(PurePosixPath(library.clips[0].name).with_name("synthetic_"))
    return fill_library(prepared, outline, name=name, first=first, holes=holes, options=options)


def _synthetic_count(libraries: Sequence[ClipLibrary], filled: Sequence[FilledLibrary]) -> int:
    """How many synthetic clips there are already, in the file and made."""
    known = sum(clip.synthetic for library in libraries for clip in library.clips)
    return known + sum(len(each.holes) for each in filled)


def _plot(library: ClipLibrary, folder: Path) -> list[Path]:
    """Pictures of the spaces of a library; none without usable steps."""
    try:
        return plot_spaces(prepare_library(library, EngineOptions()), folder)
    except ClipError:
        return []
