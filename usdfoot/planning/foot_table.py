"""Foot table: footsteps of many people, and where their feet are at any instant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.proportions import Proportions

__all__ = ["FootTable", "Instants", "between", "feet_of", "foot_axes", "joined_instants", "joined_tables"]


@dataclass(frozen=True, kw_only=True)
class FootTable:
    """Footsteps of all plans one after the other, S in all."""

    owners: IntArray
    """Plan of each, shape (S,)."""
    numbers: IntArray
    """Index in its plan, shape (S,)."""
    positions: FloatArray
    """Under the ball [m], shape (S, 3)."""
    yaws: FloatArray
    """Of the foot [rad], shape (S,)."""
    sides: IntArray
    """0 = left, 1 = right, shape (S,)."""
    strikes: FloatArray
    """[s], shape (S,)."""
    liftoffs: FloatArray
    """[s], shape (S,)."""
    last: BoolArray
    """Whether the foot has no further footstep, shape (S,)."""
    heels: FloatArray
    """From the ball back to the heel [m], shape (S,)."""
    toes: FloatArray
    """From the ball ahead to the toes [m], shape (S,)."""
    half_widths: FloatArray
    """[m], shape (S,)."""


@dataclass(frozen=True, kw_only=True)
class Instants:
    """Feet at instants: on the way from a footstep to the next of the same foot, K of them."""

    steps: IntArray
    """Footstep left last, shape (K,)."""
    shares: FloatArray
    """How far it is on the way to the next, 0 = planted, shape (K,)."""
    times: FloatArray
    """[s], shape (K,)."""

    def __getitem__(self, rows: IntArray | BoolArray) -> Instants:
        return Instants(steps=self.steps[rows], shares=self.shares[rows], times=self.times[rows])


def joined_instants(first: Instants, second: Instants) -> Instants:
    """Instants one after the other."""
    return Instants(
        steps=np.concatenate([first.steps, second.steps]),
        shares=np.concatenate([first.shares, second.shares]),
        times=np.concatenate([first.times, second.times]),
    )


def feet_of(plans: Sequence[FootstepPlan], bodies: Sequence[Proportions]) -> FootTable:
    """The table of plans, each with the body that walks it."""
    counts = np.array([len(plan) for plan in plans])
    owners = np.repeat(np.arange(len(plans)), counts)
    numbers = np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts)
    orientations = np.concatenate([plan.orientations for plan in plans])
    forward = quaternion.rotate(orientations, np.array([0.0, 0.0, 1.0]))
    return FootTable(
        owners=owners,
        numbers=numbers,
        positions=np.concatenate([plan.positions for plan in plans]),
        yaws=planar.yaw_of(forward[:, [0, 2]]),
        sides=np.concatenate([plan.sides for plan in plans]),
        strikes=np.concatenate([plan.strike_times for plan in plans]),
        liftoffs=np.concatenate([plan.liftoff_times for plan in plans]),
        last=numbers >= counts[owners] - 2,
        heels=np.array([body.heel for body in bodies])[owners],
        toes=np.array([body.toe for body in bodies])[owners],
        half_widths=np.array([body.half_width for body in bodies])[owners],
    )


def between(feet: FootTable, instants: Instants, values: FloatArray) -> FloatArray:
    """Values of footsteps (S, ...) on the way to the next."""
    following = np.minimum(instants.steps + 2, len(feet.owners) - 1)
    share = instants.shares.reshape(-1, *(1,) * (values.ndim - 1))
    return (1.0 - share) * values[instants.steps] + share * values[following]


def foot_axes(feet: FootTable, instants: Instants) -> FloatArray:
    """Ends of the capsules' axes (x, z) [m], heel and toe, shape (K, 2, 2)."""
    steps = instants.steps
    following = np.minimum(steps + 2, len(feet.owners) - 1)
    balls = between(feet, instants, feet.positions)[:, [0, 2]]
    turns = planar.wrap_angle(feet.yaws[following] - feet.yaws[steps])
    forward = planar.direction(feet.yaws[steps] + instants.shares * turns)
    heels = (feet.heels - feet.half_widths)[steps, None]
    toes = (feet.toes - feet.half_widths)[steps, None]
    return np.stack([balls - heels * forward, balls + toes * forward], axis=1)


def joined_tables(tables: Sequence[FootTable]) -> FootTable:
    """One table of several."""
    return FootTable(
        **{part.name: np.concatenate([getattr(table, part.name) for table in tables]) for part in fields(FootTable)}
    )
