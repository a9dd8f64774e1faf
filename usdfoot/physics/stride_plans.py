"""Stride plans: a few steady steps whose middle one lands in a hole of a footstep space."""

from __future__ import annotations

import numpy as np

from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import RIGHT
from usdfoot.model.examples import Examples
from usdfoot.model.plan import FootstepPlan
from usdfoot.spaces.footsteps import solve_footsteps
from usdfoot.spaces.holes import Hole
from usdfoot.spaces.library import FootstepSpaces
from usdfoot.spaces.side_space import SideSpace

__all__ = ["FOOTSTEPS", "LANDING", "plan_stride"]

FOOTSTEPS = 7
LANDING = 3
"""Footsteps of such a plan, and which of them lands in the hole; the next one closes the stride."""
LEAST_SWING = 0.3
"""Part of a step's duration for which a foot is in the air at least."""


def plan_stride(hole: Hole, spaces: FootstepSpaces, examples: Examples, *, name: str) -> FootstepPlan:
    """A steady gait on level ground in which every second step lands in the hole.

    The other foot closes up: it lands as far ahead, and as far aside as the examples do. So a landing to the side makes
    side steps, one behind backward steps. Durations, double supports and the feet's directions are those of the
    examples that the footstep space has there, or at the nearest point of its hull.

    Args:
        hole: Where to land.
        spaces: Of the library.
        examples: The library's steps.
        name: Of the plan.
    """
    own = spaces.find(hole.style, hole.flight, hole.side)
    other = spaces.find(hole.style, hole.flight, 1 - hole.side)
    closing = np.array([_usual_width(other), hole.landing[1]])
    counts = np.arange(FOOTSTEPS)
    sides = np.where((counts - LANDING) % 2 == 0, hole.side, 1 - hole.side)
    in_hole = sides == hole.side
    first, second = _manner(own, examples, hole.landing), _manner(other, examples, closing)
    manners = np.where(in_hole[:, None], first, second)
    across = np.where(sides == RIGHT, -1.0, 1.0)
    displacements = np.where(in_hole[:, None], hole.landing, closing) * across[:, None] ** [1, 0]
    displacements[0] = 0.0
    ground = np.cumsum(displacements, axis=0)
    return _timed(name, sides, ground, manners, hole.style)


def _usual_width(space: SideSpace) -> float:
    return float(np.median(space.footsteps.vertices[:, 0]))


def _manner(space: SideSpace, examples: Examples, landing: FloatArray) -> FloatArray:
    """Duration [s], double support [s] and toe-out [rad] of the step to a left-swing landing, shape (3,)."""
    solved = solve_footsteps(space.footsteps, landing[None])
    rows, weights = space.examples[solved.examples[0]], solved.weights[0]
    signs = np.where(examples.swing_sides[rows] == RIGHT, -1.0, 1.0)
    toes_out = 0.5 * signs * planar.wrap_angle(examples.landing_yaws[rows] - examples.support_yaws[rows])
    return np.array(
        [weights @ values for values in (examples.durations[rows], examples.swing_liftoffs[rows], toes_out)]
    )


def _timed(name: str, sides: IntArray, ground: FloatArray, manners: FloatArray, style: str) -> FootstepPlan:
    """The plan over ground points (N, 2); row k of the manners is that of the step which lands at footstep k."""
    durations, overlaps, toes_out = manners.T
    strikes = np.cumsum(durations) - durations[0]
    following = np.append(durations[1:], durations[-2])
    after = np.append(overlaps[2:], overlaps[-2:])  # footstep k lifts off in the step that lands at k + 2
    free = np.append(durations[2:], durations[-2:])
    liftoffs = strikes + following + np.minimum(after, (1.0 - LEAST_SWING) * free)
    yaws = toes_out * np.where(sides == RIGHT, -1.0, 1.0)
    return FootstepPlan(
        name=name,
        sides=sides,
        positions=np.column_stack([ground[:, 0], np.zeros(len(ground)), ground[:, 1]]),
        orientations=quaternion.yaw_quaternion(yaws),
        strike_times=strikes,
        liftoff_times=liftoffs,
        root_weights=np.zeros(len(sides)),
        styles=(style,) * len(sides),
    )
