"""Feet of a written agent: from when they count as planted, where heels and soles are, which stand in the air."""

from __future__ import annotations

import numpy as np

from usdfoot.analysis.feet import HEEL_REACH
from usdfoot.analysis.figures import (
    FrameRanges,
    sole_offsets,
)
from usdfoot.maths import quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import EDGE_HEIGHT
from usdfoot.model.ground import Ground
from usdfoot.readers.joint_tracks import JointTracks
from usdfoot.readers.written import WrittenAgent

__all__ = ["LONGEST_ROLL", "floating_feet", "heel_points", "planted_times", "sole_heights"]

LONGEST_ROLL = 0.12
SHARE_OF_ROLL = 0.25
"""The foot is flat at most this long [s], and this part of the contact, after the strike (design.md section 2)."""
STANCE = (0.0, 0.1, 0.2, 0.4, 0.6)
"""Parts of the time from flat to liftoff, at one of which at least the foot stands flat."""
NEAR_FOOTSTEP = 0.1
"""Ground no higher than this above a footstep is what it stands on [m]."""
PLANTED = 0.015
"""A sole higher than this does not stand [m]."""


def planted_times(agent: WrittenAgent) -> FloatArray:
    """Times from which feet count as planted: flat, at the latest as design.md section 2 allows [s], shape (N,)."""
    plan = agent.plan
    latest = plan.strike_times + np.minimum(LONGEST_ROLL, SHARE_OF_ROLL * (plan.liftoff_times - plan.strike_times))
    return np.fmin(agent.flat_times, latest)


def heel_points(agent: WrittenAgent, tracks: JointTracks, ground: Ground | None) -> FloatArray:
    """Heel points of both feet in the world [m], shape (F, 2, 3)."""
    ankles = list(agent.biped.ankles)
    stances = [_stances(agent, tracks, side, ground) for side in (0, 1)]
    offsets = sole_offsets(agent.skeleton, agent.biped, stances)
    return tracks.positions[:, ankles] + quaternion.rotate(tracks.turns(ankles), offsets)


def _stances(agent: WrittenAgent, tracks: JointTracks, side: int, ground: Ground | None) -> FloatArray:
    """Rotations of one ankle where the heel is lowest in the contacts that have frames, from level ground, (N, 4).

    Only of the half on the ground that is least steep: where it is steeper than ankles bend, feet do not lie on it.
    """
    flats, liftoffs = planted_times(agent)[:, None], agent.plan.liftoff_times[:, None]
    instants = flats + (liftoffs - flats) * np.array(STANCE)  # (N, S)
    seen = (instants >= tracks.times[0]) & (instants <= tracks.times[-1])
    own = (agent.plan.sides == side) & seen.all(axis=1)
    frames = np.searchsorted(tracks.times, instants[own])
    ankle, ball = agent.biped.ankles[side], agent.biped.balls[side]
    feet = tracks.positions[:, ball] - tracks.positions[:, ankle]
    lowest = frames[np.arange(len(frames)), np.argmax(feet[frames, 1], axis=1)]
    turns = tracks.turns([ankle])[lowest, 0]
    if ground is None:
        return turns
    up = _ground_under_feet(agent.plan.positions[own], feet[lowest], ground)
    level = up[:, 1] >= np.median(up[:, 1]) if len(up) else np.zeros(0, dtype=bool)
    return quaternion.compose(quaternion.between(up, np.array([0.0, 1.0, 0.0])), turns)[level]


def _ground_under_feet(balls: FloatArray, feet: FloatArray, ground: Ground) -> FloatArray:
    """Normals of the ground from under the balls to under the heels of feet that stand, unit vectors (N, 3).

    Args:
        balls: Footsteps [m], shape (N, 3).
        feet: From ankle to ball [m], shape (N, 3).
        ground: Heels keep to it as long as it does not fall off behind the ball.
    """
    under = ground.heights(balls[:, [0, 2]], balls[:, 1], step_up=NEAR_FOOTSTEP)
    ahead = feet * [1.0, 0.0, 1.0]
    ahead *= 1.0 + HEEL_REACH * (np.linalg.norm(feet, axis=1) / np.linalg.norm(ahead, axis=1))[:, None]
    behind = ground.heights((balls - ahead)[:, [0, 2]], balls[:, 1] + np.linalg.norm(ahead, axis=1), step_up=0.0)
    slope = -np.sum(under.normals * ahead, axis=1) / under.normals[:, 1]
    rise = under.heights - behind.heights
    ahead[:, 1] = np.where(behind.hit & (rise < slope + EDGE_HEIGHT), rise, slope)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    up = under.normals - np.sum(under.normals * ahead, axis=1, keepdims=True) * ahead
    return up / np.linalg.norm(up, axis=1, keepdims=True)


def floating_feet(
    agent: WrittenAgent, balls: FloatArray, planted: FrameRanges, *, steps: IntArray, ground: Ground | None
) -> BoolArray:
    """Which `steps` (K,) of one foot stand in the air: over their footstep and over the ground, shape (K,)."""
    plan, empty = agent.plan, planted.counts == 0
    standing = balls[np.where(empty, 0, planted.first + planted.counts // 2)]
    normals = quaternion.rotate(plan.orientations[steps], np.array([0.0, 1.0, 0.0]))
    soles = standing[:, 1] - np.array(agent.biped.ball_heights)[plan.sides[steps]] / np.maximum(normals[:, 1], 0.1)
    heights = soles - plan.positions[steps, 1]
    if ground is not None:
        sample = ground.heights(standing[:, [0, 2]], soles)
        heights = np.where(sample.hit, np.minimum(heights, soles - sample.heights), heights)
    return np.asarray(~empty & (heights > PLANTED))


def sole_heights(agent: WrittenAgent, tracks: JointTracks, heels: FloatArray, *, ground: Ground) -> FloatArray:
    """Height over the terrain of the soles under ball and heel [m], NaN off the terrain, shape (F, 2 feet, 2)."""
    soles = tracks.positions[:, list(agent.biped.balls)].copy()
    soles[..., 1] -= agent.biped.ball_heights
    points = np.stack([soles, heels], axis=2)  # (F, 2, 2, 3)
    flat = points.reshape(-1, 3)
    sample = ground.heights(flat[:, [0, 2]], flat[:, 1])
    heights = np.where(sample.hit, flat[:, 1] - sample.heights, np.nan)
    return heights.reshape(points.shape[:3])
