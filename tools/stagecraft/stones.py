"""Stepping stones over water, after Beacco et al., Figure 7: twenty stones on a curve, no two steps alike."""

from dataclasses import dataclass, replace

import numpy as np

from stagecraft.footprints import LEFT, OUT_TOE, Footprint, Step, end_standing, lay_footprints
from stagecraft.plan_prim import Plan, lay_on
from stagecraft.rolls import step_roll
from stagecraft.terrains import Surface, bed, stone

LENGTHS = (0.46, 0.55, 0.62, 0.50, 0.70, 0.58, 0.42, 0.64, 0.74, 0.52, 0.60, 0.46, 0.66, 0.56, 0.48, 0.62, 0.54, 0.40)
WIDTHS = (0.16, 0.14, 0.20, 0.11, 0.16, 0.24, 0.14, 0.10, 0.18, 0.25, 0.13, 0.18, 0.12, 0.21, 0.15, 0.12, 0.17, 0.17)
TURNS = (
    0.00,
    0.06,
    0.10,
    0.12,
    0.08,
    0.14,
    0.12,
    0.04,
    -0.04,
    -0.12,
    -0.16,
    -0.14,
    -0.10,
    -0.12,
    -0.06,
    0.05,
    0.04,
    0.0,
)
RISES = (
    0.03,
    -0.05,
    0.08,
    0.04,
    -0.06,
    -0.04,
    0.10,
    0.02,
    -0.09,
    0.06,
    0.05,
    -0.08,
    -0.03,
    0.09,
    -0.04,
    -0.05,
    0.03,
    0.0,
)
"""Length [m], width [m], turn [rad] and rise [m] of each step."""
START_HEIGHT, WATER = 0.25, -0.05


@dataclass(frozen=True, kw_only=True)
class Crossing:
    """The plan, and the stones and water it crosses."""

    plan: Plan
    stones: tuple[Surface, ...]
    water: Surface


def stepping_stones() -> Crossing:
    """Lay the footsteps, then put a stone under every one (one for both feet at each end)."""
    steps = [Step(duration=0.0, overlap=0.0, width=0.17), Step(duration=0.0, overlap=0.9, width=0.17)]
    for number, (length, width, turn) in enumerate(zip(LENGTHS, WIDTHS, TURNS, strict=True)):
        duration = 0.58 + 0.12 * abs(length - 0.55) + 0.5 * abs(RISES[number])
        steps.append(
            Step(
                duration=duration + (0.85 if number == 0 else 0.0),
                overlap=0.15,
                forward=length,
                width=width,
                turn=turn,
                roll=step_roll(length, 0.0),
            )
        )
    steps.append(Step(duration=0.75, overlap=0.0, width=0.18))
    prints = end_standing(lay_footprints(steps, first_side=LEFT), 1.6)
    heights = START_HEIGHT + np.concatenate([[0.0, 0.0], np.cumsum(RISES), [sum(RISES)]])
    placed = [
        replace(footprint, position=footprint.position + [0.0, height, 0.0])
        for footprint, height in zip(prints, heights, strict=True)
    ]
    stones = tuple(
        _stone_under(number, group)
        for number, group in enumerate([placed[:2], *[[footprint] for footprint in placed[2:-2]], placed[-2:]])
    )
    places = np.array([footprint.position for footprint in placed])
    low, high = places.min(axis=0) - 1.3, places.max(axis=0) + 1.3
    water = bed((low + high)[[0, 2]] / 2, (high - low)[[0, 2]], WATER)
    return Crossing(plan=lay_on("Stones", placed, stones), stones=stones, water=water)


def _stone_under(number: int, feet: list[Footprint]) -> Surface:
    """A stone that holds the whole soles of `feet`; the middle of a sole lies 6 cm behind its ball."""
    yaw = float(np.mean([footprint.yaw for footprint in feet]))
    middle = np.mean([footprint.position for footprint in feet], axis=0) - 0.06 * np.array(
        [np.sin(yaw), 0, np.cos(yaw)]
    )
    both = len(feet) > 1
    radius = 0.30 if both else 0.185 + 0.012 * (number % 3)
    return stone(
        f"Stone_{number:02d}",
        middle[[0, 2]],
        yaw=yaw - (0.0 if both else OUT_TOE / 2),
        radius=radius,
        squash=1.0 if both else 0.66,
        top=float(feet[0].position[1]),
        bottom=WATER - 0.25,
    )
