"""Predictions: the step that clips blended by root velocity take, lambda4 = 1 ([B] 5).

The gradient bands are smooth but not exact, so the velocity asked for is moved by what the blend missed; what is then
left is the velocity error. Standing counts as an example of no velocity, so slow steps are short ones.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.timing import EARTH_GRAVITY
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import RIGHT
from usdfoot.model.examples import Examples
from usdfoot.spaces.footsteps import FootstepSpace, solve_footsteps
from usdfoot.spaces.landings import end_landings, left_landings, root_velocities
from usdfoot.spaces.library import FootstepSpaces
from usdfoot.spaces.root_velocity import RootVelocitySpace, build_root_velocity_space, solve_root_velocities
from usdfoot.spaces.side_space import SideSpace
from usdfoot.spaces.triangulation import merge_points

__all__ = ["Gaits", "PredictedSteps", "build_gaits", "choose_gaits", "limit_landings", "predict_steps"]

WALK_TO_RUN = 0.5
"""Froude number v^2 / (g leg) at which people break into a run."""
HYSTERESIS = 0.1
"""Part of the speed by which a gait outlasts that number."""
STILL = 0.1
"""A walk slower than this [m/s] makes a stand among the examples superfluous."""
NARROWEST, WIDEST = 0.1, 0.3
"""Width of a stand in lengths of the leg; between these it is that of the clips."""
DOUBLE_SUPPORT = 0.25
"""Part of a step in place during which both feet stand."""
CORRECTIONS = 5
"""How often at most the velocity asked for is moved by what the blend missed."""
CLOSE = 0.01
"""A blend this near the wanted velocity is not corrected further [m/s]."""
MERGE_DISTANCE = 0.1
"""Root velocities this near share one example [m/s]."""


@dataclass(frozen=True, kw_only=True)
class _GaitSide:
    """Examples of one gait and swing side, as if the left foot swung; standing is the last where it was added."""

    velocities: RootVelocitySpace
    values: FloatArray
    """Landing x, z [m], duration, swing liftoff and support liftoff [s], how far the foot is turned out [rad], where it
    stands from the root that passes it, x, z [m], shape (K, 8)."""
    footsteps: FootstepSpace


@dataclass(frozen=True, kw_only=True)
class Gaits:
    """What a library can do, by gait (False = walk, True = run) and swing side."""

    spaces: Mapping[tuple[bool, int], _GaitSide]
    switch_speed: float
    """Between walking and running [m/s]; infinite without a run."""
    stance_width: float
    """Between the feet of a stand [m]."""


@dataclass(frozen=True, kw_only=True)
class PredictedSteps:
    """N steps as the blended clips take them."""

    landings: FloatArray
    """From the support ball in the heading at the step's end, (x, z) [m], shape (N, 2)."""
    durations: FloatArray
    """Strike to strike [s], shape (N,)."""
    swing_liftoffs: FloatArray
    """Of the swing foot after the support's strike [s], negative after a flight, shape (N,)."""
    support_liftoffs: FloatArray
    """Of the support foot after its strike [s], shape (N,)."""
    offsets: FloatArray
    """Where the landed foot stands from the root as that passes it, (x, z) [m], shape (N, 2)."""
    foot_yaws: FloatArray
    """Of the landed foot to the heading in the middle of its stance [rad], shape (N,)."""


def build_gaits(examples: Examples, spaces: FootstepSpaces, *, style: str, leg_length: float) -> Gaits:
    """Root velocity spaces of a library for steps without footsteps.

    Args:
        examples: The library's steps.
        spaces: Its footstep spaces.
        style: Of the steps.
        leg_length: [m].

    Raises:
        ClipError: If the style has no step of a foot.
    """
    gaits = [gait for gait in (False, True) if all((style, gait, side) in spaces.spaces for side in (0, 1))] or [False]
    members = {(gait, side): spaces.find(style, gait, side) for gait in gaits for side in (0, 1)}
    slow = members[gaits[0], 0].examples
    widths = left_landings(end_landings(examples)[slow], examples.swing_sides[slow])[:, 0]
    stance = float(np.clip(np.median(widths), NARROWEST * leg_length, WIDEST * leg_length))
    built = {
        (gait, side): _build_side(examples, space, side, stance if gait == gaits[0] else None)
        for (gait, side), space in members.items()
    }
    switch = np.inf if gaits[-1] is False else 0.0
    if len(gaits) == 2:
        walks, runs = (np.linalg.norm(built[gait, 0].velocities.velocities, axis=1) for gait in gaits)
        froude = np.sqrt(WALK_TO_RUN * EARTH_GRAVITY * leg_length)
        switch = np.clip(froude, runs.min(), max(walks.max(), runs.min()))
    return Gaits(spaces=built, switch_speed=float(switch), stance_width=stance)


def _build_side(examples: Examples, space: SideSpace, side: int, stance: float | None) -> _GaitSide:
    """The examples of a space by root velocity, near ones averaged; with a stand of width `stance` [m].

    The heading is the mean of the feet's, so a foot that lands in a turn leads it by half a step's turn. The root is
    midway between the feet at the strikes: the landing is twice the way from there to the foot, half of it the root's
    own until it passes the foot. In a bend that is not the way of the last half step: with a turn of theta over steps
    of length s it lies 3/4 s theta farther inside.
    """
    own = space.examples
    sides = np.full(len(own), side)
    velocities = left_landings(root_velocities(examples)[own], sides)
    signs = np.where(sides == RIGHT, -1.0, 1.0)
    landings = left_landings(end_landings(examples)[own], sides)
    ways = velocities * examples.durations[own, None]
    offsets = 0.5 * (landings - ways)
    offsets[:, 0] -= 0.375 * signs * examples.turns[own] * ways[:, 1]
    values = np.column_stack(
        [
            landings,
            examples.durations[own],
            examples.swing_liftoffs[own],
            examples.support_liftoffs[own],
            signs * planar.wrap_angle(examples.landing_yaws - 1.5 * examples.turns)[own],
            offsets,
        ]
    )
    _, members = merge_points(velocities, MERGE_DISTANCE)
    counted = (members >= 0)[..., None]
    counts = counted.sum(axis=1)
    velocities = np.where(counted, velocities[members], 0.0).sum(axis=1) / counts
    values = np.where(counted, values[members], 0.0).sum(axis=1) / counts
    speeds = np.linalg.norm(velocities, axis=1)
    if stance is not None and speeds.min() > STILL:
        duration = values[np.argmin(speeds), 2]
        released = DOUBLE_SUPPORT * duration
        turned_out = float(np.median(values[:, 5]))
        stand = [stance, 0.0, duration, released, duration + released, turned_out, 0.5 * stance, 0.0]
        velocities, values = np.vstack([velocities, np.zeros(2)]), np.vstack([values, stand])
    return _GaitSide(
        velocities=build_root_velocity_space(velocities, polar=space.roots.polar, merge_distance=0.0),
        values=values,
        footsteps=space.footsteps,
    )


def predict_steps(
    gaits: Gaits, velocities: FloatArray, *, swing_sides: IntArray, runs: BoolArray, hurry: float
) -> PredictedSteps:
    """Steps of the clips blended for root velocities.

    What the clips cannot reach is shared by length and pace: the blend's duration is divided by the root of the ratio
    of wanted to blended speed, `hurry` at most.

    Args:
        gaits: From `build_gaits`.
        velocities: Wanted, (x, z) in the heading at the step's end [m/s], shape (N, 2).
        swing_sides: 0 = left, 1 = right, shape (N,).
        runs: Gait of each step, shape (N,).
        hurry: Largest factor by which a step is quickened or drawn out.
    """
    queries = left_landings(velocities, swing_sides)
    values, shortfalls = np.zeros((len(queries), 8)), np.zeros((len(queries), 2))
    for steps, space in _groups(gaits, swing_sides, runs):
        values[steps], shortfalls[steps] = _blend(space, queries[steps])
    wanted = np.linalg.norm(queries, axis=1)
    blended = np.linalg.norm(queries - shortfalls, axis=1)
    missed = np.linalg.norm(shortfalls, axis=1) > MERGE_DISTANCE
    ratio = np.sqrt(np.maximum(blended, 1e-3) / np.maximum(wanted, 1e-3))
    pace = np.where(missed, np.clip(ratio, 1.0 / hurry, hurry), 1.0)
    durations = pace * values[:, 2]
    signs = np.where(np.asarray(swing_sides) == RIGHT, -1.0, 1.0)
    return PredictedSteps(
        landings=left_landings(values[:, :2] + durations[:, None] * shortfalls, swing_sides),
        durations=durations,
        swing_liftoffs=pace * values[:, 3],
        support_liftoffs=pace * values[:, 4],
        foot_yaws=signs * values[:, 5],
        offsets=left_landings(values[:, 6:], swing_sides),
    )


def limit_landings(
    gaits: Gaits, landings: FloatArray, *, swing_sides: IntArray, runs: BoolArray, overreach: float, longest: float
) -> FloatArray:
    """Landings (N, 2) in the heading at the step's end, brought to within `overreach` [m] of the clips' landings.

    A walk is no longer than `longest` [m].
    """
    queries = left_landings(landings, swing_sides)
    limited = queries.copy()
    for steps, space in _groups(gaits, swing_sides, runs):
        solved = solve_footsteps(space.footsteps, queries[steps])
        share = np.minimum(1.0, overreach / np.maximum(solved.hull_distances, 1e-9))[:, None]
        limited[steps] = solved.projections + share * (queries[steps] - solved.projections)
    lengths = np.linalg.norm(limited, axis=1)
    share = np.where(runs, 1.0, np.minimum(1.0, longest / np.maximum(lengths, 1e-9)))
    return left_landings(share[:, None] * limited, swing_sides)


def choose_gaits(gaits: Gaits, speeds: FloatArray, runs: BoolArray) -> BoolArray:
    """Whether steps at `speeds` (N,) [m/s] are run, after steps that were (`runs`, (N,)) or were not."""
    limits = gaits.switch_speed * np.where(runs, 1.0 - HYSTERESIS, 1.0 + HYSTERESIS)
    return np.asarray(speeds > limits)


def _groups(gaits: Gaits, swing_sides: IntArray, runs: BoolArray) -> Iterator[tuple[IntArray, _GaitSide]]:
    for (gait, side), space in gaits.spaces.items():
        steps = np.flatnonzero((runs == gait) & (swing_sides == side))
        if steps.size:
            yield steps, space


def _blend(space: _GaitSide, queries: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Blended values (N, 8) and what their root velocity falls short of the queries (N, 2) [m/s]."""
    weights, shortfalls = _weigh(space, queries, queries)
    asked, gains = queries.copy(), np.ones(len(queries))
    for _ in range(CORRECTIONS):
        rows = np.flatnonzero(np.linalg.norm(shortfalls, axis=1) > CLOSE)
        if not rows.size:
            break
        trial = asked[rows] + gains[rows, None] * shortfalls[rows]
        tried, missed = _weigh(space, trial, queries[rows])
        better = np.linalg.norm(missed, axis=1) < np.linalg.norm(shortfalls[rows], axis=1)
        nearer = rows[better]
        asked[nearer], weights[nearer], shortfalls[nearer] = trial[better], tried[better], missed[better]
        gains[rows[~better]] *= 0.5
    return np.einsum("nk,kd->nd", weights, space.values), shortfalls


def _weigh(space: _GaitSide, asked: FloatArray, wanted: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Weights (N, K) for velocities asked (N, 2) and what they fall short of those wanted; the same in any company."""
    weights = solve_root_velocities(space.velocities, asked).weights
    return weights, wanted - np.einsum("nk,kd->nd", weights, space.velocities.velocities)
