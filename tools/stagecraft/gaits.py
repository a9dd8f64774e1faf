"""The clips: every gait as steps, the interval to keep, and whether it loops.

Walking keeps the walk ratio, step length over cadence = 0.006 m per step/min (Sekiya and Nagasaki 1998), so
T = 0.36 / L, at most 0.7 s; the feet stand 70 to 58 % of the stride from 0.5 to 2 m/s (Murray 1964). Running: step
times and contact times after Novacheck (1998) and Cavagna (1988). Durations are whole sixtieths of a second, so that
loops close on a frame.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stagecraft.footprints import LEFT, RIGHT, Footprint, Step, end_standing, lay_footprints
from stagecraft.rolls import run_roll, side_roll, step_roll, walk_roll

DEGREE = np.pi / 180.0
PADDING = 4
"""Steps laid before and after the interval that is kept."""


@dataclass(frozen=True, kw_only=True)
class ClipPlan:
    """What one clip shows."""

    name: str
    prints: tuple[Footprint, ...]
    start: float
    """Beginning of the interval to keep [s]."""
    end: float
    """Its end [s]."""
    cyclic: bool = False
    """The end goes on into the beginning."""
    breath: float = 0.0
    """Breathing and swaying in place, 0..1."""


def all_clips() -> list[ClipPlan]:
    """Every clip of the library."""
    return [*walks(), *runs(), *backwards(), *sides(), *diagonals(), *turns(), *in_place(), *starts_and_stops()]


def walks() -> list[ClipPlan]:
    """Walks straight ahead: eight speeds, then unusual lengths and widths."""
    plain = [
        _ahead(f"walk_{speed * 100:03.0f}", *walk_timing(speed)) for speed in (0.5, 0.7, 0.9, 1.1, 1.3, 1.5, 1.75, 2.0)
    ]
    return [
        *plain,
        _ahead("walk_careful", 0.20, 0.70, 0.28),
        _ahead("walk_careful_narrow", 0.24, 0.68, 0.24, width=0.03),
        _ahead("walk_careful_wide", 0.16, 0.68, 0.24, width=0.27),
        _ahead("walk_long", 0.95, 0.50, 0.08),
        _ahead("walk_longest", 1.10, 0.50, 0.05),
        _ahead("walk_narrow", 0.50, 0.55, 0.13, width=0.02),
        _ahead("walk_narrow_long", 0.80, 0.50, 0.09, width=0.03),
        _ahead("walk_wide", 0.45, 0.60, 0.16, width=0.28),
        _ahead("walk_wide_long", 0.75, 0.55, 0.11, width=0.26),
        _ahead("walk_astride", 0.30, 0.65, 0.20, width=0.42),
        _ahead("walk_astride_long", 0.65, 0.60, 0.13, width=0.40),
        _ahead("walk_astride_longest", 0.92, 0.55, 0.08, width=0.28),
        _ahead("walk_high_knees", 0.40, 0.70, 0.18, lift=0.22),
    ]


def runs() -> list[ClipPlan]:
    """Jogs and runs with flight: speed, step time and contact time."""
    table = (
        ("jog_180", 1.8, 0.383, 0.300),
        ("jog_220", 2.2, 0.375, 0.285),
        ("run_260", 2.6, 0.367, 0.268),
        ("run_320", 3.2, 0.350, 0.240),
        ("run_400", 4.0, 0.333, 0.205),
    )
    plain = [
        _ahead(name, speed * _sixtieths(time), time, contact - time, width=0.09, flight=True)
        for name, speed, time, contact in table
    ]
    return [
        *plain,
        _ahead("run_bounding", 1.60, 0.417, -0.180, width=0.09, flight=True),
        _ahead("run_wide_long", 1.25, 0.367, -0.110, width=0.22, flight=True),
        _ahead("run_wide", 0.95, 0.367, -0.090, width=0.30, flight=True),
        _ahead("leap_slow", 1.15, 0.483, -0.110, width=0.10, flight=True),
    ]


def backwards() -> list[ClipPlan]:
    """Walking backward, ball first."""
    return [
        _ahead("back_040", -0.24, 0.60, 0.16, width=0.14),
        _ahead("back_070", -0.40, 0.57, 0.13, width=0.13),
        _ahead("back_110", -0.58, 0.53, 0.10, width=0.12),
        _ahead("back_wide", -0.42, 0.60, 0.14, width=0.32),
        _ahead("back_astride", -0.16, 0.62, 0.18, width=0.27),
        _ahead("back_narrow", -0.28, 0.60, 0.15, width=0.04),
    ]


def sides() -> list[ClipPlan]:
    """Side steps: one foot opens by the travel, the other closes; the feet never cross."""
    return [
        _sideways("side_left_020", 0.10, 0.0, 0.55),
        _sideways("side_left_035", 0.18, 0.0, 0.58),
        _sideways("side_left_050", 0.255, 0.0, 0.62),
        _sideways("side_right_028", -0.14, 0.0, 0.55),
        _sideways("side_right_042", -0.21, 0.0, 0.60),
        _sideways("side_right_050", -0.25, 0.0, 0.55, gap=0.16),
    ]


def diagonals() -> list[ClipPlan]:
    """Steps ahead or back and to one side."""
    return [
        _sideways("diagonal_left_25", 0.10, 0.30, 0.55),
        _sideways("diagonal_left_50", 0.20, 0.20, 0.60),
        _sideways("diagonal_left_long", 0.17, 0.55, 0.57),
        _sideways("diagonal_right_25", -0.15, 0.42, 0.55),
        _sideways("diagonal_right_50", -0.25, 0.35, 0.60),
        _sideways("diagonal_right_long", -0.09, 0.70, 0.55),
        _sideways("diagonal_back_left", 0.13, -0.22, 0.60),
        _sideways("diagonal_back_left_wide", 0.22, -0.16, 0.62),
        _sideways("diagonal_back_right", -0.17, -0.34, 0.58),
        _sideways("diagonal_back_right_wide", -0.22, -0.30, 0.62),
    ]


def turns() -> list[ClipPlan]:
    """Curves by their radius, then turns on the spot."""
    table = (
        ("turn_left_100", 0.50, 0.58, 1.0),
        ("turn_left_200", 0.60, 0.55, 2.0),
        ("turn_left_400", 0.70, 0.52, 4.0),
        ("turn_right_080", 0.42, 0.60, -0.8),
        ("turn_right_150", 0.56, 0.57, -1.5),
        ("turn_right_300", 0.66, 0.53, -3.0),
    )
    curves = [
        _ahead(name, length, time, 0.12, width=0.12, turn=length / radius) for name, length, time, radius in table
    ]
    spot = [
        _ahead(name, 0.0, time, 0.20, width=0.20, turn=angle * DEGREE)
        for name, time, angle in (("turn_left_spot", 0.60, 28.0), ("turn_right_spot", 0.57, -38.0))
    ]
    jog = _ahead("jog_turn_left", 0.80, 0.383, -0.07, width=0.10, turn=0.80 / 4.0, flight=True)
    return [*curves, *spot, jog]


def in_place() -> list[ClipPlan]:
    """Stepping on the spot and standing."""
    stand = end_standing(_lay([Step(duration=0.0, overlap=1.0, width=0.18, roll=side_roll(0.0))] * 2, RIGHT), 6.0)
    return [
        _ahead("march", 0.0, 0.53, 0.11, width=0.17, lift=0.16),
        _ahead("shuffle", 0.0, 0.60, 0.22, width=0.19),
        ClipPlan(name="stand", prints=tuple(stand), start=1.0, end=5.0, cyclic=True, breath=1.0),
    ]


def starts_and_stops() -> list[ClipPlan]:
    """From standing into gait and back, and from one gait into the other."""
    return [
        _starting("start_walk_right", RIGHT),
        _starting("start_walk_left", LEFT),
        _stopping("stop_walk_right", RIGHT),
        _stopping("stop_walk_left", LEFT),
        _gait_change("walk_to_run", up=True),
        _gait_change("run_to_walk", up=False),
    ]


def walk_timing(speed: float) -> tuple[float, float, float]:
    """Step length [m], step time [s] and double support [s] of a walk at `speed` [m/s]."""
    time = _sixtieths(min(0.36 / (0.6 * np.sqrt(speed)), 0.7))
    stance = np.interp(speed, (0.5, 1.3, 2.0), (0.69, 0.62, 0.575))
    return speed * time, time, float((2.0 * stance - 1.0) * time)


def _ahead(
    name: str,
    length: float,
    time: float,
    overlap: float,
    *,
    width: float = 0.12,
    turn: float = 0.0,
    lift: float = 0.04,
    flight: bool = False,
) -> ClipPlan:
    """Equal steps straight ahead (or back, or on a curve)."""
    time = _sixtieths(time)
    roll = step_roll(length, 0.0, length / time, flight=flight)
    if lift != 0.04:
        roll = walk_roll(max(length, 0.2), lift=lift)
    step = Step(duration=time, overlap=overlap, forward=length, width=width, turn=turn, roll=roll)
    return _loop(name, [step])


def _sideways(name: str, left: float, forward: float, time: float, *, gap: float = 0.14) -> ClipPlan:
    """Equal steps with a part to the side; the feet close to `gap` [m] apart."""
    time = _sixtieths(time)
    step = Step(
        duration=time,
        overlap=0.22 * time,
        forward=forward,
        left=left,
        width=gap + abs(left),
        roll=step_roll(forward, left),
    )
    return _loop(name, [step])


def _loop(name: str, pattern: Sequence[Step]) -> ClipPlan:
    """Two or three strides of a repeated pattern, beginning somewhere in the stride (told by the name's letters)."""
    duration = sum(step.duration for step in pattern) * (2 if len(pattern) % 2 else 1)
    strides = 3 if duration < 1.0 else 2
    steps = list(pattern) * ((2 * PADDING + 2 * strides + 3) // len(pattern))
    prints = _lay(steps, LEFT)
    start = prints[PADDING].strike + duration * (sum(map(ord, name)) % 12) / 12.0
    return ClipPlan(name=name, prints=tuple(prints), start=start, end=start + strides * duration, cyclic=True)


def _starting(name: str, side: int) -> ClipPlan:
    """Standing for 0.9 s, then into a walk at 1.3 m/s."""
    length, time, overlap = walk_timing(1.3)
    steps = [
        Step(duration=0.0, overlap=0.0, width=0.17, roll=step_roll(0.45, 0.0)),
        Step(duration=0.0, overlap=0.90, width=0.17, roll=step_roll(0.55, 0.0)),
        Step(duration=1.42, overlap=0.15, forward=0.42, width=0.12, roll=step_roll(0.5, 0.0)),
        Step(duration=0.57, overlap=0.13, forward=0.58, roll=step_roll(0.6, 0.0)),
        *[Step(duration=time, overlap=overlap, forward=length, roll=step_roll(length, 0.0))] * 6,
    ]
    prints = _lay(steps, side)
    return ClipPlan(name=name, prints=tuple(prints), start=0.1, end=prints[6].strike)


def _stopping(name: str, side: int) -> ClipPlan:
    """From a walk at 1.3 m/s to standing with both feet, 1 s of it."""
    length, time, overlap = walk_timing(1.3)
    steady = Step(duration=time, overlap=overlap, forward=length, roll=step_roll(length, 0.0))
    steps = [
        *[steady] * 7,
        Step(duration=0.57, overlap=0.15, forward=0.55, roll=step_roll(0.5, 0.0)),
        Step(duration=0.62, overlap=0.22, forward=0.36, width=0.14, roll=step_roll(0.3, 0.0)),
        Step(duration=0.72, overlap=0.0, forward=0.0, width=0.17, roll=side_roll(0.4)),
    ]
    prints = end_standing(_lay(steps, side), 1.6)
    return ClipPlan(name=name, prints=tuple(prints), start=prints[4].strike + 0.1, end=prints[-1].strike + 1.4)


def _gait_change(name: str, *, up: bool) -> ClipPlan:
    """Walk at 1.6 m/s into a run at 2.6 m/s, or back."""
    length, time, overlap = walk_timing(1.6)
    walking = [Step(duration=time, overlap=overlap, forward=length, roll=step_roll(length, 0.0))] * 6
    between = [
        Step(duration=0.45, overlap=0.04, forward=0.82, roll=step_roll(0.8, 0.0)),
        Step(duration=0.40, overlap=-0.05, forward=0.85, width=0.10, roll=run_roll(2.2)),
    ]
    running = [Step(duration=0.367, overlap=-0.10, forward=0.95, width=0.09, roll=run_roll(2.6))] * 6
    steps = [*walking, *between, *running] if up else [*running, *between[::-1], *walking]
    prints = _lay(steps, RIGHT)
    return ClipPlan(name=name, prints=tuple(prints), start=prints[4].strike + 0.05, end=prints[10].strike + 0.05)


def _lay(steps: Sequence[Step], side: int) -> list[Footprint]:
    return lay_footprints(steps, first_side=side)


def _sixtieths(time: float) -> float:
    """The nearest whole number of sixtieths of a second."""
    return round(float(time) * 60.0) / 60.0
