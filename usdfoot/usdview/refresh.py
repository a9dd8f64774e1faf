"""An open stage takes up files that were written anew."""

from __future__ import annotations

import os
from pathlib import Path

from pxr import Sdf, Usd

from usdfoot.model.report import Problem
from usdfoot.usdview.overlays import redraw

__all__ = ["refresh"]


def refresh(stage: Usd.Stage, folder: Path) -> tuple[Problem, ...]:
    """Reload the stage's layers that lie in a folder, and draw its overlays again; gives back what was not drawn.

    Layers that lie elsewhere keep what is not saved of them.
    """
    home = os.path.realpath(folder)
    used = [layer for layer in stage.GetUsedLayers() if not layer.anonymous]
    Sdf.Layer.ReloadLayers([layer for layer in used if os.path.dirname(os.path.realpath(layer.realPath)) == home])
    return redraw(stage)
