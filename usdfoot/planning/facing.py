"""Facing: which way simulated people look, so that they turn before they go and side-step where it is tight."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.trajectory import RootTrajectory

__all__ = ["LEAD", "face_tracks"]

SMOOTHING = 0.55
"""Standard deviation of the filter on the tracks before anything is asked of them [s]."""
WINDOW = 1.0
"""Half of the shortest time of which it is asked where people got; then of twice as long, and so on [s]."""
TURN_RATE = 2.0
"""How fast people turn at most [rad/s]."""
SHOULDERS = 0.4
"""Standard deviation of the filter on how far they turn their shoulders [s]."""
STAND, TURN = 1.2, 2.8
"""How long they stand, and turn on the spot, before the tracks begin [s]."""
LEAD = STAND + TURN
"""So long after the trajectories the tracks begin [s]."""
TAIL = 3.0
"""Time to close up after the tracks end [s]."""


def face_tracks(
    points: FloatArray,
    *,
    time_step: float,
    yaws: FloatArray,
    heights: FloatArray,
    turned: FloatArray,
    legs: FloatArray,
    names: list[str],
    begun: bool = False,
) -> list[RootTrajectory]:
    """Trajectories of N people along tracks, who first turn from where they look to where they go.

    Args:
        points: Tracks (x, z) [m], shape (T, N, 2).
        time_step: Between their samples [s].
        yaws: Where people look at first, NaN = where they go [rad], shape (N,).
        heights: Of the ground where they are [m], shape (T, N).
        turned: How far they turn the left shoulder first: 0 = not, 1 = sideways, shape (T, N).
        legs: Their length [m], shape (N,).
        names: Of the trajectories, N of them.
        begun: Whether the tracks begin `LEAD` before people go; else they stand so long before.
    """
    stand, turn, tail = (round(time / time_step) for time in (STAND, TURN, TAIL))
    sideways = gaussian_filter1d(turned, SHOULDERS / time_step, axis=0, mode="nearest")
    headings = _headings(points, legs, yaws, time_step) - 0.5 * np.pi * np.minimum(1.2 * sideways, 1.0)
    turns = np.where(np.isnan(yaws), 0.0, planar.wrap_angle(yaws - headings[0]))
    shares = np.concatenate([np.zeros(stand), np.linspace(0.0, 1.0, turn, endpoint=False)])[:, None]
    lead = 0 if begun else stand + turn
    facing = np.pad(headings, ((lead, tail), (0, 0)), mode="edge")
    facing[: stand + turn] += (1.0 - shares * shares * (3.0 - 2.0 * shares)) * turns
    roots = np.pad(points, ((lead, tail), (0, 0), (0, 0)), mode="edge")
    levels = np.pad(heights, ((lead, tail), (0, 0)), mode="edge")
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


def _headings(points: FloatArray, legs: FloatArray, yaws: FloatArray, time_step: float) -> FloatArray:
    """Where people look, continuous [rad], shape (T, N): where they get to in a while.

    In two seconds who walks gets so far that this is where it looks. Who is pushed to and fro in a crowd, steps aside
    or back gets less than a leg's length anywhere, and looks where it gets to in twice, four times, ... as long. The
    direction of a longer time counts by the square of a leg's length over how far people got in the shorter one. Who
    never gets anywhere looks as at first.
    """
    tracks = gaussian_filter1d(points, SMOOTHING / time_step, axis=0, mode="nearest")
    every, span = np.arange(len(points)), WINDOW / time_step
    scales = int(np.ceil(np.log2(max(len(points) / span, 1.0))))
    ahead = np.broadcast_to(np.where(np.isnan(yaws)[:, None], 0.0, planar.direction(np.nan_to_num(yaws))), points.shape)
    for scale in range(scales, -1, -1):
        half = round(span * 2**scale)
        travel = (tracks[np.minimum(every + half, every[-1])] - tracks[np.maximum(every - half, 0)]) / legs[:, None]
        ahead = ahead + travel * np.linalg.norm(travel, axis=2, keepdims=True)
        ahead = ahead / np.maximum(np.linalg.norm(ahead, axis=2, keepdims=True), 1e-12)
    return _unhurried(np.unwrap(planar.yaw_of(ahead), axis=0), TURN_RATE * time_step)


def _unhurried(yaws: FloatArray, most: float) -> FloatArray:
    """Angles (T, N) that change by no more than `most` from one to the next, midway between the tightest bounds."""
    ramp = most * np.arange(len(yaws))[:, None]

    def above(values: FloatArray) -> FloatArray:
        rising = np.maximum.accumulate(values + ramp, axis=0) - ramp
        falling = np.maximum.accumulate(values[::-1] + ramp, axis=0)[::-1] - ramp[::-1]
        return np.maximum(rising, falling)

    return 0.5 * (above(yaws) - above(-yaws))
