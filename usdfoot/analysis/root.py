"""Root motion: whether a clip travels, and the travel given back to clips that run in place.

In a clip that runs in place the stance foot slides backward: its velocity is minus the root's ([B] 4.1, design.md
section 5).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from usdfoot.analysis.grids import fine_times
from usdfoot.analysis.motion import FootMotion
from usdfoot.maths import planar
from usdfoot.maths.runs import Runs
from usdfoot.maths.splines import build_splines
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip

__all__ = ["RootMotion", "detect_root_motions", "restored_path"]

NEGLIGIBLE = 1e-9
"""Samples of this part of the greatest weight do not count."""
KERNEL_WIDTH = 0.06
"""Velocities so near to each other, as a part of the feet's top speed, may be one stance's."""
TRAVELS = 0.3
"""A clip whose pelvis gets on by more than this part of the feet's top speed, or of their slip, travels by itself."""
LEAST_SLIP = 0.1
"""Feet that slide by less than this part of their top speed stand."""
LEAST_SLIP_SPEED = 0.125
"""The same in leg lengths a second."""
LOW = 0.2
"""A ball stands below about this part of the height it is lifted to."""
LEVEL = 0.1
"""A ball stands while it rises and falls at less than about this part of its top speed."""
ONE_STANCE = 0.2
"""Velocities that tell of turning are about so near to the slip, as a part of the feet's top speed."""
YAW_RATES = (0.2, 4.0)
"""Least turning that is not by chance, and the most of anybody who walks [rad/s]."""
ON_FLOOR = 0.02
"""A point stands below about this height over its own floor, in leg lengths."""
STRAYS = 8.0
"""A point stands up to about so many times the usual distance of its velocity from the common one."""
STRAY_LIMITS = (0.05, 0.6)
"""Least and most of that, as a part of the points' top speed."""
PRIOR = 0.005
"""Weight of the common velocity beside points that stand, each 1 at most."""
SMOOTHING = 0.02
"""Standard deviation of the smoothing of the restored pace [s]."""
FINE_RATE, FINEST_RATE = 120.0, 240.0
"""Least numbers of samples a second for the common velocity, and for the path [Hz]."""


@dataclass(frozen=True, kw_only=True)
class RootMotion:
    """Travel missing from a clip; zero where it is in the samples already."""

    in_place: bool
    """Whether the clip runs in place."""
    velocity: FloatArray
    """Missing planar velocity of the root, in the frame of the clip's samples, (x, z) [m/s], shape (2,)."""
    yaw_rate: float
    """Missing turning [rad/s]."""


NONE_MISSING = RootMotion(in_place=False, velocity=np.zeros(2), yaw_rate=0.0)


@dataclass(frozen=True, kw_only=True)
class _LowFeet:
    """Samples of both balls with how likely each belongs to a stance."""

    positions: FloatArray
    """(x, z) [m], shape (M, 2)."""
    velocities: FloatArray
    """[m/s], shape (M, 2)."""
    yaw_rates: FloatArray
    """Of the direction from ankle to ball [rad/s], shape (M,)."""
    weights: FloatArray
    """Shape (M,)."""
    fastest: float
    """95th percentile of the balls' speed [m/s]."""


def detect_root_motions(motions: Sequence[FootMotion], told: Sequence[str], biped: Biped) -> list[RootMotion]:
    """Travel missing from clips, from the commonest velocity of their low feet.

    Args:
        motions: Of the clips' feet and pelvis.
        told: Each clip's `root_motion`; travel or inPlace overrules the detection.
        biped: Their leg joints.
    """
    found = [NONE_MISSING] * len(motions)
    asked = [index for index, kind in enumerate(told) if kind != "travel"]
    for index, feet in zip(asked, _low_feet([motions[index] for index in asked]), strict=True):
        found[index] = _missing(motions[index], feet, biped, told[index])
    return found


def _missing(motion: FootMotion, feet: _LowFeet, biped: Biped, told: str) -> RootMotion:
    """Travel missing from one clip."""
    drift = (motion.pelvis[-1] - motion.pelvis[0])[[0, 2]] / (motion.times[-1] - motion.times[0])
    if told == "auto" and np.linalg.norm(drift) > TRAVELS * feet.fastest:
        return NONE_MISSING
    slip = _commonest(feet.velocities, feet)
    slips = np.linalg.norm(slip) > max(LEAST_SLIP * feet.fastest, LEAST_SLIP_SPEED * biped.maximal_leg_length)
    if told == "auto" and not (slips and np.linalg.norm(drift) < TRAVELS * np.linalg.norm(slip)):
        return NONE_MISSING
    yaw_rate = _missing_yaw_rate(feet, slip)
    velocities = feet.velocities
    if yaw_rate:
        velocities = velocities + yaw_rate * np.stack([feet.positions[:, 1], -feet.positions[:, 0]], axis=1)
        slip = _commonest(velocities, feet)
    return RootMotion(in_place=True, velocity=-slip, yaw_rate=yaw_rate)


def _low_feet(motions: Sequence[FootMotion]) -> Iterator[_LowFeet]:
    """Fine samples of both balls of each clip, weighted by how low and level they move."""
    if not motions:
        return
    samples = []
    for motion in motions:
        yaws = np.unwrap(planar.yaw_of((motion.balls - motion.ankles)[..., [0, 2]]), axis=0)
        samples.append(np.concatenate([motion.balls, yaws[..., None]], axis=-1).reshape(len(yaws), -1))
    rates = np.array([(len(motion.times) - 1) / (motion.times[-1] - motion.times[0]) for motion in motions])
    starts = np.array([motion.times[0] for motion in motions])
    splines = build_splines(
        np.concatenate(samples),
        first=Runs.of_lengths(np.array([len(part) for part in samples])).first,
        starts=starts,
        rates=rates,
    )
    grids = [
        fine_times(start, len(part), rate, fine_rate=FINE_RATE)
        for start, part, rate in zip(starts, samples, rates, strict=True)
    ]
    fine = Runs.of_lengths(np.array([len(grid) for grid in grids]))
    places, speeds = (
        sampled(fine.owners, np.concatenate(grids)).reshape(-1, 2, 4) for sampled in (splines.at, splines.rates_at)
    )
    for begin, end in pairwise(fine.first.tolist()):
        yield _weighted(places[begin:end, :, :3], speeds[begin:end, :, :3], speeds[begin:end, :, 3])


def _weighted(positions: FloatArray, velocities: FloatArray, yaw_rates: FloatArray) -> _LowFeet:
    """Samples of one clip, positions and velocities (N, 2, 3), yaw rates (N, 2)."""
    fastest = _fastest(velocities)
    low, high = np.quantile(positions[..., 1], [0.05, 0.95], axis=0)
    heights = (positions[..., 1] - low) / np.maximum(high - low, 1e-6)
    level = velocities[..., 1] / max(fastest, 1e-6)
    weights = np.exp(-((np.maximum(heights, 0.0) / LOW) ** 2) - (level / LEVEL) ** 2)
    return _LowFeet(
        positions=positions[..., [0, 2]].reshape(-1, 2),
        velocities=velocities[..., [0, 2]].reshape(-1, 2),
        yaw_rates=yaw_rates.reshape(-1),
        weights=weights.reshape(-1),
        fastest=fastest,
    )


def _missing_yaw_rate(feet: _LowFeet, slip: FloatArray) -> float:
    """Turning [rad/s] that both standing feet agree on, else 0."""
    width = ONE_STANCE * feet.fastest + 1e-9
    near = feet.weights * np.exp(-np.sum((feet.velocities - slip) ** 2, axis=1) / width**2)
    left, right = (-_weighted_median(feet.yaw_rates[side::2], near[side::2]) for side in range(2))
    agree = left * right > 0.0 and abs(left - right) < 0.5 * max(abs(left), abs(right))
    mean = 0.5 * (left + right)
    return mean if agree and YAW_RATES[0] < abs(mean) < YAW_RATES[1] else 0.0


def _commonest(velocities: FloatArray, feet: _LowFeet) -> FloatArray:
    """Mode of weighted planar velocities (M, 2): the densest place of a histogram, then mean shift, shape (2,)."""
    width = KERNEL_WIDTH * feet.fastest + 1e-6
    heavy = feet.weights > NEGLIGIBLE * feet.weights.max()
    velocities, weights = velocities[heavy], feet.weights[heavy]
    mode = _densest(velocities, weights, width)
    for _ in range(8):
        pull = weights * np.exp(-0.5 * np.sum(((velocities - mode) / width) ** 2, axis=1))
        mode = pull @ velocities / max(pull.sum(), 1e-12)
    return mode


def _densest(velocities: FloatArray, weights: FloatArray, width: float) -> FloatArray:
    """Where velocities (M, 2), smoothed by a Gaussian of a width, lie densest, to half a width, shape (2,)."""
    half = np.ceil(1.5 / KERNEL_WIDTH)  # faster feet than 1.5 times the 95th percentile stand nowhere
    edges = (np.arange(-2.0 * half, 2.0 * half + 2.0) - 0.5) * 0.5 * width
    counts, _ = np.histogramdd(velocities, bins=(edges, edges), weights=weights)
    densest = np.unravel_index(np.argmax(gaussian_filter(counts, 2.0, mode="constant")), counts.shape)
    return edges[np.array(densest)] + 0.25 * width


def _weighted_median(values: FloatArray, weights: FloatArray) -> float:
    """Weighted median of values (M,)."""
    order = np.argsort(values)
    share = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(share, 0.5 * share[-1])])


def restored_path(
    clip: Clip, biped: Biped, motion: FootMotion, *, root_motion: RootMotion, origin_time: float
) -> tuple[FloatArray, FloatArray]:
    """What moves a clip so that what stands on the ground stays: its travel given back, none at `origin_time`.

    At every instant the root moves against whatever stands lowest, heels and balls weighted by how near they are to
    their own floor and to the common velocity; where nothing stands, at the common velocity.

    Args:
        clip: A clip that runs in place.
        biped: Its leg joints.
        motion: Of its feet.
        root_motion: Its missing travel.
        origin_time: Time at which nothing is added [s].

    Returns:
        Shifts (x, z) [m] (T, 2) and turns [rad] (T,), as `moved` takes them.
    """
    grid = fine_times(motion.times[0], len(motion.times), clip.rate, fine_rate=FINEST_RATE)
    points = np.concatenate([motion.balls, motion.heels], axis=1)  # (T, 4, 3)
    run = np.array([0, len(points)])
    splines = build_splines(
        points.reshape(len(points), 12), first=run, starts=motion.times[:1], rates=np.array([clip.rate])
    )
    only = np.zeros(len(grid), dtype=np.intp)
    positions, velocities = (found(only, grid).reshape(-1, 4, 3) for found in (splines.at, splines.rates_at))
    ground, slips = positions[..., [0, 2]], velocities[..., [0, 2]]
    slips = slips + root_motion.yaw_rate * np.stack([ground[..., 1], -ground[..., 0]], axis=-1)
    clearance = positions[..., 1] - np.quantile(positions[..., 1], 0.02, axis=0)
    height = np.maximum(clearance, 0.0) / (ON_FLOOR * biped.maximal_leg_length)
    low = np.exp(-(height**2))
    stray = np.linalg.norm(slips + root_motion.velocity, axis=-1)
    usual, fastest = STRAYS * _weighted_median(stray.ravel(), low.ravel()), _fastest(velocities)
    stray = stray / (np.clip(usual, STRAY_LIMITS[0] * fastest, STRAY_LIMITS[1] * fastest) + 1e-9)
    weights = (low * np.exp(-(stray**2)))[..., None]  # (N, 4, 1)
    standing = (np.sum(weights * slips, axis=1) - PRIOR * root_motion.velocity) / (np.sum(weights, axis=1) + PRIOR)
    step = grid[1] - grid[0]
    yaws = root_motion.yaw_rate * (grid - origin_time)
    pace = planar.rotate(yaws, -gaussian_filter1d(standing, SMOOTHING / step, axis=0, mode="nearest"))
    path = np.zeros_like(pace)
    path[1:] = np.cumsum(0.5 * (pace[1:] + pace[:-1]), axis=0) * step
    path = path - np.array([np.interp(origin_time, grid, path[:, axis]) for axis in range(2)])
    parts = (len(grid) - 1) // (len(motion.times) - 1)
    return path[::parts], yaws[::parts]


def _fastest(velocities: FloatArray) -> float:
    """95th percentile of the speed of velocities (..., 3) [m/s]."""
    return float(np.quantile(np.linalg.norm(velocities, axis=-1), 0.95))
