"""Collisions: feet of different people in one place at one time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from usdfoot.errors import PlanError
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.proportions import Proportions

__all__ = ["Collisions", "FootTable", "Instants", "feet_of", "find_collisions", "near_feet", "overlaps"]

INSTANT = 0.1
"""Between the instants at which feet are compared [s]."""
MOST_INSTANTS = 50_000_000
"""Feet times instants that are compared at once, for memory's sake: some gigabytes."""
STOREY = 0.5
"""Feet this far above one another do not touch [m]."""
APART = 1e3
"""Between instants on the time axis of the search tree [m]: more than any distance looked for."""


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


@dataclass(frozen=True, kw_only=True)
class Collisions:
    """Feet of two people that overlap, the deepest instant of each pair of footsteps, C of them."""

    steps: IntArray
    """Rows of the foot table, shape (C, 2)."""
    times: FloatArray
    """[s], shape (C,)."""
    depths: FloatArray
    """How far they overlap [m], shape (C,)."""


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


def find_collisions(feet: FootTable) -> Collisions:
    """Overlaps of soles, each a capsule from heel to toe, standing or swinging straight to its next footstep."""
    first, second = near_feet(feet, slack=0.0)
    depths, _ = overlaps(feet, first, second)
    deep = np.flatnonzero(depths > 1e-6)
    deep = deep[np.argsort(-depths[deep], kind="stable")]
    pairs = np.sort(np.stack([first.steps[deep], second.steps[deep]], axis=1), axis=1)
    _, rows = np.unique(pairs, axis=0, return_index=True)
    rows = np.sort(rows)
    return Collisions(steps=pairs[rows], times=first.times[deep][rows], depths=depths[deep][rows])


def near_feet(feet: FootTable, *, slack: float) -> tuple[Instants, Instants]:
    """Feet of different people that could touch if they moved by the slack in all [m], at every instant."""
    instants = _over_time(feet)
    middles = _axes(feet, instants).mean(axis=1)
    heights = _between(feet, instants, feet.positions[:, 1])
    reach = float((feet.heels + feet.toes).max()) + slack
    points = np.column_stack([middles, heights * (reach / STOREY), instants.times * (APART / INSTANT)])
    tree = cKDTree(points, compact_nodes=False, balanced_tree=False)
    pairs = tree.query_pairs(reach, output_type="ndarray")
    owners = feet.owners[instants.steps]
    pairs = pairs[owners[pairs[:, 0]] != owners[pairs[:, 1]]]
    first, second = _without_repeats(instants, pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))])
    near = overlaps(feet, first, second)[0] > -slack - 1e-9
    return first[near], second[near]


def _without_repeats(instants: Instants, pairs: IntArray) -> tuple[Instants, Instants]:
    """The pairs (K, 2) with one instant for two feet that both stand, however long they do."""
    steps, swings = instants.steps[pairs], instants.shares[pairs] > 0.0
    standing = np.flatnonzero(~swings.any(axis=1))
    keys = steps[standing, 0] * np.int64(len(instants.steps) + 1) + steps[standing, 1]
    _, once = np.unique(keys, return_index=True)
    kept = np.sort(np.concatenate([np.flatnonzero(swings.any(axis=1)), standing[once]]))
    return instants[pairs[kept, 0]], instants[pairs[kept, 1]]


def overlaps(feet: FootTable, first: Instants, second: Instants) -> tuple[FloatArray, FloatArray]:
    """How far the soles of pairs overlap [m], shape (K,), and the direction from the second to the first, (K, 2)."""
    a, b = _axes(feet, first), _axes(feet, second)
    gaps = np.concatenate([_to_segments(a, b), -_to_segments(b, a)], axis=1)  # (K, 4, 2), from b to a
    distances = np.linalg.norm(gaps, axis=2)
    rows, nearest = np.arange(len(gaps)), np.argmin(distances, axis=1)
    distance, gap = distances[rows, nearest], gaps[rows, nearest]
    crossing = _cross(a, b)
    direction = np.where((crossing | (distance < 1e-6))[:, None], a.mean(axis=1) - b.mean(axis=1), gap)
    lengths = np.linalg.norm(direction, axis=1, keepdims=True)
    direction = np.where(lengths < 1e-9, np.array([1.0, 0.0]), direction / np.maximum(lengths, 1e-9))
    widths = feet.half_widths[first.steps] + feet.half_widths[second.steps]
    return widths - np.where(crossing, -distance, distance), direction


def _over_time(feet: FootTable) -> Instants:
    """Every foot at every instant from its first strike to its last liftoff."""
    following = np.minimum(np.arange(len(feet.owners)) + 2, len(feet.owners) - 1)
    ends = np.where(feet.last, feet.liftoffs, feet.strikes[following] - 1e-9)
    begins = np.ceil(feet.strikes / INSTANT - 1e-9).astype(int)
    counts = np.maximum(np.floor(ends / INSTANT).astype(int) - begins + 1, 0)
    if counts.sum() > MOST_INSTANTS:
        longest = int(np.argmax(ends - feet.strikes))
        raise PlanError(
            "plans",
            f"have feet at {counts.sum()} instants to compare, more than {MOST_INSTANTS}; the longest step is "
            f"footstep {feet.numbers[longest]} of plan {feet.owners[longest]}, from {feet.strikes[longest]:.6g} to "
            f"{ends[longest]:.6g} s",
            "correct its times, or take fewer plans at once",
        )
    steps = np.repeat(np.arange(len(counts)), counts)
    times = INSTANT * (begins[steps] + np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts))
    swings = np.maximum(feet.strikes[following] - feet.liftoffs, 1e-9)
    phases = np.where(feet.last[steps], 0.0, np.clip((times - feet.liftoffs[steps]) / swings[steps], 0.0, 1.0))
    return Instants(steps=steps, shares=phases * phases * (3.0 - 2.0 * phases), times=times)


def _between(feet: FootTable, instants: Instants, values: FloatArray) -> FloatArray:
    """Values of footsteps (S, ...) on the way to the next."""
    following = np.minimum(instants.steps + 2, len(feet.owners) - 1)
    share = instants.shares.reshape(-1, *(1,) * (values.ndim - 1))
    return (1.0 - share) * values[instants.steps] + share * values[following]


def _axes(feet: FootTable, instants: Instants) -> FloatArray:
    """Ends of the capsules' axes (x, z) [m], heel and toe, shape (K, 2, 2)."""
    steps = instants.steps
    following = np.minimum(steps + 2, len(feet.owners) - 1)
    balls = _between(feet, instants, feet.positions[:, [0, 2]])
    turns = planar.wrap_angle(feet.yaws[following] - feet.yaws[steps])
    forward = planar.direction(feet.yaws[steps] + instants.shares * turns)
    heels = (feet.heels - feet.half_widths)[steps, None]
    toes = (feet.toes - feet.half_widths)[steps, None]
    return np.stack([balls - heels * forward, balls + toes * forward], axis=1)


def _to_segments(points: FloatArray, segments: FloatArray) -> FloatArray:
    """Vectors from the nearest points of segments (K, 2, 2) to points (K, P, 2), shape (K, P, 2)."""
    along = segments[:, 1] - segments[:, 0]
    offsets = points - segments[:, :1]
    share = np.sum(offsets * along[:, None], axis=2) / np.maximum(np.sum(along**2, axis=1), 1e-12)[:, None]
    return offsets - np.clip(share, 0.0, 1.0)[..., None] * along[:, None]


def _cross(a: FloatArray, b: FloatArray) -> BoolArray:
    """Whether segments a and b (K, 2, 2) cross, shape (K,)."""

    def side(segment: FloatArray, point: FloatArray) -> FloatArray:
        along, offset = segment[:, 1] - segment[:, 0], point - segment[:, 0]
        return along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0]

    apart = (side(a, b[:, 0]) * side(a, b[:, 1]) < 0.0) & (side(b, a[:, 0]) * side(b, a[:, 1]) < 0.0)
    return np.asarray(apart)
