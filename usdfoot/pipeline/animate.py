"""Animate: a scene's footsteps become a crowd on disk."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from usdfoot.errors import OutputError
from usdfoot.model.motion import Motion
from usdfoot.model.report import Problem
from usdfoot.physics.animate import animate_all
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.report import AnimateReport, provenance_of, report_json
from usdfoot.pipeline.sources import source_figures
from usdfoot.readers.scene import read_scene
from usdfoot.writers.crowd import check_output, write_crowd

__all__ = ["animate"]


def animate(
    scene_file: str | os.PathLike[str],
    folder: str | os.PathLike[str],
    *,
    agents: str = "*",
    frames: tuple[int, int] | None = None,
    options: MotionOptions | None = None,
    collect: bool = False,
    progress: Callable[[str], None] = lambda stage: None,
) -> AnimateReport:
    """Read a scene, animate its agents, write the crowd (design.md sections 2 and 3).

    An agent that cannot be animated is reported and skipped; the crowd goes on.

    Args:
        scene_file: The USD scene; never changed.
        folder: Where crowd.usd and its layers go.
        agents: Glob on agents' names or paths.
        frames: First and last time code to write; None = all of the plans.
        options: Of the sources of motion.
        collect: Copy the characters' files into the folder.
        progress: Told what begins: "read", "animate", "measure clips", "write".

    Returns:
        What was written and what was skipped.

    Raises:
        SceneError: If the scene cannot be opened or no agent can be used.
        OutputError: If the folder cannot be written to, or the output would replace the input.
    """
    options = options or MotionOptions()
    target = Path(os.path.realpath(folder))
    progress("read")
    scene = read_scene(scene_file, agents=agents, frames=frames, motion=options.motion)
    check_output(scene, target)
    progress("animate")
    motions, faults = animate_all(scene.crowd, options=options)
    problems = (*scene.crowd.problems, *faults)
    _require_motions(scene_file, motions, problems)
    progress("measure clips")
    sources = source_figures(scene.crowd, motions)
    progress("write")
    report = report_json(scene, motions, options=options, problems=problems, sources=sources, folder=target)
    provenance = provenance_of(scene, options, target)
    crowd_file, report_file = write_crowd(scene, motions, target, provenance=provenance, report=report, collect=collect)
    return AnimateReport(
        crowd_file=crowd_file,
        report_file=report_file,
        results={motion.name: motion.results for motion in motions},
        problems=problems,
    )


def _require_motions(scene_file: str | os.PathLike[str], motions: list[Motion], problems: tuple[Problem, ...]) -> None:
    """Raises OutputError if there is nothing to write."""
    if not motions:
        reasons = [problem.message for problem in problems if problem.severity == "error"]
        raise OutputError(scene_file, "nothing is written, as no agent could be animated", names=reasons)
