"""Pictures of the parametric spaces of a library, with matplotlib (extra: report)."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot.engine.animate import PreparedLibrary
from usdfoot.errors import UsdfootError
from usdfoot.pipeline.space_maps import ErrorMap, map_landings, map_velocities
from usdfoot.spaces.side_space import SideSpace

__all__ = ["has_matplotlib", "plot_spaces", "require_matplotlib"]


def has_matplotlib() -> bool:
    """Whether matplotlib is installed."""
    return importlib.util.find_spec("matplotlib") is not None


def require_matplotlib() -> None:
    """Nothing, if matplotlib is installed.

    Raises:
        UsdfootError: If it is not.
    """
    if not has_matplotlib():
        raise UsdfootError("matplotlib", "is not installed, so nothing can be drawn", "pip install 'usdfoot[report]'")


def plot_spaces(library: PreparedLibrary, folder: Path) -> list[Path]:
    """One picture for each style and gait: the footstep and the root velocity space with their errors.

    Args:
        library: Prepared clips.
        folder: Made if it is not there.

    Returns:
        The files written.
    """
    require_matplotlib()
    folder.mkdir(parents=True, exist_ok=True)
    skeleton = re.sub(r"\W+", "_", library.source.skeleton.name).strip("_")
    written, drawn = [], set()
    for (style, flight, side), space in sorted(library.spaces.spaces.items()):
        if (style, flight, id(space.footsteps)) in drawn:  # the other side is its mirror image
            continue
        drawn.add((style, flight, id(space.footsteps)))
        gait = "flight" if flight else "ground"
        name = "_".join([skeleton, re.sub(r"\W+", "_", style), gait, "left" if side == 0 else "right"])
        path = folder / f"{name}.png"
        _draw(library, space, side, title=f"style {style}, {'with' if flight else 'without'} flight", path=path)
        written.append(path)
    return written


def _draw(library: PreparedLibrary, space: SideSpace, side: int, *, title: str, path: Path) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 7.0), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2)
    _draw_landings(left, library, space, side)
    _draw_velocities(right, space)
    figure.suptitle(f"{title}, {len(space.examples)} examples, as the left foot swings")
    figure.savefig(path, dpi=110, metadata={"Software": None})


def _draw_landings(axes: Any, library: PreparedLibrary, space: SideSpace, side: int) -> None:
    """Triangulation over the offset of the blended landing ([B] Fig. 3 and 5)."""
    vertices, footsteps = space.footsteps.vertices, space.footsteps
    _shade(axes, map_landings(library, space, side), 1e3, "blended landing to wanted one, not corrected [mm]")
    if len(footsteps.triangles):
        axes.triplot(*vertices.T, footsteps.triangles, color="0.25", lw=0.6)
    else:
        axes.plot(*np.moveaxis(vertices[footsteps.edges], -1, 0).swapaxes(1, 2).reshape(2, -1), color="0.25", lw=0.6)
    axes.plot(*vertices.T, "o", color="black", ms=3.0, label="landings of examples")
    _frame(axes, "footsteps", "to the left [m]", "ahead [m]", origin="support ball")


def _draw_velocities(axes: Any, space: SideSpace) -> None:
    """Root examples over the error of the gradient bands."""
    roots = space.roots
    _shade(axes, map_velocities(space), 1.0, "blended root velocity to wanted one, bands alone [m/s]")
    others = np.setdiff1d(np.arange(len(roots.velocities)), roots.vertices)
    if others.size:
        axes.plot(*roots.velocities[others].T, ".", color="0.45", ms=3.0, label="examples merged into these")
    axes.plot(*roots.velocities[roots.vertices].T, "o", color="black", ms=4.0, label="root examples")
    _frame(axes, "root velocities", "to the left [m/s]", "ahead [m/s]", origin="standing")


def _shade(axes: Any, errors: ErrorMap, scale: float, label: str) -> None:
    values = scale * errors.errors
    if np.isfinite(values).any():
        top = float(np.nanpercentile(values, 99.0))
        image = axes.pcolormesh(
            errors.x, errors.z, values, cmap="YlOrRd", vmin=0.0, vmax=max(top, 1e-6), rasterized=True
        )
        mean, worst = float(np.nanmean(values)), float(np.nanmax(values))
        axes.figure.colorbar(image, ax=axes, shrink=0.85, extend="max").set_label(
            f"{label}\nmean {mean:.3g}, worst {worst:.3g}"
        )


def _frame(axes: Any, title: str, x: str, y: str, *, origin: str) -> None:
    axes.plot(0.0, 0.0, "s", color="tab:blue", mec="white", ms=8.0, label=origin)  # no colour of the errors
    axes.set(title=title, xlabel=x, ylabel=y, aspect="equal")
    axes.invert_xaxis()  # seen from above, facing up the page: left is left
    axes.grid(color="0.9", lw=0.5)
    axes.set_axisbelow(True)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), fontsize=8, frameon=False)
