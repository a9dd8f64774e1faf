"""Planting: poses of any source, with the feet held on their footsteps, become samples and motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.engine.contact_feet import ContactFeet, device_feet, unplanted_feet, with_values
from usdfoot.engine.detours import KNOTS, plan_detours
from usdfoot.engine.feet import lead_swings, lower_pelvis, raise_heels, roll_contacts, settle_heels
from usdfoot.engine.frames import Frames, lay_frames
from usdfoot.engine.held_feet import hold_feet
from usdfoot.engine.plant import plant_feet
from usdfoot.engine.pose_source import Feet, Layout, Poses, PoseSource, pose_feet
from usdfoot.engine.results import achieved_contacts
from usdfoot.engine.rooted_poses import RootedPoses, root_poses
from usdfoot.engine.subframes import drifting_frames, insert_frames, merge_poses
from usdfoot.engine.thinning import choose_samples
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.contact_table import ContactTable
from usdfoot.model.ground import Ground
from usdfoot.model.motion import Motion, StepResults

__all__ = ["Due", "Planted", "Planting", "cut_motions", "plant_frames", "plant_samples", "prepare_planting"]
STANCE = np.array([0.0, 0.2, 0.4, 0.6])
"""Parts of the time from flat to the other foot's strike, at one of which a heel that comes down is down."""
HALVINGS = 3
"""How often the time between two frames is halved at most where a planted ball would drift."""


@dataclass(frozen=True, kw_only=True)
class Planting:
    """What moves the bodies and what holds their feet: any frame can be computed from it on its own."""

    layout: Layout
    source: PoseSource
    feet: ContactFeet
    detours: FloatArray
    """Offsets of each contact's swing [m], shape (C, K, 3)."""


@dataclass(frozen=True, kw_only=True)
class Planted:
    """Finished samples of all agents."""

    frames: Frames
    poses: RootedPoses
    kept: BoolArray
    """Whether each sample is written, shape (F,)."""
    feet: Feet
    """As seen with what is written: where a sample is not, on what is interpolated there."""


@dataclass(frozen=True, kw_only=True)
class Due:
    """Contacts whose feet are to be prepared, increasing."""

    strikes: IntArray
    """Those to lay and roll."""
    flats: IntArray
    """Those whose pitch is measured when they are flat."""
    leaves: IntArray
    """Those for whose liftoffs the pelvis comes down and the heel rises in time."""
    swings: IntArray
    """Those whose swings are led and kept off the ground; each swing's end is among the strikes."""


def prepare_planting(
    layout: Layout,
    source: PoseSource,
    ground: Ground,
    *,
    known: Planting | None = None,
    due: Due | None = None,
    sinks_for_flights: bool = True,
) -> Planting:
    """Prints, rolls, leads and detours of contacts and swings for the poses of a source.

    Args:
        layout: All contacts.
        source: What moves the bodies.
        ground: The terrain.
        known: What was prepared before of the other contacts.
        due: Those to prepare; None = all.
        sinks_for_flights: Whether the pelvis comes down in time for legs that take off or land too far away; not where
            the source's bodies fly as physics has it.
    """
    contacts = layout.contacts
    count = len(contacts.sides)
    every, swings = np.arange(count), np.flatnonzero(contacts.has_swing)
    due = due or Due(strikes=every, flats=every, leaves=np.flatnonzero(contacts.has_next), swings=swings)
    feet = prepare_feet(
        layout,
        source,
        ground,
        feet=known.feet if known else unplanted_feet(count),
        due=due,
        sinks_for_flights=sinks_for_flights,
    )
    detours = known.detours.copy() if known else np.zeros((count, KNOTS, 3))
    detours[due.swings] = plan_detours(layout, source, feet, ground=ground, rows=due.swings)
    return Planting(layout=layout, source=source, feet=feet, detours=detours)


def prepare_feet(
    layout: Layout, source: PoseSource, ground: Ground, *, feet: ContactFeet, due: Due, sinks_for_flights: bool
) -> ContactFeet:
    """Feet with prints, rolls and leads, from the source's feet at strikes and liftoffs."""
    contacts = layout.contacts
    flown = contacts.flown[due.strikes]
    left = _left(contacts, due.leaves, sinks_for_flights)
    reached = np.flatnonzero(~flown | sinks_for_flights)
    rows = np.concatenate([due.strikes, due.swings, left])
    struck, moved = len(due.strikes), len(due.strikes) + len(due.swings)
    times = np.where(np.arange(len(rows)) < struck, contacts.strikes[rows], contacts.liftoffs[rows])
    blended = _feet_at(layout, source, rows, times)
    raises = blended.raises[np.arange(struck), contacts.sides[due.strikes]]
    feet = with_values(feet, left, {"leave_raises": np.zeros(len(left))})
    feet = roll_contacts(layout, feet, due.strikes, raises=raises, ground=ground)
    raises = _stance_raises(layout, source, due.flats, feet.flats[due.flats])
    feet = with_values(feet, due.flats, {"flat_pitches": raises[:, 0]})
    feet = settle_heels(feet, due.flats, raises)
    held = hold_feet(layout, feet, rows, times=times, blended=blended)
    leaves, lands = held[struck:moved], held[np.searchsorted(due.strikes, due.swings + 2)]
    feet = lead_swings(layout, feet, due.swings, leaves=leaves, lands=lands)
    last = np.arange(moved, len(rows))
    feet = raise_heels(layout, feet, left, times=times[last], blended=blended[last])
    return lower_pelvis(layout, feet, rows=due.strikes[reached], lands=held[reached], left=left, leaves=held[moved:])


def _stance_raises(layout: Layout, source: PoseSource, rows: IntArray, flats: FloatArray) -> FloatArray:
    """Pitch of the source's feet of contacts `rows` (N,) from flat until the other foot strikes [rad], shape (N, S)."""
    contacts = layout.contacts
    following = np.minimum(rows + 1, len(contacts.sides) - 1)
    ends = np.where(contacts.has_next[rows], contacts.strikes[following], contacts.ends[contacts.agents[rows]])
    ends = np.maximum(np.minimum(ends, contacts.liftoffs[rows]), flats)
    times = flats[:, None] + (ends - flats)[:, None] * STANCE
    feet = _feet_at(layout, source, np.repeat(rows, len(STANCE)), times.ravel())
    sides = np.repeat(contacts.sides[rows], len(STANCE))
    return feet.raises[np.arange(len(sides)), sides].reshape(times.shape)


def _left(contacts: ContactTable, leaves: IntArray, sinks_for_flights: bool) -> IntArray:
    """Contacts of `leaves` (N,) that are left within the motion, into flights only where `sinks_for_flights`."""
    flies = contacts.flown[leaves + 1]
    walks = contacts.has_swing[leaves] & (contacts.liftoffs[leaves] > contacts.starts[contacts.agents[leaves]])
    return leaves[np.where(flies, sinks_for_flights, walks)]


def _feet_at(layout: Layout, source: PoseSource, rows: IntArray, times: FloatArray) -> Feet:
    """Feet of the source at one time for each of the contacts `rows` [s], not before its agent's first strike."""
    contacts, segments = layout.contacts, layout.segments
    agents = contacts.agents[rows]
    times = np.maximum(times, contacts.starts[agents])
    found = locate(segments.agents, segments.begins, contacts.starts, agents=agents, times=times)
    return pose_feet(layout.rig, source.pose(found, times, joints=layout.rig.leg_joints))


def plant_samples(planting: Planting, crowd: Crowd, agents: Sequence[Agent]) -> Planted:
    """The agents' samples: at the crowd's frames, and between those that would let a planted ball drift.

    Args:
        planting: Of the agents.
        crowd: Whose frames they are.
        agents: Who say at which frames they are sampled.
    """
    layout = planting.layout
    frames = lay_frames(layout.contacts, layout.segments, crowd.frame_times)
    poses = plant_frames(planting, frames)
    feet = pose_feet(layout.rig, poses)
    tolerance = layout.options.subframe_slide
    for _ in range(HALVINGS):
        drifting = drifting_frames(layout, planting.feet, frames, poses=poses, measured=feet, tolerance=tolerance)
        if not drifting.any():
            break
        added, frames, order = insert_frames(layout, frames, drifting)
        poses = merge_poses(poses, plant_frames(planting, added), order)
        feet = pose_feet(layout.rig, poses)
    rooted = root_poses(layout, frames, poses, agents=agents)
    kept, feet = choose_samples(
        layout, planting.feet, frames, rooted=rooted, measured=feet, agents=agents, rate=crowd.frame_rate
    )
    return Planted(frames=frames, poses=rooted, kept=kept, feet=feet)


def plant_frames(planting: Planting, frames: Frames) -> Poses:
    """Frames posed and planted."""
    layout = planting.layout
    joints = np.setdiff1d(np.arange(len(layout.skeleton.joints)), [layout.pelvis])
    poses = planting.source.pose(frames.segments, frames.times, joints=joints)
    clock = frames.times - layout.contacts.starts[frames.agents]
    wp.launch(
        plant_feet,
        dim=len(frames.times),
        inputs=[
            layout.rig.arrays,
            device_feet(layout, planting.feet, planting.detours),
            wp.array(frames.contacts.astype(np.int32), dtype=wp.int32, copy=False),
            wp.array(clock.astype(np.float32), dtype=wp.float32, copy=False),
            wp.empty((0, 2), dtype=wp.vec3f),
            wp.empty((0, 2), dtype=wp.vec3f),
            poses.pelvis_positions,
            poses.pelvis_rotations,
            poses.rotations,
        ],
    )
    return poses


def cut_motions(
    planting: Planting, planted: Planted, results: Sequence[StepResults], *, agents: Sequence[Agent]
) -> list[Motion]:
    """Samples that are written, cut into one motion an agent."""
    layout, frames, poses = planting.layout, planted.frames, planted.poses
    rotations = poses.rotations.numpy()
    rotations[:, layout.pelvis] = poses.pelvis_rotations
    motions = []
    for index, agent in enumerate(agents):
        first, stop = frames.first[index], frames.first[index + 1]
        kept = planted.kept[first:stop]
        own = slice(first, stop) if kept.all() else first + np.flatnonzero(kept)
        motions.append(
            Motion(
                name=agent.name,
                times=frames.stamps[own],
                root_positions=poses.roots[own, :3],
                root_yaws=poses.roots[own, 3],
                pelvis_positions=poses.pelvis_positions[own].astype(np.float32),
                pelvis_rotations=poses.pelvis_rotations[own].astype(np.float32),
                rotations=rotations[own],
                contacts=achieved_contacts(layout, planting.feet, index, times=frames.stamps[own]),
                results=results[index],
            )
        )
    return motions
