"""Strides: the state of agents that walk without footsteps, and their next step ([B] 5).

The root lies midway between consecutive footsteps ([B] 4.2), and passes a foot in the middle of its stance. So the foot
that strikes belongs where the root shall be half a step later, beside it as far as the clips say.
Every footstep is placed by the trajectory, and what one misses the next ones do not inherit.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from usdfoot.engine.follow_options import FollowOptions
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import LEFT
from usdfoot.planning.predictions import Gaits, PredictedSteps, choose_gaits, limit_landings, predict_steps

__all__ = ["Course", "Stances", "Steps", "next_steps", "seen_from_left"]

ROUNDS = 3
"""How often a step's end, velocity and duration are found from one another."""
FORWARD = 0.8
"""Least part of its speed with which a run goes forward."""


class Course(Protocol):
    """Where roots shall be, and how they shall face."""

    def at(self, agents: IntArray, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (N, 3) [m] and headings (N,) [rad] of agents (N,) at times (N,) [s]."""
        ...


@dataclass(frozen=True, kw_only=True)
class Stances:
    """N agents at a strike: the foot that has just been planted, and the one that will move."""

    agents: IntArray
    """Of the curves, shape (N,)."""
    times: FloatArray
    """Of the strike [s], shape (N,)."""
    sides: IntArray
    """Side of the planted foot, shape (N,)."""
    supports: FloatArray
    """Planted ball [m], shape (N, 3)."""
    support_yaws: FloatArray
    """[rad], shape (N,)."""
    others: FloatArray
    """Ball of the foot that will move [m], shape (N, 3)."""
    other_yaws: FloatArray
    """[rad], shape (N,)."""
    runs: BoolArray
    """Whether the last step was run, shape (N,)."""
    durations: FloatArray
    """Of the last step [s], shape (N,)."""

    def __len__(self) -> int:
        return len(self.agents)

    def __getitem__(self, rows: IntArray | BoolArray) -> Stances:
        return Stances(**{name: values[rows] for name, values in vars(self).items()})

    @property
    def roots(self) -> FloatArray:
        """Middle of the feet [m], shape (N, 3)."""
        return 0.5 * (self.supports + self.others)

    @property
    def headings(self) -> FloatArray:
        """Mean of the feet's yaws [rad], shape (N,)."""
        return planar.midway_yaw(self.support_yaws, self.other_yaws)


@dataclass(frozen=True, kw_only=True)
class Steps:
    """Next steps of N stances."""

    sides: IntArray
    """Side of the foot that moves, shape (N,)."""
    positions: FloatArray
    """Where its ball comes down, at the trajectory's height [m], shape (N, 3)."""
    yaws: FloatArray
    """Of the landed foot [rad], shape (N,)."""
    strikes: FloatArray
    """[s], shape (N,)."""
    liftoffs: FloatArray
    """When it leaves where it stood [s], shape (N,)."""
    support_liftoffs: FloatArray
    """When the support foot leaves if the gait goes on [s], shape (N,)."""
    durations: FloatArray
    """Strike to strike of the blended clips [s], shape (N,)."""
    runs: BoolArray
    """Whether it is run, shape (N,)."""


def next_steps(
    gaits: Gaits,
    curves: Course,
    stances: Stances,
    *,
    begins: FloatArray,
    rested: BoolArray,
    longest: float,
    options: FollowOptions,
) -> Steps:
    """The steps that keep N roots on their curves.

    Args:
        gaits: What the clips can do.
        curves: Of all agents.
        stances: Where the agents stand.
        begins: When the step begins: the support's strike, or the swing foot's liftoff after a rest [s], shape (N,).
        rested: Whether the body stands until the step begins, shape (N,).
        longest: Longest walking step [m].
        options: Of following.
    """
    sides = 1 - stances.sides
    durations, swing_times = stances.durations, stances.durations
    foot_yaws: FloatArray = np.zeros(len(stances))
    for _ in range(ROUNDS):
        strikes = begins + swing_times
        roots, _ = curves.at(stances.agents, strikes)
        before, _ = curves.at(stances.agents, strikes - durations)
        ahead, facing = curves.at(stances.agents, strikes + 0.5 * durations)
        beyond, _ = curves.at(stances.agents, strikes + durations)
        yaws = _turned_feet(stances.support_yaws, facing + foot_yaws, sides, options)
        headings = planar.midway_yaw(stances.support_yaws, yaws)
        velocities = planar.rotate(-headings, (roots - before)[:, [0, 2]]) / durations[:, None]
        speeds = np.linalg.norm(velocities, axis=1)
        runs = choose_gaits(gaits, speeds, stances.runs) & (velocities[:, 1] > FORWARD * speeds) & ~rested
        steps = predict_steps(gaits, velocities, swing_sides=sides, runs=runs, hurry=options.hurry)
        durations, foot_yaws = steps.durations, steps.foot_yaws
        swing_times = np.where(rested, durations - np.maximum(steps.swing_liftoffs, 0.0), durations)
    bends = (beyond - 2.0 * ahead + roots)[:, [0, 2]]
    landings = _landings(stances, ahead, bends, headings, steps, sides, options)
    landings = limit_landings(
        gaits, landings, swing_sides=sides, runs=runs, overreach=options.overreach, longest=longest
    )
    positions = ahead.copy()
    positions[:, [0, 2]] = stances.supports[:, [0, 2]] + planar.rotate(headings, landings)
    strikes = begins + swing_times
    return Steps(
        sides=sides,
        positions=positions,
        yaws=yaws,
        strikes=strikes,
        liftoffs=np.where(rested, begins, begins + steps.swing_liftoffs),
        support_liftoffs=strikes - durations + steps.support_liftoffs,
        durations=durations,
        runs=runs,
    )


def seen_from_left(values: FloatArray, sides: IntArray) -> FloatArray:
    """Angles or offsets to the left (N,) as if the foot of each side were the left one. Its own inverse."""
    return np.where(np.asarray(sides) == LEFT, values, -values)


def _turned_feet(supports: FloatArray, wanted: FloatArray, sides: IntArray, options: FollowOptions) -> FloatArray:
    """Yaws of the landing feet, turned against the support feet no farther than legs turn [rad], shape (N,)."""
    outward = seen_from_left(planar.wrap_angle(wanted - supports), sides)
    return supports + seen_from_left(np.clip(outward, -options.inward_turn, options.outward_turn), sides)


def _landings(
    stances: Stances,
    ahead: FloatArray,
    bends: FloatArray,
    headings: FloatArray,
    steps: PredictedSteps,
    sides: IntArray,
    options: FollowOptions,
) -> FloatArray:
    """From the support ball to beside the root half a step `ahead` (N, 3), in the headings (x, z) [m], shape (N, 2).

    In a bend, whose second
    difference over half steps is `bends` (N, 2) [m], the middle of two footsteps would lie inside the curve by half of
    that: they are moved out. Feet stay apart.
    """
    to_root = planar.rotate(-headings, (ahead - stances.supports)[:, [0, 2]])
    to_root[:, 0] -= 0.5 * planar.rotate(-headings, bends)[:, 0]
    landings = to_root + steps.offsets
    apart = seen_from_left(landings[:, 0], sides)
    least = np.minimum(seen_from_left(steps.landings[:, 0], sides), options.foot_spacing)
    landings[:, 0] = seen_from_left(np.maximum(apart, least), sides)
    return landings
