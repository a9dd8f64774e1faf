"""Overlays in the session layer: shown, hidden, removed and saved; nothing else of the stage is touched."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from pxr import Sdf, Usd, UsdGeom

from usdfoot import __version__
from usdfoot.bridge.tokens import Overlay
from usdfoot.errors import SceneError
from usdfoot.model.overlay import Overlay as Drawing
from usdfoot.model.overlay_kinds import KINDS
from usdfoot.model.report import Problem
from usdfoot.pipeline.inspect import InspectOptions, draw_overlay, format_of
from usdfoot.readers.authored import authored
from usdfoot.readers.stage import read_stage_info
from usdfoot.readers.written import read_written_crowd
from usdfoot.usdview.selection import Selection, all_agents, selected_agents
from usdfoot.writers.layers import define_prim
from usdfoot.writers.overlay import overlay_layer, write_overlay

__all__ = ["draw", "redraw", "remove_overlays", "save_overlay", "shown_kinds", "toggle_overlay"]


def toggle_overlay(stage: Usd.Stage, selection: Selection, time: Usd.TimeCode, *, kind: str) -> tuple[Problem, ...]:
    """Hide an overlay that is shown; show one that is not, drawn for the selected agents, or for all.

    Args:
        stage: Open stage of a crowd.
        selection: Whose agents to draw.
        time: Not needed: overlays are drawn for all times.
        kind: One of `usdfoot.model.overlay_kinds.KINDS`.

    Returns:
        What could not be drawn.

    Raises:
        SceneError: If the stage has no agents, or there is no such kind.
    """
    if kind not in KINDS:
        raise SceneError(kind, "is no overlay", "choose one of those listed", KINDS)
    if kind in shown_kinds(stage):
        _hide(stage, kind)
        return ()
    return draw(stage, selected_agents(stage, selection), kinds=(kind,))


def draw(
    stage: Usd.Stage, agents: tuple[str, ...], *, kinds: tuple[str, ...], options: InspectOptions | None = None
) -> tuple[Problem, ...]:
    """Draw overlays into the session layer, in place of those of the same kinds; gives back what could not be drawn.

    Args:
        stage: Open stage of a crowd.
        agents: Names; none = all.
        kinds: What to draw.
        options: How; their kinds do not count.
    """
    crowd = read_written_crowd(stage)
    how = replace(options or InspectOptions(), kinds=kinds)
    overlay, problems = draw_overlay(crowd, agents=agents or "*", options=how)
    drawn = overlay_layer(overlay, format_of(read_stage_info(stage)))
    session = stage.GetSessionLayer()
    with Sdf.ChangeBlock():
        define_prim(session, Overlay.ROOT, "Scope")
        for told in drawn.GetPrimAtPath(Overlay.ROOT).properties:
            Sdf.CopySpec(drawn, told.path, session, told.path)
        for kind in kinds:
            _remove(session, _path(kind))
            if drawn.GetPrimAtPath(_path(kind)):
                Sdf.CreatePrimInLayer(session, _path(kind))
                Sdf.CopySpec(drawn, _path(kind), session, _path(kind))
    return problems


def redraw(stage: Usd.Stage) -> tuple[Problem, ...]:
    """Draw what is shown again, for the same agents, because the crowd has changed; forget what is hidden."""
    shown = shown_kinds(stage)
    names = [_drawn_agents(stage, kind) for kind in shown]
    there = set(all_agents(stage))
    remove_overlays(stage)
    problems: list[Problem] = []
    for agents in dict.fromkeys(names):
        kinds = tuple(kind for kind, own in zip(shown, names, strict=True) if own == agents)
        left = tuple(name for name in agents if name in there)
        problems += draw(stage, left, kinds=kinds) if left else ()
    return tuple(problems)


def remove_overlays(stage: Usd.Stage) -> None:
    """Take all overlays out of the session layer."""
    with Sdf.ChangeBlock():
        _remove(stage.GetSessionLayer(), Sdf.Path(Overlay.ROOT))


def save_overlay(stage: Usd.Stage, file: str | os.PathLike[str]) -> Path:
    """Write the overlays of the session layer as a layer of their own; gives back the file.

    Raises:
        SceneError: If no overlay is drawn.
        OutputError: If the file's name is no USD layer's, would replace one of the stage's, or cannot be written.
    """
    session, info = stage.GetSessionLayer(), read_stage_info(stage)
    if not session.GetPrimAtPath(Overlay.ROOT):
        raise SceneError(info.identifier, "shows no overlay", "show one first")
    layer = overlay_layer(
        Drawing(agents=()), format_of(info), text=Path(file).suffix != ".usdc", provenance={"version": __version__}
    )
    Sdf.CopySpec(session, Overlay.ROOT, layer, Overlay.ROOT)
    return write_overlay(file, layer, sources=info.layers)


def shown_kinds(stage: Usd.Stage) -> tuple[str, ...]:
    """Overlays that are drawn and not hidden."""
    prims = {kind: stage.GetPrimAtPath(_path(kind)) for kind in KINDS}
    return tuple(
        kind
        for kind, prim in prims.items()
        if prim and UsdGeom.Imageable(prim).ComputeVisibility() != UsdGeom.Tokens.invisible
    )


def _drawn_agents(stage: Usd.Stage, kind: str) -> tuple[str, ...]:
    """Names of the agents an overlay was drawn for."""
    for prim in Usd.PrimRange(stage.GetPrimAtPath(_path(kind))):
        names = authored(prim, Overlay.AGENTS)
        if names:
            return tuple(str(name) for name in names)
    return ()


def _hide(stage: Usd.Stage, kind: str) -> None:
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        UsdGeom.Imageable(stage.GetPrimAtPath(_path(kind))).MakeInvisible()


def _remove(layer: Sdf.Layer, path: Sdf.Path) -> None:
    """Remove a prim's spec, if there is one."""
    spec = layer.GetPrimAtPath(path)
    if spec:
        del (spec.nameParent or layer.pseudoRoot).nameChildren[spec.name]


def _path(kind: str) -> Sdf.Path:
    return Sdf.Path(Overlay.ROOT).AppendChild(kind)
