"""Steps of people who creep, as a Warp kernel, one thread a person."""
# mypy: ignore-errors
# Warp kernels are Python only in their syntax: Warp types and compiles them itself.

from __future__ import annotations

import warp as wp

__all__ = ["step_after_creeping"]


@wp.kernel(enable_backward=False)
def step_after_creeping(
    points: wp.array(dtype=wp.vec2d, ndim=2),
    yaws: wp.array(dtype=wp.float64, ndim=2),
    slowest: wp.float64,
    frames: wp.int32,
    farthest: wp.float64,
    most_turn: wp.float64,
    rates: wp.array(dtype=wp.float64, ndim=2),
):
    """Sets the steps a second of people who stand but are too far, or turned too far, from how they stood.

    Args:
        points: Roots (x, z) [m], shape (A, F).
        yaws: Headings [rad], shape (A, F).
        slowest: Steps a second that they take then [1/s].
        frames: For which they take them.
        farthest: From where they stood [m].
        most_turn: From how they stood [rad].
        rates: Steps a second, 0 = they stand, shape (A, F); changed.
    """
    person = wp.tid()
    stood = wp.int32(0)  # last frame of a step
    until = wp.int32(0)  # frame until which they step
    for frame in range(rates.shape[1]):
        away = wp.length(points[person, frame] - points[person, stood])
        turned = wp.abs(yaws[person, frame] - yaws[person, stood])
        if frame >= until and (away > farthest or turned > most_turn):
            until = frame + frames
        if frame < until:
            rates[person, frame] = wp.max(rates[person, frame], slowest)
        if rates[person, frame] > wp.float64(0.0):
            stood = frame
