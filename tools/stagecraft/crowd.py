"""Simple plans for twelve people on hilly ground: circles, lines, runners."""

from collections.abc import Sequence

import numpy as np

from stagecraft.footprints import LEFT, RIGHT, Footprint, Step, end_standing, lay_footprints
from stagecraft.gaits import walk_timing
from stagecraft.plan_prim import Plan, lay_on
from stagecraft.rotation import about_y
from stagecraft.terrains import Surface

CIRCLES = (
    (2.2, 1.1, 0.0, 1.0),
    (2.2, 1.1, 2.1, 1.0),
    (2.2, 1.1, 4.2, 1.0),
    (3.6, 1.35, 1.0, -1.0),
    (3.6, 1.35, 4.1, -1.0),
)
"""Radius [m], speed [m/s], angle on the circle [rad], 1 to the left or -1 to the right."""
LINES = ((-5.5, -5.0, 0.0, 1.2), (-4.6, 6.0, np.pi, 0.9), (5.2, -6.0, 0.05, 1.5), (6.0, 5.5, 3.1, 1.0))
"""Start (x, z) [m], heading [rad], speed [m/s]."""
RUNNERS = ((-6.6, -6.5, 0.25, 2.2), (6.8, 6.5, -2.9, 2.0), (-6.5, 5.2, 1.9, 2.1))
"""As the lines, running."""


def crowd_plans(surfaces: Sequence[Surface], steps: int = 14) -> list[Plan]:
    """Plans of all agents on `surfaces`."""
    plans = []
    for number, (radius, speed, angle, side) in enumerate(CIRCLES):
        length, time, overlap = walk_timing(speed)
        pace = Step(duration=time, overlap=overlap, forward=length, width=0.11, turn=side * length / radius)
        place = (side * -radius * np.cos(angle), side * radius * np.sin(angle))
        prints = _stand_walk_stop(pace, steps, LEFT if number % 2 else RIGHT)
        plans.append(_put(f"Circle_{number}", prints, place, angle, surfaces))
    for number, (x, z, heading, speed) in enumerate(LINES):
        length, time, overlap = walk_timing(speed)
        prints = _stand_walk_stop(
            Step(duration=time, overlap=overlap, forward=length), steps, LEFT if number % 2 else RIGHT
        )
        plans.append(_put(f"Line_{number}", prints, (x, z), heading, surfaces))
    for number, (x, z, heading, speed) in enumerate(RUNNERS):
        pace = Step(duration=0.375, overlap=-0.09, forward=0.375 * speed, width=0.09)
        plans.append(
            _put(
                f"Runner_{number}",
                lay_footprints([pace] * steps, first_side=LEFT, last_contact=pace.duration + pace.overlap),
                (x, z),
                heading,
                surfaces,
            )
        )
    return plans


def _stand_walk_stop(pace: Step, steps: int, side: int) -> list[Footprint]:
    """Standing, `steps` steps like `pace`, standing."""
    half = Step(duration=0.6, overlap=0.16, forward=0.7 * pace.forward, width=0.12, turn=0.7 * pace.turn)
    stand = [Step(duration=0.0, overlap=0.0, width=0.17), Step(duration=0.0, overlap=0.8, width=0.17)]
    first = Step(duration=1.32, overlap=0.15, forward=half.forward, width=0.12, turn=half.turn)
    last = Step(duration=0.7, overlap=0.0, width=0.17)
    return end_standing(lay_footprints([*stand, first, *[pace] * (steps - 4), half, last], first_side=side), 1.4)


def _put(
    name: str, prints: list[Footprint], place: tuple[float, float], heading: float, surfaces: Sequence[Surface]
) -> Plan:
    """The footprints turned to `heading` and moved so that they begin at `place` (x, z), on the surfaces."""
    turn = about_y(heading)
    moved = [
        Footprint(
            side=footprint.side,
            position=turn @ footprint.position + [place[0], 0.0, place[1]],
            yaw=footprint.yaw + heading,
            strike=footprint.strike,
            liftoff=footprint.liftoff,
            roll=footprint.roll,
        )
        for footprint in prints
    ]
    return lay_on(name, moved, surfaces)
