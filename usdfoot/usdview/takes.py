"""Takes: selected agents animated again with other options, shown over the crowd by the session layer."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from pxr import Sdf, Usd

from usdfoot.pipeline.again import TAKES, Take, make_take
from usdfoot.readers.written import read_written_crowd
from usdfoot.usdview.overlays import redraw
from usdfoot.usdview.selection import Selection, all_agents, selected_agents

__all__ = ["animate_again", "drop_takes"]


def animate_again(
    stage: Usd.Stage,
    selection: Selection,
    time: Usd.TimeCode,
    *,
    root_weight: float | None = None,
    seam: str | None = None,
) -> Take:
    """Animate the selected agents, or all, with another root weight or seam, and show them so.

    The take is a crowd of its own below takes/ in the crowd's folder, and sublayers of the session layer show it; the
    crowd and its scene stay as they are.

    Args:
        stage: Open stage of a crowd.
        selection: Whose agents.
        time: Not needed: the whole motion is made.
        root_weight: [B]'s lambda4 of all their steps, 0..1; None = as it was.
        seam: inertialise | crossfade | none; None = as it was.

    Raises:
        UsdfootError: As `usdfoot.pipeline.again.make_take`.
    """
    names = selected_agents(stage, selection) or all_agents(stage)
    take = make_take(read_written_crowd(stage), names, root_weight=root_weight, seam=seam)
    session = stage.GetSessionLayer()
    session.subLayerPaths = [*(path.as_posix() for path in take.layers), *session.subLayerPaths]
    redraw(stage)
    return take


def drop_takes(stage: Usd.Stage, selection: Selection, time: Usd.TimeCode) -> int:
    """Show the crowd itself again and remove the folders of all takes that were shown; gives back how many.

    Args:
        stage: Open stage of a crowd.
        selection: Not needed: all takes are dropped.
        time: Not needed.

    Raises:
        SceneError: If the stage has no agents.
    """
    above = Path(os.path.realpath(read_written_crowd(stage).folder)) / TAKES
    session = stage.GetSessionLayer()
    shown = [Path(os.path.realpath(path)).parent for path in session.subLayerPaths]
    folders = {folder for folder in shown if folder.parent == above}
    with Sdf.ChangeBlock():
        session.subLayerPaths = [
            path for path, folder in zip(list(session.subLayerPaths), shown, strict=True) if folder not in folders
        ]
    for folder in folders:
        shutil.rmtree(folder)
    if folders:
        redraw(stage)
    return len(folders)
