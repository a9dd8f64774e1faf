"""Hypothesis strategies: rotations, landings as libraries have them, footstep plans that are valid."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from usdfoot.maths import planar, quaternion
from usdfoot.model.plan import FootstepPlan

__all__ = ["angles", "coordinates", "footstep_plans", "landings", "seeds", "unit_quaternions", "vectors"]

seeds = st.integers(0, 2**31 - 1)
"""Seeds of numpy generators, for cases in which the numbers themselves do not matter."""
angles = st.floats(-10.0, 10.0)
"""Angles [rad], several turns wide."""
coordinates = st.floats(-1.5, 1.5, allow_subnormal=False)
"""Coordinates of landings [m]."""


def vectors(components: int, *, size: float = 5.0) -> st.SearchStrategy[np.ndarray]:
    """Vectors with components within `size`, shape (components,)."""
    return arrays.arrays(float, components, elements=st.floats(-size, size, allow_subnormal=False))


@st.composite
def unit_quaternions(draw: st.DrawFn, count: int = 1) -> np.ndarray:
    """Unit quaternions xyzw of either sign, identity and half turns included, shape (count, 4)."""
    special = np.concatenate([np.eye(4), -np.eye(4)])
    generator = np.random.default_rng(draw(seeds))
    values = quaternion.normalised(generator.normal(size=(count, 4)))
    for i in range(count):
        if draw(st.integers(0, 4)) == 0:
            values[i] = special[draw(st.integers(0, 7))]
    return values


@st.composite
def landings(draw: st.DrawFn, *, smallest: int = 1, largest: int = 40) -> np.ndarray:
    """Landings of a library (E, 2) [m]: scattered, gridded, on a line or a circle; some nearly or exactly repeated."""
    count = draw(st.integers(smallest, largest))
    kind = draw(st.sampled_from(["scattered", "drawn", "grid", "line", "circle"]))
    generator = np.random.default_rng(draw(seeds))
    if kind == "drawn":
        points = draw(arrays.arrays(float, (count, 2), elements=coordinates))
    elif kind == "scattered":
        points = generator.normal([0.2, 0.5], [0.15, 0.4], (count, 2))
    elif kind == "grid":
        points = generator.integers(-3, 4, (count, 2)) * 0.25
    elif kind == "line":
        points = generator.uniform(-1.0, 1.0, (count, 1)) * planar.direction(np.array(draw(angles))) + 0.3
    else:
        points = 0.5 * planar.direction(generator.integers(0, 12, count) * (np.pi / 6.0))
    repeated = draw(st.sampled_from([0.0, 1e-12, 1e-4, 0.004]))
    copies = draw(st.integers(0, min(count, 4)))
    noise = generator.uniform(-repeated, repeated, (copies, 2))
    return np.concatenate([points, points[:copies] + noise])


@st.composite
def footstep_plans(draw: st.DrawFn, *, smallest: int = 2, largest: int = 12) -> FootstepPlan:
    """Valid plans on flat ground: steps of walking size along a curve, overlapping or with flights."""
    count = draw(st.integers(smallest, largest))
    generator = np.random.default_rng(draw(seeds))
    yaws = np.cumsum(generator.uniform(-0.4, 0.4, count))
    sides = (np.arange(count) + draw(st.integers(0, 1))) % 2
    way = np.cumsum(generator.uniform(0.2, 0.8, (count, 1)) * planar.direction(yaws), axis=0)
    across = planar.direction(yaws + 0.5 * np.pi) * np.where(sides == 0, 0.1, -0.1)[:, None]
    strikes = np.cumsum(generator.uniform(0.3, 0.7, count))
    overlap = draw(st.floats(-0.1, 0.25))
    return FootstepPlan(
        name="/World/Plan",
        sides=sides,
        positions=np.insert(way + across, 1, 0.0, axis=1),
        orientations=quaternion.yaw_quaternion(yaws),
        strike_times=strikes,
        liftoff_times=np.append(strikes[1:], strikes[-1] + 0.5) + overlap,
        root_weights=np.zeros(count),
    )
