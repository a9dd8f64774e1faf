"""Far agents' samples thinned out over the frames, as little as their planted feet allow.

[B] 8 proposes controllers that are updated in turns. Here every frame of everybody is known, and it is the samples that
take turns. What clients see in between is interpolated joint by joint, so a leg that swings over its foot moves the
ball: a sample is left out only where that stays within a tolerance.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import warp as wp

from usdfoot.analysis.figures import FRAME_TOLERANCE, largest_distances
from usdfoot.engine.contact_feet import ContactFeet
from usdfoot.engine.frames import Frames
from usdfoot.engine.interpolation import interpolate_poses
from usdfoot.engine.pose_source import Feet, Layout, Poses, pose_feet
from usdfoot.engine.results import planted_frames
from usdfoot.engine.rooted_poses import RootedPoses
from usdfoot.maths import quaternion
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.agent import Agent

__all__ = ["choose_samples"]

LEAST_LIMIT = 0.45
"""Part of the slide allowed by which every sample may drift: two that drift apart, each by it, and what the foot itself
slides are within what is allowed."""
LOWERED = 0.85
"""By how much the drift allowed in a contact is lowered at a time while its samples drift too far apart."""


def choose_samples(
    layout: Layout,
    feet: ContactFeet,
    frames: Frames,
    *,
    rooted: RootedPoses,
    measured: Feet,
    agents: Sequence[Agent],
    rate: float,
) -> tuple[BoolArray, Feet]:
    """Which samples are written, and the feet as seen with these alone.

    Args:
        layout: Of the agents.
        feet: How their contacts roll.
        frames: All samples there are.
        rooted: Their poses.
        measured: Their feet.
        agents: Who say at which frames they are sampled.
        rate: Frames a second [Hz].

    Returns:
        Whether each sample is written, shape (F,), and the feet at all of them.
    """
    if all(agent.sampled.every == 1 for agent in agents):
        return np.ones(len(frames.stamps), dtype=bool), measured
    tolerance = layout.options.subframe_slide
    kept = _own_turns(frames, agents, rate) | _beside_events(layout, feet, frames)
    kept[frames.first[:-1]] = kept[frames.first[1:] - 1] = True
    limits = np.full(len(layout.contacts.sides), tolerance)
    while True:
        left_out = np.flatnonzero(~kept)
        seen = _with_rows(measured, left_out, _seen_feet(layout, frames, rooted, kept, left_out))
        missed = _missed(layout, feet, frames, seen, measured, kept, limits)
        kept[missed] = True
        sliding = (_slides(layout, feet, frames, seen) > tolerance) & (limits > LEAST_LIMIT * tolerance)
        if not len(missed) and not sliding.any():
            return kept, seen
        limits = np.where(sliding, np.maximum(LOWERED * limits, LEAST_LIMIT * tolerance), limits)


def _own_turns(frames: Frames, agents: Sequence[Agent], rate: float) -> BoolArray:
    """Samples at the frames whose turn it is, and all of agents that have every frame, shape (F,)."""
    every, turn = (np.array([getattr(agent.sampled, name) for agent in agents]) for name in ("every", "turn"))
    codes = np.rint(frames.stamps * rate)
    whole = np.abs(frames.stamps - codes / rate) <= FRAME_TOLERANCE
    every, turn = every[frames.agents], turn[frames.agents]
    return (every == 1) | (whole & ((codes - turn) % every == 0))


def _beside_events(layout: Layout, feet: ContactFeet, frames: Frames) -> BoolArray:
    """Samples next to a strike, flat or liftoff, shape (F,)."""
    contacts = layout.contacts
    agents = np.tile(contacts.agents, 3)
    times = np.concatenate([contacts.strikes, feet.flats, contacts.liftoffs])
    before = locate(frames.agents, frames.stamps, contacts.starts, agents=agents, times=times + FRAME_TOLERANCE)
    after = before + (frames.stamps[before] < times - FRAME_TOLERANCE)
    beside = np.zeros(len(frames.stamps), dtype=bool)
    beside[before] = beside[np.minimum(after, frames.first[agents + 1] - 1)] = True
    return beside


def _seen_feet(layout: Layout, frames: Frames, rooted: RootedPoses, kept: BoolArray, rows: IntArray) -> Feet:
    """Feet at the samples `rows` (D,) if only those kept are written."""
    written = np.flatnonzero(kept)
    place = np.searchsorted(written, rows)
    before, after = written[place - 1], written[place]
    shares = (frames.stamps[rows] - frames.stamps[before]) / (frames.stamps[after] - frames.stamps[before])
    poses = _poses(rooted.pelvis_positions, rooted.pelvis_rotations, rooted.rotations)
    seen = interpolate_poses(layout, poses, before=before, after=after, shares=shares)
    roots = rooted.roots[before] + shares[:, None] * (rooted.roots[after] - rooted.roots[before])
    turn = quaternion.yaw_quaternion(roots[:, 3])
    origins = layout.origins[frames.agents[rows]]
    positions = quaternion.rotate(turn, seen.pelvis_positions.numpy().astype(float)) + (roots[:, :3] - origins)
    rotations = quaternion.compose(turn, seen.pelvis_rotations.numpy().astype(float))
    return pose_feet(layout.rig, _poses(positions, rotations, seen.rotations))


def _poses(positions: FloatArray, rotations: FloatArray, joints: wp.array) -> Poses:
    """Poses on the device of a pelvis (D, 3), (D, 4)."""
    return Poses(
        pelvis_positions=wp.array(positions.astype(np.float32), dtype=wp.vec3f),
        pelvis_rotations=wp.array(rotations.astype(np.float32), dtype=wp.quatf),
        rotations=joints,
    )


def _slides(layout: Layout, feet: ContactFeet, frames: Frames, seen: Feet) -> FloatArray:
    """Slide of each contact's ball over its planted samples [m], shape (C,)."""
    slides = np.zeros(len(layout.contacts.sides))
    for side in (0, 1):
        own = np.flatnonzero(layout.contacts.sides == side)
        slides[own] = largest_distances(seen.balls[:, side], planted_frames(layout, feet, frames, rows=own))
    return slides


def _missed(
    layout: Layout, feet: ContactFeet, frames: Frames, seen: Feet, measured: Feet, kept: BoolArray, limits: FloatArray
) -> IntArray:
    """Samples left out where a foot on the ground drifts farther than its contact's limit (C,) [m].

    Its ball, and until it is flat its ankle, for the heel stands then. Of those between two samples kept, only the
    worst: with it the others may do.
    """
    excess = np.full(len(kept), -np.inf)
    for side in (0, 1):
        contacts = frames.contacts[:, side]
        rolling = frames.times < feet.flats[contacts] - FRAME_TOLERANCE
        standing = frames.times <= layout.contacts.liftoffs[contacts] + FRAME_TOLERANCE
        drifts = np.linalg.norm(seen.balls[:, side] - measured.balls[:, side], axis=1)
        ankle_drifts = np.linalg.norm(seen.ankles[:, side] - measured.ankles[:, side], axis=1)
        drifts = np.where(rolling, np.maximum(drifts, ankle_drifts), drifts)
        excess = np.maximum(excess, np.where(standing & ~kept, drifts - limits[contacts], -np.inf))
    gaps = np.cumsum(kept)
    worst = np.full(len(kept) + 1, -np.inf)
    np.maximum.at(worst, gaps, excess)
    return np.flatnonzero((excess > 0.0) & (excess == worst[gaps]))


def _with_rows(feet: Feet, rows: IntArray, others: Feet) -> Feet:
    """Feet (F,) with others (D,) at the rows (D,)."""
    merged = {name: values.copy() for name, values in vars(feet).items()}
    for name, values in merged.items():
        values[rows] = getattr(others, name)
    return Feet(**merged)
