"""What the menu's items do: they ask usdview what is selected, call a command, and show what came of it."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd

from usdfoot.engine.options import SEAMS
from usdfoot.errors import UsdfootError
from usdfoot.model.report import Problem
from usdfoot.pipeline.report import AnimateReport
from usdfoot.usdview.curves import plan_along_selected
from usdfoot.usdview.dialogs import ask_choice, ask_file, ask_number
from usdfoot.usdview.footsteps import add_after_selected, delete_selected, move_selected, move_selected_to_point
from usdfoot.usdview.overlays import remove_overlays, save_overlay, shown_kinds, toggle_overlay
from usdfoot.usdview.selection import Selection
from usdfoot.usdview.takes import animate_again, drop_takes, keep_take
from usdfoot.usdview.worst import find_worst_step

__all__ = [
    "add",
    "change_root_weight",
    "change_seam",
    "delete",
    "drop",
    "jump_to_worst",
    "keep",
    "move",
    "move_to_point",
    "plan_along",
    "remove_all",
    "save",
    "selection_of",
    "toggle_com",
    "toggle_contacts",
    "toggle_errors",
    "toggle_footsteps",
    "toggle_space",
    "toggle_timing",
]


def selection_of(usdviewApi: Any) -> Selection:
    """What is selected in usdview."""
    paths = [Sdf.Path(path) for path in usdviewApi.selectedPaths if path != Sdf.Path.absoluteRootPath]
    instances = {
        prim.GetPath(): frozenset(numbers)
        for prim, numbers in usdviewApi.selectedInstances.items()
        if not isinstance(numbers, int)  # usdview's sign for all of them
    }
    point = usdviewApi.selectedPoint
    picked = point is not None and Gf.Vec3d(point) != Gf.Vec3d(0.0)  # usdview's sign for none
    return Selection(paths=tuple(paths), instances=instances, point=np.array(point, dtype=float) if picked else None)


def toggle_footsteps(usdviewApi: Any) -> None:
    """Show or hide prints by status."""
    _toggle(usdviewApi, "Footsteps")


def toggle_errors(usdviewApi: Any) -> None:
    """Show or hide columns of errors."""
    _toggle(usdviewApi, "Errors")


def toggle_contacts(usdviewApi: Any) -> None:
    """Show or hide the feet that stand."""
    _toggle(usdviewApi, "Contacts")


def toggle_com(usdviewApi: Any) -> None:
    """Show or hide the curve of the centre of mass."""
    _toggle(usdviewApi, "Com")


def toggle_space(usdviewApi: Any) -> None:
    """Show or hide the footstep space of the current step."""
    _toggle(usdviewApi, "Space")


def toggle_timing(usdviewApi: Any) -> None:
    """Show or hide timing daggers."""
    _toggle(usdviewApi, "Timing")


def remove_all(usdviewApi: Any) -> None:
    """Take the overlays out of the session layer."""
    _do(usdviewApi, lambda: remove_overlays(usdviewApi.stage), lambda _: "overlays removed")


def save(usdviewApi: Any) -> None:
    """Write what is drawn as a layer."""
    file = ask_file(usdviewApi.qMainWindow, "Save Overlay", "inspect.usda")
    if file is not None:
        _do(usdviewApi, lambda: save_overlay(usdviewApi.stage, file), lambda path: f"wrote {path}")


def change_root_weight(usdviewApi: Any) -> None:
    """Animate the selected agents with another root weight."""
    label = "Root weight: 0 keeps the footsteps, 1 the root's velocity"
    weight = ask_number(usdviewApi.qMainWindow, label, 0.5, low=0.0, high=1.0)
    if weight is not None:
        _do(usdviewApi, lambda: animate_again(*_asked(usdviewApi), root_weight=weight), lambda take: _told(take.report))


def change_seam(usdviewApi: Any) -> None:
    """Animate the selected agents with another way from step to step."""
    seam = ask_choice(usdviewApi.qMainWindow, "How one step passes into the next", SEAMS, current=SEAMS[0])
    if seam is not None:
        _do(usdviewApi, lambda: animate_again(*_asked(usdviewApi), seam=seam), lambda take: _told(take.report))


def drop(usdviewApi: Any) -> None:
    """Show the crowd as it was and remove the takes."""
    _do(usdviewApi, lambda: drop_takes(*_asked(usdviewApi)), lambda count: f"{count} takes dropped")


def keep(usdviewApi: Any) -> None:
    """Make the crowd again as the take shown last is."""
    _do(usdviewApi, lambda: keep_take(*_asked(usdviewApi)), _told)


def move(usdviewApi: Any) -> None:
    """Move the selected footstep by distances and an angle."""
    window = usdviewApi.qMainWindow
    distances = []
    for label in ("Ahead [m]", "To the left [m]"):
        distance = ask_number(window, label, 0.0, low=-5.0, high=5.0)
        if distance is None:
            return
        distances.append(distance)
    turn = ask_number(window, "Turned to the left [degrees]", 0.0, low=-180.0, high=180.0)
    if turn is not None:
        ahead, left = distances
        _do(
            usdviewApi,
            lambda: move_selected(*_asked(usdviewApi), ahead=ahead, left=left, turn=math.radians(turn)),
            _told,
        )


def move_to_point(usdviewApi: Any) -> None:
    """Move the selected footstep to the point picked last."""
    _do(usdviewApi, lambda: move_selected_to_point(*_asked(usdviewApi)), _told)


def add(usdviewApi: Any) -> None:
    """Add a footstep after the selected one."""
    _do(usdviewApi, lambda: add_after_selected(*_asked(usdviewApi)), _told)


def delete(usdviewApi: Any) -> None:
    """Delete the selected footstep."""
    _do(usdviewApi, lambda: delete_selected(*_asked(usdviewApi)), _told)


def plan_along(usdviewApi: Any) -> None:
    """Plan footsteps along the selected curves."""
    _do(
        usdviewApi,
        lambda: plan_along_selected(*_asked(usdviewApi)),
        lambda paths: f"planned {', '.join(str(path) for path in paths)}",
    )


def jump_to_worst(usdviewApi: Any) -> None:
    """Go to the worst step's time and select its agent."""

    def jump() -> str:
        worst = find_worst_step(*_asked(usdviewApi))
        usdviewApi.dataModel.currentFrame = worst.time
        usdviewApi.ClearPrimSelection()
        usdviewApi.AddPrimToSelection(usdviewApi.stage.GetPrimAtPath(worst.agent))
        missed = f"{1e3 * worst.placement_error:.3g} mm"
        return f"{worst.plan} footstep {worst.number}: {missed}, {worst.status}, frame {worst.time.GetValue():g}"

    _do(usdviewApi, jump, str)


def _toggle(usdviewApi: Any, kind: str) -> None:
    def toggled() -> Iterable[Problem]:
        problems = toggle_overlay(*_asked(usdviewApi), kind=kind)
        usdviewApi.dataModel.viewSettings.displayGuide = True
        return problems

    def told(problems: Iterable[Problem]) -> str:
        state = "shown" if kind in shown_kinds(usdviewApi.stage) else "hidden"
        return "; ".join([f"{kind} {state}", *(problem.message for problem in problems)])

    _do(usdviewApi, toggled, told)


def _asked(usdviewApi: Any) -> tuple[Usd.Stage, Selection, Usd.TimeCode]:
    """What every command is given."""
    return usdviewApi.stage, selection_of(usdviewApi), usdviewApi.frame


def _do(usdviewApi: Any, command: Callable[[], Any], told: Callable[[Any], str]) -> None:
    """Run a command, show what came of it in the status line, and errors on stderr too."""
    try:
        message = told(command())
    except UsdfootError as error:
        message = f"Usdfoot: {error}"
        print(message, file=sys.stderr)
    usdviewApi.UpdateGUI()
    usdviewApi.UpdateViewport()
    usdviewApi.PrintStatus(message)


def _told(report: AnimateReport) -> str:
    """One line of what was animated."""
    lines = [f"animated {len(report.results)} agents", *(problem.message for problem in report.problems)]
    return "; ".join(lines)
