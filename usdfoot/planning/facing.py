"""Facing: which way simulated people look, so that they turn before they go and side-step where it is tight."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.trajectory import RootTrajectory

__all__ = ["face_tracks"]

FACING = 0.8
"""Standard deviation of the filter on where people face; to what is quicker they side-step [s]."""
SHOULDERS = 0.4
"""Standard deviation of the filter on how far they turn their shoulders [s]."""
STILL = 0.05
"""Whose mean velocity is less keeps facing as before [m/s]."""
STAND, TURN = 1.2, 2.8
"""How long they stand, and turn on the spot, before the tracks begin [s]."""
TAIL = 3.0
"""Time to close up after the tracks end [s]."""


def face_tracks(
    points: FloatArray,
    *,
    time_step: float,
    yaws: FloatArray,
    heights: FloatArray,
    turned: FloatArray,
    names: list[str],
) -> list[RootTrajectory]:
    """Trajectories of N people along tracks, who first turn from where they look to where they go.

    Args:
        points: Tracks (x, z) [m], shape (T, N, 2).
        time_step: Between their samples [s].
        yaws: Where people look at first, NaN = where they go [rad], shape (N,).
        heights: Of the ground where they are [m], shape (T, N).
        turned: How far they turn the left shoulder first: 0 = not, 1 = sideways, shape (T, N).
        names: Of the trajectories, N of them.
    """
    stand, turn, tail = (round(time / time_step) for time in (STAND, TURN, TAIL))
    sideways = gaussian_filter1d(turned, SHOULDERS / time_step, axis=0, mode="nearest")
    headings = _headings(points, time_step) - 0.5 * np.pi * np.minimum(1.2 * sideways, 1.0)
    turns = np.where(np.isnan(yaws), 0.0, planar.wrap_angle(yaws - headings[0]))
    shares = np.concatenate([np.zeros(stand), np.linspace(0.0, 1.0, turn, endpoint=False)])[:, None]
    turning = headings[0] + (1.0 - shares * shares * (3.0 - 2.0 * shares)) * turns
    facing = np.concatenate([turning, headings, np.repeat(headings[-1:], tail, axis=0)])
    roots = np.pad(points, ((stand + turn, tail), (0, 0), (0, 0)), mode="edge")
    levels = np.pad(heights, ((stand + turn, tail), (0, 0)), mode="edge")
    times = time_step * np.arange(len(roots))
    return [
        RootTrajectory(
            name=name,
            times=times,
            positions=np.insert(roots[:, person], 1, levels[:, person], axis=1),
            yaws=facing[:, person],
        )
        for person, name in enumerate(names)
    ]


def _headings(points: FloatArray, time_step: float) -> FloatArray:
    """Directions of the velocities averaged over a second or two, kept while people stand, continuous, shape (T, N)."""
    velocities: FloatArray = np.gradient(points, time_step, axis=0)
    mean = gaussian_filter1d(velocities, FACING / time_step, axis=0, mode="nearest")
    moving = np.linalg.norm(mean, axis=2) > STILL
    last = np.maximum.accumulate(np.where(moving, np.arange(len(mean))[:, None], -1), axis=0)
    last = np.where(last < 0, np.argmax(moving, axis=0), last)
    directions = planar.yaw_of(np.take_along_axis(mean, last[..., None], axis=0))
    return np.unwrap(directions, axis=0)
