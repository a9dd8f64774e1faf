"""Samples between frames where a planted foot would drift.

Clients interpolate each joint by itself, so a leg that swings fast over its foot moves the ball halfway between frames.
"""

from __future__ import annotations

import numpy as np
import warp as wp

from usdfoot.analysis.figures import FRAME_TOLERANCE
from usdfoot.engine.contact_feet import ContactFeet
from usdfoot.engine.frames import Frames, frames_at
from usdfoot.engine.interpolation import interpolate_poses
from usdfoot.engine.pose_source import Feet, Layout, Poses, pose_feet
from usdfoot.maths.types import BoolArray, IntArray

__all__ = ["drifting_frames", "insert_frames", "merge_poses"]


def drifting_frames(
    layout: Layout, feet: ContactFeet, frames: Frames, *, poses: Poses, measured: Feet, tolerance: float
) -> BoolArray:
    """Whether a planted ball leaves its place by more than `tolerance` [m] before the next frame, shape (F,)."""
    count = len(frames.times) - 1
    drifting = np.zeros(count + 1, dtype=bool)
    if count < 1:
        return drifting
    rows = np.arange(count)
    half = interpolate_poses(layout, poses, before=rows, after=rows + 1, shares=np.full(count, 0.5))
    balls = pose_feet(layout.rig, half).balls
    liftoffs = layout.contacts.liftoffs
    for side in (0, 1):
        contact = frames.contacts[:, side]
        held = (contact[:-1] == contact[1:]) & (frames.agents[:-1] == frames.agents[1:])
        held &= frames.times[:-1] >= feet.flats[contact[:-1]] - FRAME_TOLERANCE
        held &= frames.times[1:] <= liftoffs[contact[1:]] + FRAME_TOLERANCE
        moved = np.linalg.norm(balls[:, side] - measured.balls[:-1, side], axis=1)
        drifting[:-1] |= held & (moved > tolerance)
    return drifting


def insert_frames(layout: Layout, frames: Frames, rows: BoolArray) -> tuple[Frames, Frames, IntArray]:
    """Frames halfway after `rows` (F,).

    Returns:
        The new frames alone, all frames, and the order that brings old frames followed by new ones into that of all.
    """
    chosen = np.flatnonzero(rows)
    agents = frames.agents[chosen]
    stamps = 0.5 * (frames.stamps[chosen] + frames.stamps[chosen + 1])
    added = frames_at(layout.contacts, layout.segments, agents=agents, stamps=stamps)
    all_agents, all_stamps = np.append(frames.agents, agents), np.append(frames.stamps, stamps)
    order = np.lexsort((all_stamps, all_agents))
    return added, frames_at(layout.contacts, layout.segments, agents=all_agents[order], stamps=all_stamps[order]), order


def merge_poses(first: Poses, second: Poses, order: IntArray) -> Poses:
    """Frames of both poses in the given order."""

    def merged(name: str, kind: type) -> wp.array:
        values = np.concatenate([getattr(first, name).numpy(), getattr(second, name).numpy()])[order]
        return wp.array(values, dtype=kind)

    return Poses(
        pelvis_positions=merged("pelvis_positions", wp.vec3f),
        pelvis_rotations=merged("pelvis_rotations", wp.quatf),
        rotations=merged("rotations", wp.quatf),
    )
