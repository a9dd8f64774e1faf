"""Displacement: how an agent is moved as a whole, over the ground, up or down, and turned about the vertical."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.maths import planar, quaternion
from usdfoot.maths.planar import GROUND_AXES
from usdfoot.maths.types import FloatArray
from usdfoot.model.contact_table import lay_contacts
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.trajectory import RootTrajectory

__all__ = ["STILL", "Displacement", "start_of"]


@dataclass(frozen=True, kw_only=True)
class Displacement:
    """Maps p to p turned about the vertical through the origin, plus a translation.

    As a place it says where somebody stands and faces: where it puts who stands at the origin with heading 0.
    """

    translation: FloatArray
    """[m], shape (3,)."""
    yaw: float
    """[rad]."""

    @classmethod
    def between(cls, start: Displacement, end: Displacement) -> Displacement:
        """The one that takes who stands at one place to another."""
        turn = cls(translation=np.zeros(3), yaw=end.yaw - start.yaw)
        return cls(translation=end.translation - turn.points(start.translation), yaw=turn.yaw)

    def points(self, points: FloatArray) -> FloatArray:
        """Points (..., 3) [m] displaced."""
        moved = np.array(points, dtype=float)
        moved[..., GROUND_AXES] = planar.rotate(np.array(self.yaw), moved[..., GROUND_AXES])
        return moved + self.translation

    def walk(self, walk: FootstepPlan | RootTrajectory) -> FootstepPlan | RootTrajectory:
        """What somebody walks, displaced."""
        return self.trajectory(walk) if isinstance(walk, RootTrajectory) else self.plan(walk)

    def plan(self, plan: FootstepPlan) -> FootstepPlan:
        """A plan displaced."""
        turn = quaternion.yaw_quaternion(np.array(self.yaw))
        turned = quaternion.compose(turn, plan.orientations) if self.yaw else plan.orientations
        return replace(plan, positions=self.points(plan.positions), orientations=turned)

    def trajectory(self, trajectory: RootTrajectory) -> RootTrajectory:
        """A trajectory displaced."""
        yaws = None if trajectory.yaws is None else trajectory.yaws + self.yaw
        return replace(
            trajectory,
            positions=self.points(trajectory.positions),
            yaws=yaws,
            rest_yaw=trajectory.rest_yaw + self.yaw,
        )


STILL = Displacement(translation=np.zeros(3), yaw=0.0)
"""Moves nothing."""


def start_of(walk: FootstepPlan | RootTrajectory) -> Displacement:
    """Where the root of who walks a plan or follows a trajectory starts.

    Of a plan it is the middle of its first two contacts, as `lay_root` lays it in the engine.
    """
    if isinstance(walk, RootTrajectory):
        return _start_of_trajectory(walk)
    contacts = lay_contacts([walk])
    return Displacement(translation=contacts.positions[:2].mean(axis=0), yaw=float(contacts.headings[1]))


def _start_of_trajectory(trajectory: RootTrajectory) -> Displacement:
    """Where a trajectory begins and faces there."""
    if trajectory.yaws is not None:
        return Displacement(translation=trajectory.positions[0], yaw=float(trajectory.yaws[0]))
    ways = np.diff(trajectory.positions, axis=0)[:, GROUND_AXES]
    ahead = ways[np.linalg.norm(ways, axis=1) > 0.0]
    yaw = float(planar.yaw_of(ahead[0])) if len(ahead) else trajectory.rest_yaw
    return Displacement(translation=trajectory.positions[0], yaw=yaw)
