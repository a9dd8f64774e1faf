"""People with goals, and level ground for them."""

import numpy as np

from tests.planning.terrains import slab, terrain_of
from usdfoot.planning.scenario import Scenario, Seeker

FLAT = terrain_of([slab((-8.0, 8.0), (-8.0, 8.0), (0.5, 0.5))])


def seeker(name: str, start, goal, *, height: float = 0.5, **options) -> Seeker:
    (x, z), (gx, gz) = start, goal
    return Seeker(name=name, start=np.array([x, height, z]), goals=np.array([(gx, height, gz)]), **options)


def scenario(*seekers: Seeker, obstacles=()) -> Scenario:
    return Scenario(seekers=seekers, obstacles=tuple(obstacles), bounds=None)
