"""Clocks: what the time means in every segment, on the device."""

from __future__ import annotations

import numpy as np
import warp as wp

from usdfoot.engine.clock_kernel import ClockArrays
from usdfoot.engine.flight import flight_falls
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.root import RootPath
from usdfoot.engine.segments import Segments
from usdfoot.engine.windows import seam_lengths
from usdfoot.maths.monotone import pchip_slopes
from usdfoot.maths.types import FloatArray
from usdfoot.model.contact_table import ContactTable

__all__ = ["device_clocks"]

GROUND = 4
"""Column of a root path that has the pelvis's ground."""


def device_clocks(
    contacts: ContactTable,
    segments: Segments,
    path: RootPath,
    *,
    twists: FloatArray,
    natural: FloatArray,
    warps: FloatArray,
    levels: FloatArray,
    options: EngineOptions,
) -> ClockArrays:
    """Segments' events, ground, flights and seams as device arrays.

    Args:
        contacts: As executed.
        segments: M of them.
        path: Their root path.
        twists: Turn about the support ball by the end of each [rad], shape (M,).
        natural: Duration of the blended examples' flights [s], shape (M,).
        warps: Planned durations of the steps over those of their examples, shape (M,).
        levels: Height of the agents' origins [m], shape (A,).
        options: Kind and times of the seams.
    """
    clock = contacts.starts[segments.agents]
    flights = flight_falls(contacts, segments, natural, warps=warps)
    flights[:, 0] -= clock
    landed = np.where(segments.joined[:-1, None], np.roll(flights, 1, axis=0), 0.0)
    level = levels[segments.agents]
    ends = (path.begins[:, GROUND] - level, path.ends[:, GROUND] - level)
    slopes = (path.begin_slopes[:, GROUND], path.end_slopes[:, GROUND])
    arrays = ClockArrays()
    for name, values, kind in (
        ("begins", segments.begins - clock, wp.float64),
        ("ends", segments.ends - clock, wp.float64),
        ("knot_times", segments.knot_times - clock[:, None], wp.vec4d),
        ("knot_shares", segments.knot_shares, wp.vec4d),
        ("knot_slopes", pchip_slopes(segments.knot_times, segments.knot_shares), wp.vec4d),
        ("headings", contacts.headings[segments.supports], wp.float64),
        ("twists", twists, wp.float64),
        ("grounds", np.stack([*ends, *slopes], axis=1), wp.vec4d),
        ("releases", contacts.liftoffs[segments.supports] - clock, wp.float64),
        ("flights", flights, wp.vec3d),
        ("landed_flights", landed, wp.vec3d),
        ("seam_lengths", seam_lengths(segments, options), wp.vec4d),
    ):
        setattr(arrays, name, wp.array(np.ascontiguousarray(values, dtype=np.float64), dtype=kind, copy=False))
    arrays.seam_kind = {"none": 0, "inertialise": 1, "crossfade": 2}[options.seam]
    return arrays
