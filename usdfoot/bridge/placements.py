"""Placements: how artists' transforms have a written agent and its plan stand, and what usdfoot authors below these."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.bridge.units import StageUnits
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.displacement import Displacement

__all__ = ["AgentOps", "Placement", "fault_of", "matrix_of", "planar_matrix"]

_UPRIGHT = 1e-4
"""Largest entry by which a matrix may differ from a turn about the vertical that keeps lengths."""


@dataclass(frozen=True, kw_only=True)
class AgentOps:
    """Transforms that artists authored beside usdfoot's own translation and turn (row vectors, stage units).

    What they and these make together is `after` @ turn @ `between` @ translation @ `before`.
    """

    before: FloatArray
    """Outside the translation, shape (4, 4)."""
    between: FloatArray
    """Shape (4, 4)."""
    after: FloatArray
    """Inside the turn, without what stands the character upright, shape (4, 4)."""
    start: Displacement
    """Where the agent would start without them."""
    held: Displacement | None = None
    """Where the agent's prim stands still, since what artists authored replaces usdfoot's translation or turn; None =
    both are as usdfoot authors them."""


@dataclass(frozen=True, kw_only=True)
class Placement:
    """What artists authored that has an agent's prim, or its plan's, stand elsewhere."""

    plan_frame: FloatArray | None = None
    """From the written plan prim to the world (row vectors, stage units), shape (4, 4); None = nothing moves it."""
    plan_move: Displacement | None = None
    """Transform that usdfoot authors on the plan prim, which goes with the agent; None = none."""
    agent: AgentOps | None = None
    """None = nobody moved the agent's prim."""


def matrix_of(place: Displacement, units: StageUnits) -> FloatArray:
    """A displacement as a matrix (row vectors, stage units), shape (4, 4)."""
    matrix = np.eye(4)
    turned = quaternion.rotate(quaternion.yaw_quaternion(np.array(place.yaw)), units.directions_to_canonical(np.eye(3)))
    matrix[:3, :3] = units.directions_to_stage(turned)
    matrix[3, :3] = units.points_to_stage(place.translation)
    return matrix


def planar_matrix(matrix: FloatArray, units: StageUnits) -> Displacement:
    """The displacement that a matrix without `fault_of` is."""
    forward = units.directions_to_stage(np.array([0.0, 0.0, 1.0])) @ matrix[:3, :3]
    yaw = planar.yaw_of(units.directions_to_canonical(forward)[[0, 2]])
    return Displacement(translation=units.points_to_canonical(matrix[3, :3]), yaw=float(yaw))


def fault_of(matrix: FloatArray, units: StageUnits) -> str:
    """Why a matrix (row vectors) is no displacement of somebody who stands: what it does, "" = it is one."""
    linear = matrix[:3, :3]
    if not np.isfinite(matrix).all():
        return "is not finite"
    if np.abs(linear @ linear.T - np.eye(3)).max() > _UPRIGHT:
        return "scales it"
    if np.linalg.det(linear) < 0.0:
        return "mirrors it"
    up = units.directions_to_stage(np.array([0.0, 1.0, 0.0]))
    return "tilts it" if np.abs(up @ linear - up).max() > _UPRIGHT else ""
