"""Proportions: what a planner must know of the body that will walk."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.hip_spacing import hip_width
from usdfoot.analysis.timing import HUMAN_LEG, TimingRule
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Pose, Skeleton
from usdfoot.planning.habits import PEOPLE, Habits
from usdfoot.retarget.rig import standing_pose

__all__ = ["Proportions", "proportions_of"]


@dataclass(frozen=True, kw_only=True)
class Proportions:
    """Sizes of a character, and how it steps; the defaults are those of a person of 1.75 m."""

    leg_length: float = HUMAN_LEG
    """Hip to ankle with the knee straight [m]."""
    foot_length: float = 0.13
    """Ankle to ball along the ground, foot flat [m]."""
    heel: float = 0.19
    """From the ball back to the heel [m]: 0.4 of the distance from ankle to ball behind the ankle (design.md 2)."""
    hip_width: float = 0.18
    """Between the hip joints [m]."""
    habits: Habits = PEOPLE
    """How it steps."""

    @property
    def toe(self) -> float:
        """From the ball ahead to the toes [m]."""
        return 0.7 * self.foot_length

    @property
    def half_width(self) -> float:
        """From the foot's middle line to its edge [m]."""
        return 0.4 * self.foot_length

    @property
    def step_width(self) -> float:
        """Between the balls of the feet across the way, in an easy walk [m]."""
        return self.habits.step_width * self.leg_length or 0.65 * self.hip_width

    @property
    def timing(self) -> TimingRule:
        """How long its steps take."""
        return self.habits.timing(self.leg_length)

    @property
    def widest_step(self) -> float:
        """How far the feet come apart across in a side step [m]."""
        return self.leg_length

    @property
    def highest_step(self) -> float:
        """Highest rise of one step [m]."""
        return 0.58 * self.leg_length

    def span(self, legs: float) -> float:
        """From foot to foot when they are so many leg lengths apart along the way and the hips across it [m]."""
        return float(np.hypot(legs * self.leg_length, self.hip_width))

    def half_depth(self, radius: float) -> float:
        """Half the width [m] that a body of a radius [m] needs sideways: half as deep as broad; heels reach back."""
        return min(radius, max(0.5 * radius, self.heel))


def proportions_of(skeleton: Skeleton, biped: Biped, bind: Pose | None = None) -> Proportions:
    """Proportions of a character, from the pose in which it stands.

    Args:
        skeleton: With the rest pose.
        biped: Its legs.
        bind: The pose it was rigged in, if it has one.
    """
    positions = standing_pose(skeleton, biped, bind).places
    feet = positions[list(biped.balls)] - positions[list(biped.ankles)]
    level = float(np.hypot(feet[:, 0], feet[:, 2]).mean())
    return Proportions(
        leg_length=biped.maximal_leg_length,
        foot_length=level,
        heel=level + 0.4 * float(np.linalg.norm(feet, axis=1).mean()),
        hip_width=hip_width(skeleton, biped),
    )
