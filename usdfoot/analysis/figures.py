"""Figures of design.md section 10: what the feet of a finished motion really do, from joint trajectories alone.

Everything is ragged and vectorised: frames of many agents may be laid end to end along the frame axis, and contacts
refer to them by the index of their first frame and their number of frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.feet import flat_heels
from usdfoot.analysis.flat_feet import flat_turns, flattest
from usdfoot.maths import quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = [
    "FRAME_TOLERANCE",
    "ContactFigures",
    "FrameRanges",
    "contact_figures",
    "frames_between",
    "largest_distances",
    "smallest_in_ranges",
    "sole_offsets",
    "timing_faults",
]

FRAME_TOLERANCE = 1e-6
"""Times closer than this to a frame count as on it [s]."""
LONG = 128
"""Ranges of more frames are compared one by one."""
BLOCK = 1_000_000
"""Pairs of points that are compared at once."""
HELD_FLAT = np.radians(0.2)
"""Feet that are held flat on their footsteps differ by no more in pitch [rad]."""
A_PAIR = 0.03
"""Feet that differ by no more, relative to their length, stand alike: people's own are measured no better."""


@dataclass(frozen=True, kw_only=True)
class FrameRanges:
    """Whole frames of each of K intervals, as ranges of the frame axis."""

    first: IntArray
    """Index of the first frame, shape (K,)."""
    counts: IntArray
    """Number of frames, 0 where the interval holds none, shape (K,)."""

    def flattened(self) -> tuple[IntArray, IntArray]:
        """Frame index and interval index of every frame of every interval, shape (sum of counts,) each."""
        intervals = np.repeat(np.arange(len(self.counts)), self.counts)
        starts = np.cumsum(self.counts) - self.counts
        frames = np.arange(len(intervals)) - starts[intervals] + self.first[intervals]
        return frames, intervals


@dataclass(frozen=True, kw_only=True)
class ContactFigures:
    """Figures of K contacts; NaN where no whole frame is planted."""

    placement_error: FloatArray
    """Horizontal distance of the ball to its footstep, mean over the planted frames [m], shape (K,)."""
    slide: FloatArray
    """Largest distance between two positions of the ball over the planted frames [m], shape (K,)."""
    yaw_error: FloatArray
    """Angle between the foot's and the footstep's forward, seen along the print's normal at mid contact [rad], (K,)."""


def frames_between(frame_times: FloatArray, starts: FloatArray, ends: FloatArray, *, offset: int = 0) -> FrameRanges:
    """Whole frames of intervals, both ends included.

    Args:
        frame_times: Increasing times of the frames [s], shape (F,).
        starts: Starts of the intervals [s], shape (K,).
        ends: Ends of the intervals [s], shape (K,).
        offset: Added to the indices, for frames of one agent within those of many.
    """
    first = np.searchsorted(frame_times, np.asarray(starts) - FRAME_TOLERANCE, side="left")
    stop = np.searchsorted(frame_times, np.asarray(ends) + FRAME_TOLERANCE, side="right")
    return FrameRanges(first=first + offset, counts=np.maximum(stop - first, 0))


def contact_figures(
    balls: FloatArray, forwards: FloatArray, planted: FrameRanges, *, targets: FloatArray, orientations: FloatArray
) -> ContactFigures:
    """Placement, slide and yaw of planted feet (design.md section 10).

    Args:
        balls: Ball joint of the contacts' foot in the world [m], shape (F, 3).
        forwards: Vector from ankle to ball in the world, any length, shape (F, 3).
        planted: Planted frames of each contact, `frames_between` flat and liftoff.
        targets: Footsteps: points of the ground under the balls [m], shape (K, 3).
        orientations: Orientations of the footsteps, +Z forward and +Y the normal, unit xyzw, shape (K, 4).
    """
    frames, contacts = planted.flattened()
    offsets = balls[frames] - targets[contacts]
    distances = np.hypot(offsets[:, 0], offsets[:, 2])
    sums = np.bincount(contacts, weights=distances, minlength=len(targets))
    empty = planted.counts == 0
    middle = np.where(empty, 0, planted.first + (planted.counts - 1) // 2)
    seen = quaternion.rotate(quaternion.inverse(orientations), forwards[middle])
    yaw_error = np.abs(np.arctan2(seen[:, 0], seen[:, 2]))
    return ContactFigures(
        placement_error=np.where(empty, np.nan, sums / np.maximum(planted.counts, 1)),
        slide=np.where(empty, np.nan, largest_distances(balls, planted)),
        yaw_error=np.where(empty, np.nan, yaw_error),
    )


def largest_distances(points: FloatArray, ranges: FrameRanges) -> FloatArray:
    """Largest distance between two points of each range [m], 0 for fewer than two, shape (K,).

    Every pair is compared, one lag at a time over all short ranges at once, and of each long one those that can be
    farthest apart.

    Args:
        points: Positions [m], shape (F, 3).
        ranges: Frames of each of K intervals.
    """
    largest = np.zeros(len(ranges.counts))
    is_long = ranges.counts > LONG
    short = FrameRanges(first=ranges.first, counts=np.where(is_long, 0, ranges.counts))
    frames, intervals = short.flattened()
    x, y, z = points[frames].T
    farthest = np.zeros(len(frames))
    for lag in range(1, int(short.counts.max(initial=0))):
        squares = (x[lag:] - x[:-lag]) ** 2 + (y[lag:] - y[:-lag]) ** 2 + (z[lag:] - z[:-lag]) ** 2
        squares[intervals[lag:] != intervals[:-lag]] = 0.0
        np.maximum(farthest[:-lag], squares, out=farthest[:-lag])
    np.maximum.at(largest, intervals, farthest)
    for interval in np.flatnonzero(is_long).tolist():
        first = ranges.first[interval]
        largest[interval] = _largest_square(points[first : first + ranges.counts[interval]])
    return np.sqrt(largest)


def _largest_square(points: FloatArray) -> float:
    """Largest square of a distance between two of some points (N, 3) [m^2].

    No two are farther apart than both are from the middle, so that of people who stand for minutes hardly any point is
    compared: one which even with the outermost point comes to less than a distance that is known.
    """
    away = np.linalg.norm(points - 0.5 * (points.min(axis=0) + points.max(axis=0)), axis=1)
    end, known = points[np.argmax(away)], 0.0
    for _ in range(3):
        squares = np.sum((points - end) ** 2, axis=1)
        end, known = points[np.argmax(squares)], max(known, float(squares.max()))
    points = np.unique(points[away + away.max() >= (1.0 - 1e-9) * np.sqrt(known)], axis=0)
    for block in np.array_split(points, max(1, len(points) ** 2 // BLOCK)):
        gaps = block[:, None] - points
        known = max(known, float(np.sum(gaps**2, axis=-1).max(initial=0.0)))
    return known


def smallest_in_ranges(values: FloatArray, ranges: FrameRanges) -> FloatArray:
    """Smallest value of each range, NaN for an empty one, shape (K,).

    Args:
        values: Shape (F,).
        ranges: Frames of each of K intervals.
    """
    smallest = np.full(len(ranges.counts), np.inf)
    frames, intervals = ranges.flattened()
    np.minimum.at(smallest, intervals, values[frames])
    return np.where(ranges.counts == 0, np.nan, smallest)


def sole_offsets(skeleton: Skeleton, biped: Biped, stances: Sequence[FloatArray] | None = None) -> FloatArray:
    """Heel points of both soles in the frames of the ankle joints [m], shape (2, 3).

    The heel is the point of the sole under the ankle, moved back by 0.4 of the distance from ankle to ball
    (design.md section 2), where the feet stand level: in the rest pose, or else in mid stance. Feet that stand on their
    toes have none (`feet.heels_ahead`).

    Args:
        skeleton: The character's.
        biped: Its legs.
        stances: World rotations of the ankles in mid stance, shape (N, 4) for each foot; None = the rest pose stands.
    """
    positions, rotations = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    ankles, balls = list(biped.ankles), list(biped.balls)
    turns = rotations[ankles]
    offsets = quaternion.rotate(quaternion.inverse(turns), positions[balls] - positions[ankles])
    flat = flat_turns(turns, stances, offsets, same_pitch=HELD_FLAT) if stances is not None else None
    heights = np.asarray(biped.ball_heights)
    if flat is not None:
        lengths = np.linalg.norm(offsets, axis=1)
        alike = max(np.ptp(lengths), np.ptp(heights)) <= A_PAIR * lengths.max()
        turns = flattest(flat, offsets) if alike else flat
    return flat_heels(turns, offsets, heights)


def timing_faults(
    frame_times: FloatArray,
    balls: FloatArray,
    *,
    strike_times: FloatArray,
    flat_times: FloatArray,
    liftoff_times: FloatArray,
    radius: float = 0.015,
    speed: float = 0.15,
    shift: float = 0.001,
) -> BoolArray:
    """Which rules of timing each contact of one foot breaks (design.md section 10), shape (K, 3).

    A frame is planted if the ball is within `radius` of where it stands in the contact and leaves the frame slower
    than `speed`. Rules: (0) the first whole frame at or after flat is planted; (1) in the second half of the swing
    before, no frame earlier than one frame or 1/30 s (whichever is more) before the strike is planted; (2) one frame
    after the first frame past the liftoff, the ball has moved by at least `shift`. Rules without frames to check hold.

    Args:
        frame_times: Increasing times of the frames [s], shape (F,).
        balls: Ball of the foot [m], shape (F, 3).
        strike_times: First contacts [s], increasing, shape (K,).
        flat_times: Foot flat [s], shape (K,).
        liftoff_times: Ball leaves the ground [s], shape (K,).
        radius: Distance from the standing ball that counts as planted [m].
        speed: Speed below which the ball counts as standing [m/s].
        shift: Distance the ball must have moved after the liftoff [m].
    """
    planted = frames_between(frame_times, flat_times, liftoff_times)
    faults = np.zeros((len(strike_times), 3), dtype=bool)
    known = np.flatnonzero(planted.counts > 0)
    first, last = planted.first[known], planted.first[known] + planted.counts[known] - 1
    standing = balls[(first + last) // 2]
    steps = np.diff(frame_times)
    leaving = np.append(np.linalg.norm(np.diff(balls, axis=0), axis=1) / steps, 0.0)
    near = np.linalg.norm(balls[first] - standing, axis=1) <= radius
    faults[known, 0] = ~(near & ((leaving[first] <= speed) | (planted.counts[known] == 1)))

    lifted = np.concatenate([[frame_times[0]], liftoff_times[:-1]]) if len(strike_times) else liftoff_times
    margin = max(1.0 / 30.0, float(np.max(steps, initial=0.0)))
    middle = 0.5 * (lifted + strike_times)
    early = frames_between(frame_times, middle[known], strike_times[known] - margin - 2.0 * FRAME_TOLERANCE)
    frames, contacts = early.flattened()
    close = np.linalg.norm(balls[frames] - standing[contacts], axis=1) <= radius
    faults[known[contacts[close & (leaving[frames] <= speed)]], 1] = True

    after = last + 2
    inside = after < len(frame_times)
    moved = np.linalg.norm(balls[np.minimum(after, len(balls) - 1)] - balls[last], axis=1)
    faults[known, 2] = inside & (moved < shift)
    return faults
