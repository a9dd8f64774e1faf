"""Footsteps of the selected plan moved, added and deleted; the crowd is animated again and shown."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from pxr import Usd

from usdfoot.errors import SceneError
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.pipeline.again import edit_plan
from usdfoot.pipeline.report import AnimateReport
from usdfoot.planning.edits import add_footstep, delete_footstep, lay_footsteps, move_footstep
from usdfoot.planning.prints import print_orientations
from usdfoot.readers.stage import read_stage_info
from usdfoot.readers.written import read_written_crowd
from usdfoot.usdview.refresh import refresh
from usdfoot.usdview.selection import Selection, selected_footstep

__all__ = ["add_after_selected", "delete_selected", "move_selected", "move_selected_to_point"]

Edit = Callable[[FootstepPlan, int], FootstepPlan]


def move_selected(
    stage: Usd.Stage, selection: Selection, time: Usd.TimeCode, *, ahead: float, left: float, turn: float = 0.0
) -> AnimateReport:
    """Move the selected footstep, or the current one of the selected agent, and animate again.

    The edit goes to the crowd's overrides.usda. The footstep lies on the terrain where it is moved to.

    Args:
        stage: Open stage of a crowd.
        selection: The footstep, or its agent.
        time: At which the footstep is the current one, where only an agent is selected.
        ahead: How far in the direction the foot points [m].
        left: How far to its left [m].
        turn: By how much it turns to the left [rad].

    Raises:
        UsdfootError: As `usdfoot.pipeline.again.edit_plan`.
    """

    def moved(plan: FootstepPlan, footstep: int) -> FootstepPlan:
        yaw = plan.yaws[footstep]
        place = plan.positions[footstep].copy()
        place[[0, 2]] += planar.rotate(yaw, np.array([left, ahead]))
        facing = print_orientations(yaw[None] + turn, plan.normals[footstep : footstep + 1])[0]
        return move_footstep(plan, footstep, position=place, orientation=facing if turn else None)

    return _edited(stage, selection, time, moved)


def move_selected_to_point(stage: Usd.Stage, selection: Selection, time: Usd.TimeCode) -> AnimateReport:
    """Move the selected footstep, or the current one of the selected agent, to the point picked, and animate again.

    Args:
        stage: Open stage of a crowd.
        selection: The footstep, or its agent, and the point.
        time: As of `move_selected`.

    Raises:
        SceneError: If no point was picked.
        UsdfootError: As `usdfoot.pipeline.again.edit_plan`.
    """
    return _edited(
        stage,
        selection,
        time,
        lambda plan, footstep: move_footstep(plan, footstep, position=_picked(stage, selection)),
    )


def add_after_selected(stage: Usd.Stage, selection: Selection, time: Usd.TimeCode) -> AnimateReport:
    """Add a footstep after the selected one (inside the plan one for each foot), and animate again.

    Args:
        stage: Open stage of a crowd.
        selection: The footstep, or its agent.
        time: As of `move_selected`.

    Raises:
        UsdfootError: As `usdfoot.pipeline.again.edit_plan`.
    """
    return _edited(stage, selection, time, add_footstep)


def delete_selected(stage: Usd.Stage, selection: Selection, time: Usd.TimeCode) -> AnimateReport:
    """Delete the selected footstep (inside the plan with the one after it), and animate again.

    Args:
        stage: Open stage of a crowd.
        selection: The footstep, or its agent.
        time: As of `move_selected`.

    Raises:
        UsdfootError: As `usdfoot.pipeline.again.edit_plan`.
    """
    return _edited(stage, selection, time, delete_footstep)


def _edited(stage: Usd.Stage, selection: Selection, time: Usd.TimeCode, edit: Edit) -> AnimateReport:
    """The crowd after an edit; what is new or moved lies on the terrain."""
    crowd = read_written_crowd(stage)
    footstep = selected_footstep(stage, selection, time)

    def laid(plan: FootstepPlan) -> FootstepPlan:
        edited = edit(plan, footstep.number)
        known = {place.tobytes() for place in plan.positions}
        rows = np.array([row for row, place in enumerate(edited.positions) if place.tobytes() not in known], dtype=int)
        if crowd.terrain is None or not rows.size:
            return edited
        return lay_footsteps(edited, rows, Ground(crowd.terrain))

    report = edit_plan(crowd, footstep.agent, laid)
    refresh(stage, crowd.folder)
    return report


def _picked(stage: Usd.Stage, selection: Selection) -> FloatArray:
    """The point picked, canonical [m]."""
    if selection.point is None:
        raise SceneError("selection", "holds no point", "pick a place on the ground")
    return read_stage_info(stage).units.points_to_canonical(np.asarray(selection.point, dtype=float))
