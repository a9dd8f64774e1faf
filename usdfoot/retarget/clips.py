"""Clips of one rig on the joints of another, feet kept on the ground."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from usdfoot.analysis.world import WorldClip, listed_contacts, world_clips
from usdfoot.errors import ClipError
from usdfoot.maths import planar, quaternion
from usdfoot.maths.two_bone import bend_two_bones
from usdfoot.maths.types import FloatArray
from usdfoot.model.clip import Clip
from usdfoot.model.contacts import Contacts
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.retarget.evidence import find_evidence
from usdfoot.retarget.feet import ball_goals, hip_goals, largest_slide, measure_sizes
from usdfoot.retarget.frames import build_frames
from usdfoot.retarget.legs import legs_of, lowering
from usdfoot.retarget.poses import world_poses
from usdfoot.retarget.rig import Rig, same_legs
from usdfoot.retarget.transfer import pose_target, transfer_rotations

__all__ = ["RetargetedClip", "retarget_clips"]

SIDES = (0, 1)
HINGE = np.array([1.0, 0.0, 0.0])
UP = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, kw_only=True)
class RetargetedClip:
    """A clip on the target's joints."""

    clip: Clip
    """Canonical, in the target's proportions; name and attributes are the source's."""
    contacts: Contacts
    """When the feet stand, as in the source; positions are those in the source's world."""
    slide: float
    """Largest distance between two positions of a planted ball, at most [m]; 0 without contacts."""
    lowered: float
    """Most that the pelvis is lowered so that the legs reach [m]."""


@dataclass(frozen=True, kw_only=True)
class _WorldResult:
    """One world clip on the target, T samples."""

    rotations: FloatArray
    """Joint-local, but for the pelvis, shape (T, J, 4)."""
    pelvis: FloatArray
    """Pelvis joint in the world [m], shape (T, 3)."""
    pelvis_turns: FloatArray
    """Its rotation there, shape (T, 4)."""
    scale: float
    """Target over source."""
    slide: float
    lowered: float


def retarget_clips(
    source: Rig, clips: Sequence[Clip], target: Rig, *, plant: bool | None = None
) -> list[RetargetedClip | ClipError]:
    """Clips of the source on the target's joints.

    Limbs keep their directions in the world and bend about their own hinges, trunk and neck bend alike. The path of the
    hips is scaled by the length of the legs, and so are the places where the feet stand. The legs then reach for them.

    Args:
        source: Rig of the clips.
        clips: On the source's joints.
        target: Rig of the character.
        plant: Hold the balls where they stand; None = unless the legs of both rigs have one shape, which keep the
            source's contacts as they are.

    Returns:
        One for each clip, or the error of one whose authored events are out of order.
    """
    worlds = [
        world if isinstance(world, ClipError) else _with_own_samples(world, clip)
        for world, clip in zip(world_clips(clips, source.skeleton, source.biped), clips, strict=True)
    ]
    usable = [world for world in worlds if not isinstance(world, ClipError)]
    planted = not same_legs(source, target) if plant is None else plant
    done = iter(_retarget(source, usable, target, plant=planted) if usable else [])
    return [
        world if isinstance(world, ClipError) else _as_sampled(next(done), world, clip, source, target)
        for world, clip in zip(worlds, clips, strict=True)
    ]


def _retarget(source: Rig, worlds: Sequence[WorldClip], target: Rig, *, plant: bool) -> list[_WorldResult]:
    """World clips on the target."""
    poses = world_poses(source, worlds)
    frames = build_frames(source, target, find_evidence(source, poses))
    sizes = measure_sizes(source, target, frames=frames, poses=poses)
    wanted = transfer_rotations(source, target, frames, turns=poses.turns)
    centres = hip_goals(source, poses, sizes)
    _, around, _ = pose_target(target, wanted, np.zeros_like(centres))
    pelvis = centres - around[:, list(target.biped.hips)].mean(axis=1)
    legs = legs_of(target, around + pelvis[:, None])
    feet, thighs = (
        poses.frames_of(pair, [frames[0][joint] for joint in pair]) for pair in (source.biped.ankles, source.biped.hips)
    )
    balls = ball_goals(source, poses, feet=feet, sizes=sizes, plant=plant)
    ankles = balls - quaternion.rotate(feet, np.stack([foot.ball for foot in sizes.feet]))
    drops = lowering(poses, legs_of(source, poses.places), legs, ankles=ankles)[:, None] * UP
    pelvis = pelvis - drops
    hinges = quaternion.rotate(thighs, HINGE)
    bends = bend_two_bones(legs.thighs, legs.shins, hinges, reach=ankles - legs.hips + drops[:, None])
    for pair, bend in zip((target.biped.hips, target.biped.knees), bends, strict=True):
        wanted |= {joint: quaternion.compose(bend[:, side], wanted[joint]) for side, joint in enumerate(pair)}
    rotations, places, turns = pose_target(target, wanted, pelvis)
    results = []
    for world, own, scale in zip(worlds, poses.samples, sizes.scales, strict=True):
        reached = places[own][:, list(target.biped.balls)]
        slides = [largest_slide(world.clip.times, reached[:, side], world.contacts[side]) for side in SIDES]
        results.append(
            _WorldResult(
                rotations=rotations[own],
                pelvis=pelvis[own],
                pelvis_turns=turns[own, target.biped.pelvis],
                scale=float(scale),
                slide=max(slides),
                lowered=float(drops[own, 1].max()),
            )
        )
    return results


def _own_samples(world: WorldClip, clip: Clip) -> slice:
    """The clip's own samples in its world clip, which has a loop three times."""
    first = round((clip.start_time - world.clip.start_time) * clip.rate)
    return slice(first, first + len(clip.rotations))


def _with_own_samples(world: WorldClip, clip: Clip) -> WorldClip:
    """The world clip with the last sample of a loop as it is, not as the loop closes best."""
    if world.root_motion.in_place:
        return world
    own = _own_samples(world, clip)
    translations, rotations = world.clip.translations.copy(), world.clip.rotations.copy()
    translations[own], rotations[own] = clip.translations, clip.rotations
    return replace(world, clip=replace(world.clip, translations=translations, rotations=rotations))


def _as_sampled(result: _WorldResult, world: WorldClip, clip: Clip, source: Rig, target: Rig) -> RetargetedClip:
    """The samples that the clip has, in place again if it runs in place."""
    own = _own_samples(world, clip)
    pelvis, turns = result.pelvis[own], result.pelvis_turns[own]
    if world.root_motion.in_place:
        root = int(np.flatnonzero(source.skeleton.parents < 0)[0])
        travelled = world.clip.rotations[own, root]
        relative = quaternion.compose(travelled, quaternion.inverse(clip.rotations[:, root]))
        yaws = 2.0 * np.arctan2(relative[:, 1], relative[:, 3])
        shifts = world.clip.translations[own, root][:, [0, 2]]
        shifts = shifts - planar.rotate(yaws, clip.translations[:, root][:, [0, 2]])
        back = quaternion.yaw_quaternion(-yaws)
        pelvis = quaternion.rotate(back, pelvis - result.scale * np.insert(shifts, 1, 0.0, axis=1))
        turns = quaternion.compose(back, turns)
    rotations = result.rotations[own].copy()
    translations = np.repeat(target.skeleton.rest_translations[None], len(rotations), axis=0)
    joint = target.biped.pelvis
    translations[:, joint], rotations[:, joint] = _below_parent(target, pelvis, turns)
    return RetargetedClip(
        clip=replace(clip, translations=translations, rotations=quaternion.continuous(rotations)),
        contacts=listed_contacts(world),
        slide=result.slide,
        lowered=result.lowered,
    )


def _below_parent(rig: Rig, pelvis: FloatArray, turns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Pelvis in the world as it stands below its resting parent: translations [m] (T, 3) and rotations (T, 4)."""
    parent = int(rig.skeleton.parents[rig.biped.pelvis])
    if parent < 0:
        return pelvis, turns
    chain = rig.skeleton
    places, rests = forward_kinematics(chain.parents, chain.rest_translations, chain.rest_rotations)
    back = quaternion.inverse(rests[parent])
    return quaternion.rotate(back, pelvis - places[parent]), quaternion.compose(back, turns)
