"""World clips: clips made to travel and loops repeated, with the contacts of their feet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from usdfoot.analysis.authored import with_authored_events
from usdfoot.analysis.contact_options import ContactOptions
from usdfoot.analysis.contacts import contacts_of, select_contacts
from usdfoot.analysis.cycle import detect_periods, repeated
from usdfoot.analysis.motion import clip_leg_lengths, foot_motions, moved, moved_motion, rest_leg_length, with_heels
from usdfoot.analysis.root import RootMotion, detect_root_motions, restored_path
from usdfoot.errors import ClipError
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip
from usdfoot.model.contacts import Contacts, FootContacts
from usdfoot.model.skeleton import Skeleton

__all__ = ["WorldClip", "listed_contacts", "world_clip", "world_clips"]


@dataclass(frozen=True, kw_only=True)
class WorldClip:
    """A clip as it moves through the world."""

    clip: Clip
    """Samples that travel; a loop is there three times, its own cycle in the middle."""
    contacts: Contacts
    """Contacts of all samples, authored events put in."""
    period: float | None
    """Duration of a cycle [s]; None if the clip is no loop."""
    start: float
    """First instant of the original clip [s]."""
    end: float
    """Last instant of the original clip, of a loop the end of its cycle [s]."""
    root_motion: RootMotion
    """Travel that was given back."""
    leg_length: float
    """Hip to ankle with the knee straight, in the clip's own proportions [m]."""
    pelvis_positions: FloatArray
    """Pelvis joint in the world at the samples [m], shape (T, 3)."""
    pelvis_rotations: FloatArray
    """The same, xyzw, shape (T, 4)."""


def listed_contacts(world: WorldClip) -> Contacts:
    """Contacts of the original clip (design.md sections 2 and 5).

    Of a loop every contact that begins in its own cycle is listed once, and its liftoff may come after the end; of who
    only stands the one there is.
    """
    if world.period is None:
        return world.contacts
    left, right = (
        foot if foot.only_stands else _begun_within(foot, world.start, world.end)
        for foot in (world.contacts.left, world.contacts.right)
    )
    return Contacts(left=left, right=right)


def world_clip(clip: Clip, skeleton: Skeleton, biped: Biped) -> WorldClip:
    """The world clip of one clip alone.

    Raises:
        ClipError: If authored events are out of order.
    """
    (world,) = world_clips([clip], skeleton, biped)
    if isinstance(world, ClipError):
        raise world
    return world


def world_clips(
    clips: Sequence[Clip], skeleton: Skeleton, biped: Biped, *, options: ContactOptions | None = None
) -> list[WorldClip | ClipError]:
    """World clips of many clips of one skeleton; the error of those whose authored events are out of order.

    Args:
        clips: Whose own translations give the proportions.
        skeleton: Of all of them.
        biped: Its leg joints.
        options: Thresholds of contact detection.
    """
    if not clips:
        return []
    options = options or ContactOptions()
    leg_lengths = clip_leg_lengths(clips, skeleton, biped)
    periods = detect_periods(clips, skeleton, biped)
    travelling = repeated(clips, skeleton, biped, periods=periods)
    motions = foot_motions(travelling, skeleton, biped, leg_lengths=leg_lengths)
    heights = leg_lengths[:, None] / rest_leg_length(skeleton, biped) * biped.ball_heights  # (C, 2)
    root_motions = detect_root_motions(motions, [clip.root_motion for clip in clips], biped)
    for index, root_motion in enumerate(root_motions):
        if root_motion.in_place:
            clip, motion = travelling[index], motions[index]
            positions, yaws = restored_path(
                clip, biped, motion, root_motion=root_motion, origin_time=clips[index].start_time
            )
            motion = moved_motion(motion, positions, yaws)
            travelling[index] = moved(clip, skeleton, positions=positions, yaws=yaws)
            motions[index] = with_heels(motion, heights[index]) if root_motion.yaw_rate else motion
    detected = contacts_of(motions, ball_heights=heights, leg_lengths=leg_lengths, options=options)
    worlds: list[WorldClip | ClipError] = []
    for index, (clip, motion, period) in enumerate(zip(clips, motions, periods, strict=True)):
        try:
            contacts = with_authored_events(
                detected[index], clip, motion, period=period, ball_heights=heights[index], options=options
            )
        except ClipError as error:
            worlds.append(error)
            continue
        worlds.append(
            WorldClip(
                clip=travelling[index],
                contacts=contacts,
                period=period,
                start=clip.start_time,
                end=float(clip.times[-1]) if period is None else clip.start_time + period,
                root_motion=root_motions[index],
                leg_length=float(leg_lengths[index]),
                pelvis_positions=motion.pelvis,
                pelvis_rotations=motion.pelvis_rotations,
            )
        )
    return worlds


def _begun_within(foot: FootContacts, start: float, end: float) -> FootContacts:
    """Contacts whose strike lies in start <= strike < end."""
    keep = (foot.strike_times >= start - 1e-9) & (foot.strike_times < end - 1e-9)
    return select_contacts(foot, keep)
