"""Coverage of clips as a picture: triangulated landings over the error to expect, with the circles where none lands."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot.analysis.examples import build_examples
from usdfoot.model.biped import SIDES
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.coverage import SpaceCoverage
from usdfoot.spaces.coverage import cover_spaces
from usdfoot.spaces.library import build_spaces

__all__ = ["cover_library", "draw_coverage"]


def cover_library(library: ClipLibrary) -> tuple[SpaceCoverage, ...]:
    """Coverage of a library's steps; none without usable steps."""
    examples, _ = build_examples(library)
    if not len(examples):
        return ()
    spaces = build_spaces(examples, pelvis=library.biped.pelvis, leg_length=library.biped.maximal_leg_length)
    return cover_spaces(library.skeleton, library.biped, examples, spaces=spaces)


def draw_coverage(spaces: Sequence[SpaceCoverage], path: Path) -> Path:
    """Draw every style, gait and foot; needs matplotlib (extra: report).

    Args:
        spaces: At least one.
        path: PNG to write.

    Returns:
        The file written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    groups = list(dict.fromkeys((space.skeleton, space.style, space.flight) for space in spaces))
    figure = Figure(figsize=(8.0, 5.5 * len(groups) + 0.5), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(len(groups), 2, squeeze=False)
    largest = max((float(np.nanmax(space.errors)) for space in spaces if np.isfinite(space.errors).any()), default=1.0)
    for axes in panels.ravel():
        axes.set_axis_off()
    for space in spaces:
        row = groups.index((space.skeleton, space.style, space.flight))
        shade = _draw(panels[row, space.side], space, largest)
    bar = figure.colorbar(shade, ax=panels.ravel().tolist(), shrink=0.6, pad=0.05)
    bar.set_label("expected error: mean distance of the joints from a recorded step's [cm]")
    title = "Where steps land, seen from the support ball (red square)"
    figure.suptitle(f"{title}\ndashed: where none lands, and how far the nearest is [m]")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    return path


def _draw(axes: Any, space: SpaceCoverage, largest: float) -> Any:
    """One foot's landings; gives back what the colour bar shows."""
    errors = 100.0 * np.nan_to_num(space.errors)
    x, z = space.landings.T
    top = 100.0 * largest
    if len(space.triangles):
        axes.tripcolor(x, z, space.triangles, errors, shading="gouraud", cmap="viridis", vmin=0.0, vmax=top)
        axes.triplot(x, z, space.triangles, color="0.3", lw=0.4)
    shade = axes.scatter(x, z, c=errors, s=14.0, ec="black", lw=0.5, cmap="viridis", vmin=0.0, vmax=top)
    for start, end in space.landings[space.hull]:
        axes.plot(*np.stack([start, end], axis=1), color="black", lw=1.2)
    turn = np.linspace(0.0, 2.0 * np.pi, 60)
    for empty in space.empty_circles:
        ring = empty.place + empty.radius * np.stack([np.sin(turn), np.cos(turn)], axis=1)
        axes.plot(*ring.T, "--", color="tab:red", lw=0.9)
        box = {"boxstyle": "round,pad=0.1", "fc": "white", "ec": "none", "alpha": 0.8}
        axes.text(*empty.place, f"{empty.radius:.2f}", color="tab:red", ha="center", va="center", fontsize=8, bbox=box)
    axes.plot(0.0, 0.0, "s", color="tab:red", ms=7.0)
    gait = "with" if space.flight else "without"
    title = f"{space.skeleton}\nstyle {space.style}, {gait} flight\n{SIDES[space.side]} foot, {space.steps} steps"
    axes.set_title(title, fontsize=9)
    axes.set(xlabel="to the left [m]", ylabel="ahead [m]", aspect="equal")
    axes.set_axis_on()
    axes.invert_xaxis()  # seen from above, facing up the page: left is left
    axes.grid(color="0.9", lw=0.5)
    axes.set_axisbelow(True)
    return shade
