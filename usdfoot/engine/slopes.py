"""How feet stand on slopes: pitched, leaned and turned as far as ankles bend."""

from __future__ import annotations

import numpy as np

from usdfoot.engine.pose_source import Layout
from usdfoot.engine.rig import Rig
from usdfoot.engine.standing_foot import SHORT_OF_UPRIGHT
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.contact_table import EDGE_HEIGHT, ContactTable
from usdfoot.model.ground import Ground

__all__ = ["ankle_sinks", "lie_in_slopes", "planned_forwards"]

MOST_TOES_UP = np.radians(38.0)
"""Feet stand no steeper uphill, their heels stay in the air: as far as ankles bend under load, by the weight-bearing
lunge test [rad]."""
MOST_INVERSION, MOST_EVERSION = np.radians(35.0), np.radians(15.0)
"""Feet stand no steeper sideways, with the inner or the outer edge up (Brockett and Chapman's and others' clinical
norms, World J. Orthop. 2017, 8(1), Table 5) [rad]."""

STEP_UP = 0.1
"""Ground up to this far above a print is looked at [m]."""
ON_GROUND = 0.05
"""A print stands on ground that is less than this above or below it [m]."""
HEEL_RAISES = 6
"""How often the heel's ground is looked up where the raised heel is."""


def lie_in_slopes(layout: Layout, ground: Ground) -> tuple[FloatArray, BoolArray]:
    """Frames of the prints: yaw from the plan, pitch and roll from the ground under ball and heel ([B] 4.5).

    Feet lie in the slope under the ball, turned about their own axes: first the heel up to the ground behind, at most
    until the ankle is over the ball, then as far back as ankles bend, then about the sole's normal. A foot that leans
    carries its ankle sideways, above the ball, and the yaw is that of the line from ankle to ball, seen along the
    plan's normal (design.md section 2).

    Returns:
        Rotations print to world, shape (C, 4), and whether walkable ground is under the ball, shape (C,).
    """
    contacts = layout.contacts
    across, up, ahead, on_ground = _slopes(contacts, ground)
    slope = np.stack([np.cross(up, ahead), up, ahead], axis=-1)  # (C, 3, 3)
    lengths = layout.rig.foot_lengths[contacts.sides]
    rises = np.zeros(len(lengths))
    frames = _turned_feet(layout, slope, across, rises)
    for attempt in range(HEEL_RAISES if ground.has_terrain else 0):
        found, gaps = _under_heels(layout, ground, frames)
        follow = found & ((gaps > 0.0) | (np.abs(gaps) < EDGE_HEIGHT) & (attempt == 0))
        rises = np.clip(rises + np.where(follow, gaps * up[:, 1], 0.0), -lengths, lengths)
        frames = _turned_feet(layout, slope, across, rises)
    return frames, on_ground


def ankle_sinks(rig: Rig, contacts: ContactTable, ground: Ground) -> FloatArray:
    """How much lower the ankles of feet are that lie in slopes they point up, than on level ground [m], shape (C,)."""
    to_ball = np.array([quaternion.rotate(foot.flat_rotation, foot.ball_offset) for foot in rig.feet])[contacts.sides]
    rises = np.clip(np.arcsin(_slopes(contacts, ground)[2][:, 1]), 0.0, MOST_TOES_UP)
    return np.maximum(to_ball[:, 2] * np.sin(rises) - to_ball[:, 1] * (1.0 - np.cos(rises)), 0.0)


def _slopes(contacts: ContactTable, ground: Ground) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Across the prints as planned, up and ahead in the slopes under the balls, unit (C, 3), and which are walkable."""
    under = ground.heights(contacts.positions[:, [0, 2]], contacts.positions[:, 1], step_up=STEP_UP)
    near = np.abs(under.heights - contacts.positions[:, 1]) < ON_GROUND
    on_slope = ground.has_terrain & under.hit & near
    across = np.cross(contacts.normals, planned_forwards(contacts))
    up = np.where(on_slope[:, None], under.normals, contacts.normals)
    ahead = np.cross(across, up)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    return across, up, ahead, ~np.bool_(ground.has_terrain) | (under.hit & under.walkable & near)


def _turned_feet(layout: Layout, slope: FloatArray, across: FloatArray, rises: FloatArray) -> FloatArray:
    """Frames of feet (C, 4) that lie in slopes, their heels raised and turned as far as ankles bend.

    Args:
        layout: Contacts and feet.
        slope: Frames +Z ahead and +Y the slope's normal, as matrices, shape (C, 3, 3).
        across: What the lines from ankles to balls are to be at right angles to, unit vectors (C, 3).
        rises: Heels above the slope [m], shape (C,).
    """
    sides = layout.contacts.sides
    left, up, ahead = np.moveaxis(slope, 2, 0)
    to_ball = np.array([quaternion.rotate(foot.flat_rotation, foot.ball_offset) for foot in layout.rig.feet])[sides]
    upright = np.arctan2(to_ball[:, 2], -to_ball[:, 1]) - SHORT_OF_UPRIGHT
    pitch = np.maximum(np.arcsin(rises / layout.rig.foot_lengths[sides]), _elevations(ahead, up) - MOST_TOES_UP)
    up, ahead = _turned(up, ahead, np.minimum(pitch, upright))
    outwards = np.where(sides == 0, 1.0, -1.0)
    lean = outwards * _elevations(left, up)
    left, up = _turned(left, up, outwards * (np.clip(lean, -MOST_INVERSION, MOST_EVERSION) - lean))
    shares = [np.sum(axis * across, axis=1) for axis in (left, up, ahead)]
    aside = -to_ball[:, 1] / to_ball[:, 2] * shares[1] / np.hypot(shares[0], shares[2])
    turn = np.arcsin(np.clip(aside, -1.0, 1.0)) - np.arctan2(shares[2], shares[0])
    ahead, left = _turned(ahead, left, turn)
    return quaternion.from_matrix(np.stack([left, up, ahead], axis=-1))


def _turned(first: FloatArray, second: FloatArray, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors (C, 3) at right angles turned from the second to the first's opposite by angles (C,) [rad]."""
    cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
    return cosine * first + sine * second, cosine * second - sine * first


def _elevations(vectors: FloatArray, up: FloatArray) -> FloatArray:
    """Angle by which vectors (C, 3) must turn in the plane with `up` (C, 3), at right angles, to be level [rad]."""
    return np.arctan2(vectors[:, 1], up[:, 1])


def _under_heels(layout: Layout, ground: Ground, frames: FloatArray) -> tuple[BoolArray, FloatArray]:
    """Whether there is ground under the heels of flat feet, and how far it is above them [m], shape (C,) each."""
    contacts, feet = layout.contacts, layout.rig.feet
    behind = np.array([quaternion.rotate(foot.flat_rotation, foot.heel_offset - foot.ball_offset) for foot in feet])
    heels = contacts.positions + quaternion.rotate(frames, behind[contacts.sides])
    up = quaternion.rotate(frames, np.array([0.0, 1.0, 0.0]))[:, 1]
    heels[:, 1] += layout.rig.arrays.ball_heights.numpy()[contacts.sides] / up
    reach = contacts.positions[:, 1] + layout.rig.foot_lengths[contacts.sides]
    found = ground.heights(heels[:, [0, 2]], reach, step_up=0.0)
    return found.hit, found.heights - heels[:, 1]


def planned_forwards(contacts: ContactTable) -> FloatArray:
    """Forward of the prints as planned, across their normals, unit vectors (C, 3)."""
    level, normals = planar.direction(contacts.yaws), contacts.normals
    rise = -np.sum(normals[:, [0, 2]] * level, axis=1) / normals[:, 1]
    forward = np.stack([level[:, 0], rise, level[:, 1]], axis=1)
    return forward / np.linalg.norm(forward, axis=1, keepdims=True)
