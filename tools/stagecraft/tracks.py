"""Footprints of the results of van de Panne 1997, for characters that physics moves (its Figures 15 to 19)."""

from dataclasses import dataclass, replace

import numpy as np

from stagecraft.footprints import LEFT, RIGHT, Footprint, Roll, Step, end_standing, lay_footprints
from stagecraft.plan_prim import Plan, lay_on
from stagecraft.terrains import SPIRAL_ANGLE, SPIRAL_RADIUS, SPIRAL_STAIRS, Surface, flat, hills, spiral_stairs
from usdfoot.analysis.footstep_times import time_footsteps
from usdfoot.analysis.timing import TimingRule

FIRST_STAND = 0.4
"""Time a character stands before it walks [s]."""
BIRD_LEG = 0.596
"""Hip to ankle of the bird with the knee straight [m]."""


@dataclass(frozen=True, kw_only=True)
class Track:
    """A plan and the terrain files it was laid on, at the origin."""

    plan: Plan
    terrains: tuple[str, ...]


def bird_walk() -> Track:
    """A bird that walks a gentle double bend (Figure 15)."""
    turns = 0.16 * np.sin(np.linspace(0.0, 2.0 * np.pi, 15))
    step = Step(duration=0.45, overlap=0.07, forward=0.42, width=0.13)
    steps = [*_stand(step), *(replace(step, turn=float(turn)) for turn in turns), replace(step, forward=0.0)]
    return _track("BirdWalk", end_standing(_standing(steps), 0.8), {"flat": flat()})


def dinosaur_stairs() -> Track:
    """A dinosaur that climbs a spiral staircase (Figure 16), a stair a step."""
    duration, overlap, width = 0.70, 0.14, 0.34
    middles = [-1.0, -1.0, *(stair + 0.32 for stair in range(SPIRAL_STAIRS)), SPIRAL_STAIRS - 0.68 + 1.0]
    middles = [*middles, middles[-1]]
    prints = []
    for number, middle in enumerate(middles):
        side = number % 2
        angle = SPIRAL_ANGLE * middle
        radius = SPIRAL_RADIUS + (0.5 - (side == LEFT)) * width  # the left foot is the inner one
        strike = 0.0 if number < 2 else 0.6 + duration * (number - 2)
        prints.append(
            Footprint(
                side=side,
                position=np.array([SPIRAL_RADIUS - radius * np.cos(angle), 0.0, radius * np.sin(angle)]),
                yaw=angle,
                strike=strike,
                liftoff=strike + duration + overlap,
                roll=Roll(),
            )
        )
    prints[0] = replace(prints[0], liftoff=0.6 - 0.75 * duration)
    prints[1] = replace(prints[1], liftoff=0.6 + overlap)
    return _track("DinosaurStairs", end_standing(prints, 0.9), {"flat": flat(), "spiral": spiral_stairs()})


def dinosaur_leaps() -> Track:
    """A dinosaur that walks a turn, takes a large leap and a small one (Figure 17)."""
    step = Step(duration=0.66, overlap=0.12, forward=0.85, width=0.34)
    walk = [replace(step, turn=0.20) for _ in range(6)]
    run_up = replace(step, duration=0.55, overlap=0.06, forward=1.00)
    large = replace(step, duration=0.98, overlap=-0.56, forward=2.00)
    small = replace(step, duration=0.74, overlap=-0.32, forward=1.30)
    after = replace(step, duration=0.60, overlap=0.08, forward=0.95)
    steps = [*_stand(step), *walk, run_up, large, after, after, small, after, step, replace(step, forward=0.0)]
    return _track("DinosaurLeaps", end_standing(_standing(steps), 1.0), {"flat": flat()})


def human_run() -> Track:
    """A person who runs over hills (Figure 18): flights of 0.1 s, flat arcs."""
    steps = [Step(duration=0.34, overlap=-0.10, forward=0.92, width=0.10, turn=0.02) for _ in range(14)]
    prints = [_moved(footprint, [-1.0, 0.0, -6.2]) for footprint in lay_footprints(steps, first_side=RIGHT)]
    last = len(prints) - 1
    prints[last] = replace(prints[last], liftoff=prints[last].strike + 0.24)
    return _track("HumanRun", prints, {"hills": hills()})


def bird_tracks() -> Track:
    """Tracks of a bird timed by the distances alone, with two small leaps where they are long (Figure 19)."""
    lengths = [0.30, 0.36, 0.34, 0.38, 0.72, 0.36, 0.33, 0.36, 0.78, 0.38, 0.34, 0.30]
    steps = [Step(duration=0.5, overlap=0.1, forward=length, width=0.13, turn=0.05) for length in lengths]
    stand = Step(duration=0.5, overlap=0.1, width=0.13)
    prints = lay_footprints([stand, stand, *steps, stand], first_side=LEFT)
    times = time_footsteps(
        np.array([footprint.position for footprint in prints]),
        TimingRule(leg_length=BIRD_LEG),
        starts_standing=True,
        ends_standing=True,
    )
    timed = [
        replace(footprint, strike=float(strike), liftoff=float(liftoff))
        for footprint, strike, liftoff in zip(prints, times.strike_times, times.liftoff_times, strict=True)
    ]
    return _track("BirdTracks", timed, {"flat": flat()})


def _track(name: str, prints: list[Footprint], terrains: dict[str, Surface]) -> Track:
    return Track(plan=lay_on(name, prints, list(terrains.values())), terrains=tuple(terrains))


def _stand(step: Step) -> list[Step]:
    """Two footprints side by side to start from."""
    return [replace(step, forward=0.0), replace(step, forward=0.0)]


def _standing(steps: list[Step]) -> list[Footprint]:
    """Footprints that start standing: the first two strike together."""
    prints = lay_footprints(steps, first_side=LEFT)
    wait = FIRST_STAND - prints[1].strike
    later = [
        replace(footprint, strike=footprint.strike + wait, liftoff=footprint.liftoff + wait) for footprint in prints
    ]
    swing = 0.75 * steps[2].duration
    return [
        replace(later[0], strike=0.0, liftoff=later[2].strike - swing),
        replace(later[1], strike=0.0),
        *later[2:],
    ]


def _moved(footprint: Footprint, offset: list[float]) -> Footprint:
    return replace(footprint, position=footprint.position + np.array(offset))
