"""Gaps: what of a level is too narrow for a body, closed (extra `crowd`)."""

from __future__ import annotations

import numpy as np
import shapely

from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.planning.itineraries import SNUG

__all__ = ["without_gaps"]

HAIR = 1e-3
"""So near [m] to a straight line corners of a level are none; so thick is half of what closes a gap."""
THIN = 1e-5
"""No part of a level is thinner than twice this [m]: JuPedSim takes no walls that touch themselves."""


def without_gaps(level: shapely.Polygon, radius: float) -> shapely.Polygon:
    """A level without what is narrower than a body of a radius [m].

    Discs from either side of a gap between two corners of walls meet in it, though none gets through: such gaps are
    closed by a line. Where that would leave several rooms, in each of which people may be, they stay.
    """
    if radius <= 0.0:
        return level
    room = level.buffer(-SNUG * radius)
    wide = room.buffer(SNUG * radius, join_style="mitre").intersection(level).simplify(HAIR)
    if wide.geom_type != "Polygon":
        return level
    if room.geom_type != "Polygon" or len(wide.interiors) <= len(room.interiors):
        return wide  # a gap that is closed makes one of two walls
    closed = wide.difference(_lines_across(wide, 2.0 * SNUG * radius).buffer(HAIR, cap_style="square"))
    parts = shapely.get_parts(closed.buffer(-THIN, join_style="mitre").buffer(THIN, join_style="mitre").simplify(THIN))
    parts = parts[shapely.intersects(parts, room)]
    return parts[0] if len(parts) == 1 else wide


def _lines_across(level: shapely.Polygon, width: float) -> shapely.MultiLineString:
    """The shortest lines over a level from corners of its walls to walls that are less than a width [m] away."""
    level = shapely.geometry.polygon.orient(level)
    rings = [shapely.get_coordinates(ring) for ring in (level.exterior, *level.interiors)]
    walls = shapely.linestrings(np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings]))
    corners = shapely.points(np.concatenate([ring[:-1][_juts_out(ring)] for ring in rings]))
    near, wall = shapely.STRtree(walls).query(corners, "dwithin", distance=width)
    lines = shapely.shortest_line(corners[near], walls[wall])
    middles = shapely.get_coordinates(shapely.line_interpolate_point(lines, 0.5, normalized=True))
    shapely.prepare(level)
    return shapely.multilinestrings(lines[shapely.contains_xy(level, middles[:, 0], middles[:, 1])])


def _juts_out(ring: FloatArray) -> BoolArray:
    """Which corners of a closed ring (C + 1, 2), its level on the left, jut out into that, shape (C,)."""
    after = np.diff(ring, axis=0)
    before = np.roll(after, 1, axis=0)
    return np.asarray(before[:, 0] * after[:, 1] < before[:, 1] * after[:, 0])
