"""Balls that would stand before they strike: swings of slow or drawn-out steps that hover over the print and settle."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import FloatArray

__all__ = ["LANDING_SPEED", "early_heights", "still_early"]

HEIGHT = 0.018
"""So far over its print a ball is not taken to stand [m]."""
LANDING_SPEED = 0.2
"""So fast it comes down from there, to where it is at the strike: as slow as `SPEED` it would be taken to stand, much
faster it hits the ground [m/s]."""
HOVERING_SPEED = 0.3
"""So fast where it hovers: a little above where it would fall at `LANDING_SPEED` it would be taken to stand [m/s]."""
RADIUS, SPEED = 0.015, 0.15
"""A ball that is nearer and slower would be taken to stand, one twice as far or as fast not at all [m, m/s]
(design.md section 10)."""


def early_heights(
    balls: FloatArray, prints: FloatArray, *, durations: FloatArray, landing_speed: float = LANDING_SPEED
) -> FloatArray:
    """How far over the ground balls stay that would stand before they strike [m], shape (N, K).

    Args:
        balls: Soles under the balls at K instants, even in the swings' time [m], shape (N, K, 3).
        prints: Where they land [m], shape (N, 3).
        durations: Of the swings [s], shape (N,).
        landing_speed: At which they come down from there [m/s].
    """
    fractions, every = np.linspace(0.0, 1.0, balls.shape[1]), durations[:, None] / (balls.shape[1] - 1)
    heights, middle = np.zeros(balls.shape[:2]), np.searchsorted(fractions, 0.5, side="right")
    late = balls[:, middle:]
    left = (1.0 - fractions[middle:]) * durations[:, None]
    away, ahead = late - prints[:, None], np.diff(late, axis=1, append=late[:, -1:])
    distances = np.sqrt(away[..., 0] ** 2 + away[..., 2] ** 2)
    speeds = np.sqrt(ahead[..., 0] ** 2 + ahead[..., 1] ** 2 + ahead[..., 2] ** 2) / every
    near, slow = (np.clip(2.0 - values / limit, 0.0, 1.0) for values, limit in ((distances, RADIUS), (speeds, SPEED)))
    landing = np.maximum(away[:, -1:, 1], 0.0)  # over the print at the strike: heels land first
    heights[:, middle:] = near * slow * np.minimum(landing + left * landing_speed, HEIGHT)
    return heights


def still_early(balls: FloatArray, prints: FloatArray, *, durations: FloatArray) -> FloatArray:
    """What balls that are lifted already lack not to stand before they strike [m], shape (N, K).

    Over edges they are lifted for the terrain's sake, and where that ends hover, slower than they fell unlifted. Others
    hover by themselves a little above where they would fall.

    Args:
        balls: As for `early_heights`, with their lifts [m], shape (N, K, 3).
        prints: Where they land [m], shape (N, 3).
        durations: Of the swings [s], shape (N,).
    """
    early = early_heights(balls, prints, durations=durations, landing_speed=HOVERING_SPEED)
    missing = np.where(early > 0.0, np.maximum(early + prints[:, None, 1] - balls[..., 1], 0.0), 0.0)
    missing[:, [0, -1]] = 0.0
    return np.asarray(missing)
