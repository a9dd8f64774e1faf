"""Inspect: a written crowd becomes an overlay that shows what happened on every footstep."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from usdfoot import __version__
from usdfoot.bridge.scene import StageInfo
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.maths import quaternion
from usdfoot.model.overlay import Marks, Overlay, ShownAgent
from usdfoot.model.overlay_kinds import KINDS
from usdfoot.model.report import Outcome, Problem
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.pipeline.overlay_com import draw_com
from usdfoot.pipeline.overlay_marks import mark_contacts, mark_errors, mark_footsteps, mark_timing, tabulate_steps
from usdfoot.pipeline.overlay_spaces import draw_spaces
from usdfoot.readers.executed import read_step_results
from usdfoot.readers.joint_tracks import read_joint_tracks
from usdfoot.readers.stage import read_stage_info
from usdfoot.readers.written import WrittenAgent, WrittenCrowd, agent_names, read_agent, read_written_crowd
from usdfoot.writers.layers import LayerFormat
from usdfoot.writers.overlay import overlay_layer, write_overlay

__all__ = ["InspectOptions", "InspectReport", "draw_overlay", "format_of", "inspect"]


@dataclass(frozen=True, kw_only=True)
class InspectOptions:
    """How an overlay is drawn."""

    error_scale: float = 100.0
    """Height of an error's column over the error ([B] Figure 8)."""
    second_length: float = 0.5
    """Length of a timing dagger that stands for a second [m] ([P] Figure 3)."""
    weight_length: float = 0.3
    """Height of the column on an example that has all the weight [m] ([B] Figure 4)."""
    kinds: tuple[str, ...] = KINDS
    """What to draw; for the footstep space the scene's clips are read and analysed again."""

    def __post_init__(self) -> None:
        for name in ("error_scale", "second_length", "weight_length"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise UsdfootError(name, f"is {getattr(self, name)}", "must be a number above 0")
        unknown = [kind for kind in self.kinds if kind not in KINDS]
        if unknown or not self.kinds:
            raise UsdfootError("kinds", "is nothing that can be drawn", f"choose of {', '.join(KINDS)}", unknown)


@dataclass(frozen=True, kw_only=True)
class InspectReport(Outcome):
    """What was drawn."""

    file: Path
    """The layer written."""
    agents: tuple[str, ...]
    """Names of the agents drawn."""


def inspect(
    crowd_file: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    agents: str = "*",
    options: InspectOptions | None = None,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> InspectReport:
    """Write an overlay of a written crowd as a layer, for `usdview --sessionLayer` or over it in any stage.

    Args:
        crowd_file: A crowd.usd written by `usdfoot animate`; never changed.
        output: Layer to write: .usd, .usda or .usdc.
        agents: Glob on the agents' names.
        options: How it is drawn.
        progress: Told what begins or goes on, how much of it is done, and of how much: "read", "draw", "write".

    Raises:
        SceneError: If the file cannot be opened, or has no agents that match.
        OutputError: If the layer cannot be written.
    """
    options = options or InspectOptions()
    crowd = read_written_crowd(crowd_file)
    overlay, problems = draw_overlay(crowd, agents=agents, options=options, progress=progress)
    progress("write", 0, 0)
    info = read_stage_info(crowd.stage)
    layer = overlay_layer(
        overlay,
        format_of(info),
        text=Path(output).suffix != ".usdc",
        provenance={"version": __version__},
    )
    file = write_overlay(output, layer, sources=info.layers)
    return InspectReport(file=file, agents=overlay.agents, problems=problems)


def format_of(info: StageInfo) -> LayerFormat:
    """Metadata of a layer that goes over a stage."""
    return LayerFormat(
        units=info.units,
        frames_per_second=info.frames_per_second,
        start_code=info.start_code,
        end_code=info.end_code,
    )


def draw_overlay(
    crowd: WrittenCrowd,
    *,
    agents: str | Sequence[str] = "*",
    options: InspectOptions | None = None,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> tuple[Overlay, tuple[Problem, ...]]:
    """What to draw over a crowd, and which agents could not be read.

    Args:
        crowd: As read.
        agents: Glob on the agents' names, or several.
        options: How it is drawn.
        progress: As of `inspect`.

    Raises:
        SceneError: If no agent matches, or none can be read.
    """
    options = options or InspectOptions()
    where = crowd.stage.GetRootLayer().identifier
    globs = (agents,) if isinstance(agents, str) else tuple(agents)
    names = [name for name in agent_names(crowd) if any(fnmatchcase(name, glob) for glob in globs)]
    if not names:
        raise SceneError(where, f"no agent matches {' '.join(globs)!r}", names=agent_names(crowd))
    shown, problems = [], []
    for done, name in enumerate(names):
        progress("read", done, len(names))
        try:
            shown.append(_shown(read_agent(crowd, name), crowd, with_com="Com" in options.kinds))
        except UsdfootError as error:
            problems.append(Problem(severity="error", where=error.where, message=str(error)))
    if not shown:
        raise SceneError(where, "no agent can be read", names=[problem.message for problem in problems])
    progress("draw", 0, 0)
    steps = tabulate_steps(shown)
    info = read_stage_info(crowd.stage)
    frames = crowd.units.codes_to_times(np.arange(np.ceil(info.start_code), np.floor(info.end_code) + 1.0))
    draw: dict[str, Callable[[], Iterable[Marks]]] = {
        "Footsteps": lambda: [mark_footsteps(steps)],
        "Errors": lambda: mark_errors(steps, scale=options.error_scale),
        "Contacts": lambda: [mark_contacts(steps, frames)],
        "Timing": lambda: [mark_timing(steps, scale=options.second_length)],
    }
    marks = [part for kind, parts in draw.items() if kind in options.kinds for part in parts()]
    if "Space" in options.kinds:
        found, warnings = draw_spaces(crowd, shown, frames, length=options.weight_length)
        marks += found
        problems += warnings
    overlay = Overlay(
        agents=tuple(agent.name for agent in shown),
        marks=tuple(part for part in marks if part.kinds.size),
        lines=(draw_com(shown),) if "Com" in options.kinds else (),
        notes={
            "error": options.error_scale,
            "second": options.second_length / crowd.units.meters_per_unit,
            "weight": options.weight_length / crowd.units.meters_per_unit,
        },
    )
    return overlay, tuple(problems)


def _shown(agent: WrittenAgent, crowd: WrittenCrowd, *, with_com: bool) -> ShownAgent:
    """What is drawn of an agent; without the path of its centre of mass only the first frame is read."""
    skeleton, biped = agent.skeleton, agent.biped
    places, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    offset = quaternion.rotate(quaternion.inverse(turns[biped.pelvis]), biped.com)
    feet = places[list(biped.balls)] - places[list(biped.ankles)]
    tracks = read_joint_tracks(agent, crowd.units, agent.frame_codes[: None if with_com else 1])
    turned = quaternion.rotate(tracks.turns([biped.pelvis])[:, 0], offset)
    return ShownAgent(
        name=agent.name,
        plan=agent.plan,
        foot_length=float(np.linalg.norm(feet, axis=1).mean()),
        results=read_step_results(agent, crowd.units),
        com_times=tracks.times,
        com_positions=tracks.positions[:, biped.pelvis] + turned,
    )
