"""Root path: the agent's planar position, yaw and ground height, from its contacts ([B] 4.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.engine.segments import Segments
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable

__all__ = ["RootPath", "lay_root", "root_at"]


@dataclass(frozen=True, kw_only=True)
class RootPath:
    """Cubic Hermite pieces, one a segment; columns x, y (ground), z [m], yaw [rad] and the pelvis's ground [m]."""

    begins: FloatArray
    ends: FloatArray
    """Values at both ends, shape (M, 5)."""
    begin_slopes: FloatArray
    end_slopes: FloatArray
    """Rates at both ends [1/s], shape (M, 5)."""
    times: FloatArray
    durations: FloatArray
    """Begin and duration of each piece [s], shape (M,)."""


def lay_root(
    contacts: ContactTable, segments: Segments, *, step_height_share: float, sinks: FloatArray | None = None
) -> RootPath:
    """Path through the middle of consecutive contacts at each strike, at rest in stands.

    The height goes monotonically between the means of the contacts' heights. The pelvis's ground lies lower where the
    feet stand at different heights, since the leg below must reach: `step_height_share` up from the lower foot. Where a
    flight ends it is level for an instant: it rises and falls in the push and the flight, not over the leg that lands.

    Args:
        contacts: As executed.
        segments: Of all agents.
        step_height_share: See above.
        sinks: How much lower the ankle of each foot is that lies in its slope [m], shape (C,); the pelvis's ground is
            as much lower where both stand. None = nowhere.
    """
    supports = segments.supports
    last = len(contacts.sides) - 1
    following = np.where(segments.stands, supports, np.minimum(supports + 1, last))
    before = np.where(segments.stands, supports - 1, supports)
    begins = _values(contacts, supports - 1, supports, step_height_share)
    ends = _values(contacts, before, following, step_height_share)
    if sinks is not None:
        stood = np.zeros(last + 1)  # by the later contact of each stand
        stood[supports[segments.stands]] = 0.5 * (sinks[supports - 1] + sinks[supports])[segments.stands]
        begins[:, 4] -= stood[supports]
        ends[:, 4] -= stood[following]
    durations = np.maximum(segments.ends - segments.begins, 1e-6)
    secants = (ends - begins) / durations[:, None]
    inner = segments.joined[1:-1]
    slopes = _seam_slopes(secants[:-1], secants[1:], durations[:-1], durations[1:])
    landed = contacts.liftoffs[supports[1:] - 1] < contacts.strikes[supports[1:]]
    slopes[landed, 4] = 0.0
    still = segments.stands[:-1] | segments.stands[1:]
    slopes[still] = 0.0
    begin_slopes, end_slopes = secants.copy(), secants.copy()
    begin_slopes[1:][inner] = slopes[inner]
    end_slopes[:-1][inner] = slopes[inner]
    return RootPath(
        begins=begins,
        ends=ends,
        begin_slopes=begin_slopes,
        end_slopes=end_slopes,
        times=segments.begins,
        durations=durations,
    )


def _values(contacts: ContactTable, first: IntArray, second: IntArray, share: float) -> FloatArray:
    """Middle of two contacts, the heading at the later one's strike, and the pelvis's ground, shape (M, 5)."""
    middle = 0.5 * (contacts.positions[first] + contacts.positions[second])
    apart = np.abs(contacts.positions[first, 1] - contacts.positions[second, 1])
    lowered = middle[:, 1] - (0.5 - share) * apart
    return np.concatenate([middle, contacts.headings[second][:, None], lowered[:, None]], axis=1)


def _seam_slopes(first: FloatArray, second: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
    """Slopes of the parabola through three knots; of the heights limited so that they stay monotone."""
    share = (after / (before + after))[:, None]
    slopes = share * first + (1.0 - share) * second
    heights = [1, 4]
    product = first[:, heights] * second[:, heights]
    total = first[:, heights] + second[:, heights]
    slopes[:, heights] = np.where(product > 0.0, 2.0 * product / np.where(product > 0.0, total, 1.0), 0.0)
    return slopes


def root_at(path: RootPath, rows: IntArray, times: FloatArray) -> FloatArray:
    """x, ground height, z [m], yaw [rad] and pelvis's ground [m] of segments `rows` at `times` [s], shape (F, 5)."""
    length = path.durations[rows]
    x = np.clip((times - path.times[rows]) / length, 0.0, 1.0)[:, None]
    length = length[:, None]
    rest = 1.0 - x
    return (
        rest**2 * (1.0 + 2.0 * x) * path.begins[rows]
        + x**2 * (1.0 + 2.0 * rest) * path.ends[rows]
        + length * (x * rest**2 * path.begin_slopes[rows] - x**2 * rest * path.end_slopes[rows])
    )
