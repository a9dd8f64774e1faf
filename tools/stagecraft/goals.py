"""What the planners need: a plaza with people who want to cross it, and a river with stones and dead ends."""

from dataclasses import dataclass

import numpy as np

from stagecraft.rotation import FloatArray
from stagecraft.terrains import Surface, bed, stone

PLAZA = 24.0
"""Side of the plaza [m]."""
FOUNTAIN = (1.0, -0.5, 2.2)
"""Centre x and z, and radius [m]."""
KIOSK = ((-7.0, 3.0), (-3.0, 3.0), (-3.0, 4.2), (-5.8, 4.2), (-5.8, 7.0), (-7.0, 7.0))
"""Corners (x, z) of an L-shaped building, clockwise in (x, z) [m]."""
BENCHES = ((6.5, 5.0), (6.5, -5.5), (-6.0, -5.0))
"""Centres (x, z) of benches of 2 m by 0.5 m [m]."""
STEP_STONES = 15
"""Stones on the way over the river."""


@dataclass(frozen=True, kw_only=True)
class Visitor:
    """Someone with a goal."""

    name: str
    start: tuple[float, float]
    """(x, z) [m]"""
    yaw: float
    """[degrees]"""
    goal: tuple[float, float]
    """(x, z) [m]"""
    speed: float
    """[m/s]"""


def plaza_visitors() -> list[Visitor]:
    """Twenty-four people, six from each side, who cross to the other side and meet in the middle."""
    edge = 0.5 * PLAZA - 1.5
    visitors = []
    for side, (x, z, yaw) in enumerate(((0, -1, 0.0), (1, 0, -90.0), (0, 1, 180.0), (-1, 0, 90.0))):
        for number in range(6):
            along, there = 1.6 * (number - 2.5), 1.6 * (2.5 - ((number * 5 + side) % 6))
            visitors.append(
                Visitor(
                    name=f"Visitor_{side}{number}",
                    start=(x * edge + along * abs(z), z * edge + along * abs(x)),
                    yaw=yaw,
                    goal=(-x * edge + there * abs(z), -z * edge + there * abs(x)),
                    speed=1.05 + 0.06 * ((3 * number + side) % 6),
                )
            )
    return visitors


@dataclass(frozen=True, kw_only=True)
class River:
    """Banks, stones and water."""

    surfaces: tuple[Surface, ...]
    start: FloatArray
    """[m], shape (3,)."""
    goal: FloatArray
    """[m], shape (3,)."""


def river() -> River:
    """A way of stones in a bow from bank to bank, and beside it a straight one whose last stones are missing."""
    side = np.array([0.09 if number % 2 else -0.09 for number in range(STEP_STONES)])
    share = (np.arange(STEP_STONES) + 1.0) / (STEP_STONES + 1.0)
    along = -4.6 + 9.2 * share
    bow = np.column_stack([1.9 * np.sin(np.pi * share) + side, along])
    straight = np.column_stack([side - 0.25, along])[2:9]
    heights = 0.24 + 0.05 * np.sin(5.0 * np.arange(STEP_STONES))
    stones = [
        stone(
            f"{name}_{number:02d}", place, yaw=0.4 * number, radius=0.19, squash=0.85, top=heights[number], bottom=-0.3
        )
        for name, places in (("Stone", bow), ("Straight", straight))
        for number, place in enumerate(places)
    ]
    banks = [
        stone(name, (0.0, z), yaw=0.0, radius=1.0, squash=1.5, top=0.25, bottom=-0.3)
        for name, z in (("BankSouth", -5.4), ("BankNorth", 5.4))
    ]
    water = bed((0.0, 0.0), (7.0, 14.0), -0.05)
    return River(surfaces=(*banks, *stones, water), start=np.array([0.0, 0.25, -5.0]), goal=np.array([0.0, 0.25, 5.0]))
