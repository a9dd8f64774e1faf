"""Takes: selected agents animated again with other options, shown over the crowd by the session layer."""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from pathlib import Path

from pxr import Usd

from usdfoot.errors import SceneError
from usdfoot.pipeline.again import TAKES, Take, make_take
from usdfoot.pipeline.again import keep_take as keep
from usdfoot.pipeline.report import AnimateReport
from usdfoot.readers.written import read_written_crowd
from usdfoot.usdview.overlays import redraw
from usdfoot.usdview.refresh import refresh
from usdfoot.usdview.selection import Selection, all_agents, selected_agents

__all__ = ["animate_again", "drop_takes", "keep_take"]


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
    folders = _shown(stage)
    _hide(stage, folders)
    for folder in folders:
        shutil.rmtree(folder)
    if folders:
        redraw(stage)
    return len(folders)


def keep_take(stage: Usd.Stage, selection: Selection, time: Usd.TimeCode) -> AnimateReport:
    """Make the crowd again with the motion of the take shown last, and drop all takes.

    Args:
        stage: Open stage of a crowd.
        selection: Not needed: the take says whose it is.
        time: Not needed.

    Raises:
        SceneError: If no take is shown.
        UsdfootError: As `usdfoot.pipeline.again.keep_take`; then the takes stay.
    """
    folders = _shown(stage)
    if not folders:
        raise SceneError("the session layer", "shows no take", "animate agents again with another root weight or seam")
    session = stage.GetSessionLayer()
    paths = list(session.subLayerPaths)
    _hide(stage, folders)
    crowd = read_written_crowd(stage)
    try:
        report = keep(crowd, folders[0])
    except BaseException:
        session.subLayerPaths = paths
        raise
    for folder in folders:
        shutil.rmtree(folder)
    refresh(stage, crowd.folder)
    return report


def _shown(stage: Usd.Stage) -> list[Path]:
    """Folders of the takes that the session layer shows, that shown last first."""
    above = Path(os.path.realpath(read_written_crowd(stage).folder)) / TAKES
    folders = [Path(os.path.realpath(path)).parent for path in stage.GetSessionLayer().subLayerPaths]
    return list(dict.fromkeys(folder for folder in folders if folder.parent == above))


def _hide(stage: Usd.Stage, folders: Sequence[Path]) -> None:
    """Take the layers of takes out of the session layer."""
    session = stage.GetSessionLayer()
    paths = list(session.subLayerPaths)
    session.subLayerPaths = [path for path in paths if Path(os.path.realpath(path)).parent not in folders]
