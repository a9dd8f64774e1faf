"""The obstacle course of Beacco et al., Figure 1: walk, turn, slope, side steps, back steps, run, stairs."""

from dataclasses import dataclass

import numpy as np

from stagecraft.footprints import RIGHT, Footprint, Step, end_standing, lay_footprints
from stagecraft.gaits import walk_timing
from stagecraft.plan_prim import Plan, lay_on
from stagecraft.rotation import FloatArray
from stagecraft.terrains import TREAD, Surface, flat, slope, stairs

QUARTER = np.pi / 2
SIDE_TRAVEL, BACK_STEP = 0.16, -0.34
BEFORE_SLOPE, BEHIND_BALL = 0.23, 0.205
"""From the ball of the last foot on the flat to the ramp, and from the edge of a stair to the ball on it [m]."""


@dataclass(frozen=True, kw_only=True)
class Course:
    """The plan and what stands around it."""

    plan: Plan
    ground: Surface
    slope_at: FloatArray
    """Where the ramp begins, world (x, y, z) [m]; it runs along +X."""
    stairs_at: FloatArray
    """Where the stairs begin; they run along +Z."""
    blocks: tuple[tuple[FloatArray, FloatArray], ...]
    """Centre and size of each obstacle [m]."""


def obstacle_course() -> Course:
    """Lay the course; the terrain is put where the footsteps want it."""
    parts = {
        "stand": [Step(duration=0.0, overlap=0.0, width=0.17), Step(duration=0.0, overlap=0.9, width=0.17)],
        "walk": [
            Step(duration=1.42, overlap=0.15, forward=0.42, width=0.12),
            _ahead(0.58),
            _ahead(0.66),
            _ahead(0.66),
            _ahead(0.48),
            _ahead(0.36),
            _ahead(0.60),
            _ahead(0.76),
            _ahead(0.78),
            _ahead(0.64),
        ],
        "turn": [_ahead(0.54, turn=QUARTER / 6, width=0.12) for _ in range(6)],
        "slope": [_ahead(0.58, time=0.60) for _ in range(9)],
        "spin": [_ahead(0.34), *[Step(duration=0.58, overlap=0.18, forward=0.06, width=0.20, turn=-QUARTER / 4)] * 4],
        "side": [Step(duration=0.57, overlap=0.13, left=SIDE_TRAVEL, width=0.14 + SIDE_TRAVEL)] * 8,
        "back": [
            Step(duration=0.58, overlap=0.14, forward=BACK_STEP * size, width=0.15) for size in (0.6, 1.0, 1.0, 0.5)
        ],
        "careful": [_ahead(length, time=0.68, width=0.11) for length in (0.20, 0.26, 0.26, 0.40)],
        "run": [
            _ahead(0.62),
            _ahead(0.78),
            Step(duration=0.44, overlap=0.04, forward=0.78, width=0.09),
            Step(duration=0.40, overlap=-0.04, forward=0.76, width=0.10),
            *[Step(duration=0.383, overlap=-0.075, forward=length, width=0.09) for length in (0.76, 0.80, 0.80, 0.76)],
            Step(duration=0.40, overlap=-0.04, forward=0.76, width=0.10),
            Step(duration=0.44, overlap=0.05, forward=0.76, width=0.09),
            _ahead(0.70),
            _ahead(0.56),
            _ahead(0.44),
        ],
        "stairs": [_ahead(TREAD, time=0.66) for _ in range(4)],
        "stop": [
            _ahead(0.40, time=0.62),
            _ahead(0.46),
            _ahead(0.32, width=0.14),
            Step(duration=0.72, overlap=0.0, width=0.17),
        ],
    }
    prints = end_standing(lay_footprints([step for part in parts.values() for step in part], first_side=RIGHT), 1.6)
    first = dict(zip(parts, np.cumsum([0, *map(len, parts.values())]), strict=False))
    foot_before, foot_on = prints[first["slope"] - 1], prints[first["stairs"]]
    slope_at = _middle(prints, first["slope"]) * [0.0, 0.0, 1.0] + [foot_before.position[0] + BEFORE_SLOPE, 0.0, 0.0]
    stairs_at = _middle(prints, first["stairs"]) * [1.0, 0.0, 0.0] + [0.0, 0.0, foot_on.position[2] - BEHIND_BALL]
    ground = flat().placed([5.0, 0.0, 9.0])
    terrain = [ground, slope().placed(slope_at, QUARTER), stairs().placed(stairs_at)]
    gate = _middle(prints, first["side"] + 3) - [0.0, 0.0, 0.09]
    blocks = tuple((gate + [0.0, 0.5, depth], np.array([0.9, 1.0, 0.5])) for depth in (-0.56, 0.56))
    return Course(
        plan=lay_on("Course", prints, terrain), ground=ground, slope_at=slope_at, stairs_at=stairs_at, blocks=blocks
    )


def _ahead(length: float, *, time: float | None = None, turn: float = 0.0, width: float = 0.12) -> Step:
    """A walking step of `length` [m] at the walk ratio's pace."""
    _, paced, overlap = walk_timing((length / 0.6) ** 2)
    duration = time or paced
    return Step(duration=duration, overlap=overlap * duration / paced, forward=length, width=width, turn=turn)


def _middle(prints: list[Footprint], number: int) -> FloatArray:
    """Midway between footprint `number` and the next [m], height 0, shape (3,)."""
    return 0.5 * (prints[number].position + prints[number + 1].position) * [1.0, 0.0, 1.0]
