"""Hurried swings: feet that lag behind and hurry ahead on the level, so that there is time to rise and to fall."""

from __future__ import annotations

import numpy as np

from usdfoot.engine.early_balls import LANDING_SPEED
from usdfoot.maths.types import FloatArray

__all__ = ["eased_shares", "height_speeds", "hurried_balls"]

EASY_SPEED, STEEP_SPEED = 0.5, 1.5
"""Speeds at which a foot has to rise or fall: up to the first as it comes, from the second wholly eased [m/s]."""

EASY_LANDING, HARD_LANDING = 15.0, 60.0
"""Decelerations at which a foot that has little time to fall would land: up to the first as it comes, from the second
it falls wholly eased [m/s2]."""
SHORTEST_FALL = 0.05
"""Falls in less time count as in this: those of some millimetres just before the strike are no landing [s]."""

UPRIGHT_SPEED = 6.0
"""Speed at which a foot has to rise or fall from which it has the longest time for the height alone [m/s]."""
MOST_UPRIGHT = 0.3
"""Longest part of a swing, at either end, in which the foot only rises or falls."""


def height_speeds(missing: FloatArray, durations: FloatArray) -> FloatArray:
    """Speeds at which the feet have to rise at the begins and fall at the ends of swings [m/s], shape (N, 2).

    Args:
        missing: What the soles lack, shape (N, K) [m].
        durations: Of the swings, shape (N,) [s].
    """
    fractions = np.linspace(0.0, 1.0, missing.shape[1])[1:-1]
    inner = missing[:, 1:-1] / durations[:, None]
    return np.stack([np.max(inner / fractions, axis=1), np.max(inner / (1.0 - fractions), axis=1)], axis=1)


def eased_shares(missing: FloatArray, durations: FloatArray, speeds: FloatArray) -> FloatArray:
    """How far swings are eased at their begins and ends, 0..1, shape (N, 2).

    For the speeds, and at the ends for the landings: a fall through a height h in a time t, as lifts are drawn, ends
    with a deceleration of 6 h / t^2, so that a low one in a short time is as hard as a high one in a longer. Balls kept
    off their prints (`early_heights`) come down slowly: what falls as they do is no landing.

    Args:
        missing: What the soles lack, shape (N, K) [m].
        durations: Of the swings, shape (N,) [s].
        speeds: At which they have to rise and fall [m/s], shape (N, 2).
    """
    left = np.linspace(1.0, 0.0, missing.shape[1])[1:-1] * durations[:, None]
    falls = missing[:, 1:-1] - LANDING_SPEED * left
    landings = np.max(6.0 * falls / np.maximum(left, SHORTEST_FALL) ** 2, axis=1)
    shares = _share(speeds, EASY_SPEED, STEEP_SPEED)
    shares[:, 1] = np.maximum(shares[:, 1], _share(landings, EASY_LANDING, HARD_LANDING))
    return shares


def hurried_balls(balls: FloatArray, speeds: FloatArray, shares: FloatArray) -> FloatArray:
    """Level offsets (N, K, 3) that let balls (N, K, 3) lag first and hurry then.

    The instant looked up on the ball's own path is t - b t (1 - t)^2 + e t^2 (1 - t), at rest at the ends if b = e = 1,
    of a time t that stands still while the foot only rises or falls.

    Args:
        balls: Along the swings [m], shape (N, K, 3).
        speeds: At which they have to rise and fall [m/s], shape (N, 2).
        shares: How far they are eased at their begins and ends, 0..1, shape (N, 2).
    """
    begin, end = np.split(shares, 2, axis=1)
    rising, falling = np.split(MOST_UPRIGHT * _share(speeds, STEEP_SPEED, UPRIGHT_SPEED), 2, axis=1)
    count = balls.shape[1]
    times = np.clip((np.linspace(0.0, 1.0, count) - rising) / (1.0 - rising - falling), 0.0, 1.0)
    shifted = times - begin * times * (1.0 - times) ** 2 + end * times**2 * (1.0 - times)
    place = shifted * (count - 1)
    before = np.minimum(place.astype(np.intp), count - 2)[..., None]
    share = place[..., None] - before
    first, second = (np.take_along_axis(balls, index, axis=1) for index in (before, before + 1))
    return (first + share * (second - first) - balls) * [1.0, 0.0, 1.0]


def _share(values: FloatArray, low: float, high: float) -> FloatArray:
    """Where values are between two bounds, 0..1."""
    return np.clip((values - low) / (high - low), 0.0, 1.0)
