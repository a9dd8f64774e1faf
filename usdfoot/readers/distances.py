"""Distances from the origin, at which single precision is too coarse for footsteps."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from usdfoot.bridge.scene import StageInfo
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.trajectory import RootTrajectory

__all__ = ["distance_problems"]

_COARSEST = 0.002
"""Footsteps may have places so far apart [m], and be off by half of it."""


def distance_problems(walks: Iterable[FootstepPlan | RootTrajectory], info: StageInfo) -> list[Problem]:
    """A warning where somebody walks so far from the origin that positions are coarse, as in scenes on a map's grid."""
    farthest = max((float(np.abs(walk.positions).max(initial=0.0)) for walk in walks), default=0.0)
    scale = info.units.meters_per_unit
    spacing = float(np.spacing(np.float32(farthest / scale))) * scale
    if spacing <= _COARSEST:
        return []
    message = (
        f"{info.identifier}: leads {farthest / 1000.0:.0f} km from the origin, where USD's positions are "
        f"{1000.0 * spacing:.0f} mm apart: agents walk exactly, their written footsteps and contacts are that coarse, "
        "and validate measures against these. have the scene near the origin, and crowd.usd placed where it belongs"
    )
    return [Problem(severity="warning", where=info.identifier, message=message)]
