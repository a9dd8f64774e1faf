"""Biped: which joints of a skeleton are pelvis, hips, knees, ankles and balls."""

from __future__ import annotations

from dataclasses import dataclass

from usdfoot.maths.types import FloatArray

__all__ = ["LEFT", "RIGHT", "SIDES", "Biped"]

LEFT, RIGHT = 0, 1
SIDES = ("left", "right")


@dataclass(frozen=True, kw_only=True)
class Biped:
    """Leg joints of a skeleton (design: UsdfootBipedAPI; [P] 2.2). Pairs are (left, right)."""

    pelvis: int
    """Joint index of the pelvis: the lowest joint above both hips that carries the body's motion."""
    hips: tuple[int, int]
    knees: tuple[int, int]
    ankles: tuple[int, int]
    balls: tuple[int, int]
    """Joint indices, each below the one before it in the same leg."""
    ball_heights: FloatArray
    """Height of the ball joint above the sole with the foot flat [m], shape (2,)."""
    com: FloatArray
    """Centre of mass from the pelvis in the rest pose [m], canonical axes, shape (3,)."""
    nominal_leg_length: float
    """Comfortable distance from hip to ankle [m] ([P] 2.2)."""
    maximal_leg_length: float
    """Distance from hip to ankle with the knee straight [m]."""
