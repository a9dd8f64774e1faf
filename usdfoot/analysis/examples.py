"""Examples: steps of a clip library on the character, resampled to common phases (model/examples.py)."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from usdfoot.analysis.character import CharacterMotion, Stands, foot_stands, on_character
from usdfoot.analysis.contact_options import ContactOptions
from usdfoot.analysis.mirror import MirrorMap, mirror_contacts, mirror_map
from usdfoot.analysis.steps import Step, StepLimits, cut_steps
from usdfoot.analysis.world import WorldClip, world_clip
from usdfoot.errors import ClipError
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.examples import Examples, event_knots
from usdfoot.model.report import Problem

__all__ = ["build_examples"]

REMEDY = "author usdfoot:clip:start and :end or the strikeTimes and liftoffTimes of both feet"


def build_examples(
    library: ClipLibrary,
    *,
    samples: int = 64,
    mirror: bool = True,
    limits: StepLimits | None = None,
    options: ContactOptions | None = None,
) -> tuple[Examples, list[Problem]]:
    """Examples of all clips of a library on its character, and what could not be used.

    Args:
        library: Skeleton, biped and clips.
        samples: Samples of each example, evenly in phase.
        mirror: Whether to add left/right mirror images, unless a clip asks for none.
        limits: What a usable step is.
        options: Thresholds of contact detection.

    Returns:
        Examples in order of clips and time, each clip's mirror images after its own, and a Problem for each step or
        clip that was not used.
    """
    limits = limits or StepLimits()
    reflection = mirror_map(library.skeleton, library.biped)
    parts = [_no_examples(library, samples)]
    problems: list[Problem] = []
    for index, clip in enumerate(library.clips):
        try:
            world = world_clip(clip, library.skeleton, library.biped, options=options)
        except ClipError as error:
            problems.append(Problem(severity="error", where=clip.name, message=str(error)))
            continue
        steps, faults = cut_steps(world, limits=limits)
        motion = on_character(library, world)
        own, more_faults = _clip_examples(motion, world, steps, samples, limits)
        images = [own]
        if mirror and clip.mirror and len(own):
            images.append(_mirror_examples(motion, world, steps, reflection, samples, limits))
        parts += [replace(image, clip_indices=image.clip_indices + index) for image in images]
        faults = (*faults, *more_faults, *(() if len(own) else (f"no usable step in its range: {REMEDY}",)))
        problems += [Problem(severity="warning", where=clip.name, message=f"{clip.name}: {fault}") for fault in faults]
    return _joined(parts), problems


def _mirror_examples(
    motion: CharacterMotion,
    world: WorldClip,
    steps: tuple[Step, ...],
    reflection: MirrorMap,
    samples: int,
    limits: StepLimits,
) -> Examples:
    """Examples of the mirror image of a clip."""
    image = replace(world, contacts=mirror_contacts(world.contacts))
    swapped = tuple(replace(step, swing_side=1 - step.swing_side) for step in steps)
    examples, _ = _clip_examples(motion.mirrored(reflection), image, swapped, samples, limits)
    return replace(examples, mirrored=np.ones(len(examples), dtype=bool))


def _clip_examples(
    motion: CharacterMotion, world: WorldClip, steps: tuple[Step, ...], samples: int, limits: StepLimits
) -> tuple[Examples, tuple[str, ...]]:
    """Examples of one clip, of index 0, and reasons for the steps left out."""
    library = motion.library
    if not steps:
        return _no_examples(library, samples), ()
    stands = _stands_of(motion, world, steps)
    places = {role: stand.positions for role, stand in stands.items()}
    yaws = {role: stand.yaws for role, stand in stands.items()}
    slides = stands["support"].slides
    leg = library.biped.maximal_leg_length
    distances = np.linalg.norm((places["landing"] - places["support"])[:, [0, 2]], axis=1)
    too_far, sliding = distances > limits.reach * leg, slides > limits.slide * leg / 0.8
    faults = [
        f"step at {steps[i].start:.2f} s dropped: the support foot slides {100.0 * slides[i]:.1f} cm"
        for i in np.flatnonzero(sliding)
    ]
    faults += [
        f"step at {steps[i].start:.2f} s dropped: it lands {distances[i]:.2f} m away"
        for i in np.flatnonzero(too_far & ~sliding)
    ]
    examples = _sampled(motion, world, steps, places, yaws, samples)
    return _selected(examples, ~(too_far | sliding)), tuple(faults)


def _stands_of(motion: CharacterMotion, world: WorldClip, steps: tuple[Step, ...]) -> dict[str, Stands]:
    """Where the contacts stand that E steps join, E of each role."""
    roles = {
        "departure": [(step.swing_side, step.departure) for step in steps],
        "support": [(1 - step.swing_side, step.support) for step in steps],
        "landing": [(step.swing_side, step.landing) for step in steps],
    }
    contacts, places = np.unique([row for rows in roles.values() for row in rows], axis=0, return_inverse=True)
    flats = np.array([world.contacts[side].flat_times[index] for side, index in contacts])
    liftoffs = np.array([world.contacts[side].liftoff_times[index] for side, index in contacts])
    found = foot_stands(motion, flats, liftoffs, contacts[:, 0])
    return {
        role: Stands(positions=found.positions[own], yaws=found.yaws[own], slides=found.slides[own])
        for role, own in zip(roles, places.reshape(len(roles), -1), strict=True)
    }


def _sampled(
    motion: CharacterMotion,
    world: WorldClip,
    steps: tuple[Step, ...],
    places: dict[str, FloatArray],
    yaws: dict[str, FloatArray],
    samples: int,
) -> Examples:
    """Examples of all steps of a clip, given the places and yaws of the contacts they join."""
    count, pelvis = len(steps), motion.library.biped.pelvis
    starts = np.array([step.start for step in steps])
    durations = np.array([step.end for step in steps]) - starts
    swing_liftoffs = np.array([step.swing_liftoff for step in steps]) - starts
    support_liftoffs = np.array([step.support_liftoff for step in steps]) - starts
    swing_sides = np.array([step.swing_side for step in steps])
    headings = planar.circular_mean(np.stack([yaws["support"], yaws["departure"]], axis=1))
    next_headings = planar.circular_mean(np.stack([yaws["support"], yaws["landing"]], axis=1))

    times = starts[:, None] + _times_of_phases(durations, swing_liftoffs, support_liftoffs, samples)
    rotations, pelvis_world = motion.pose(times.ravel())
    balls = motion.feet(rotations, pelvis_world)[1].reshape(count, samples, 2, 3)
    rows = np.arange(count)
    rotations = rotations.reshape(count, samples, -1, 4)
    unturned = quaternion.yaw_quaternion(-headings)[:, None]
    rotations[:, :, pelvis] = quaternion.compose(unturned, rotations[:, :, pelvis])
    lines = _ground_lines(places, samples)

    def on_ground(points: FloatArray) -> FloatArray:
        return planar.rotate(-headings, (points - places["support"])[:, [0, 2]])

    def in_support_frame(points: FloatArray) -> FloatArray:
        ground = planar.rotate(-headings[:, None], (points - places["support"][:, None])[..., [0, 2]])
        return np.stack([ground[..., 0], points[..., 1] - lines, ground[..., 1]], axis=-1).astype(np.float32)

    return Examples(
        clip_names=tuple(clip.name for clip in motion.library.clips),
        clip_indices=np.zeros(count, dtype=np.int64),
        mirrored=np.zeros(count, dtype=bool),
        styles=(world.clip.style,) * count,
        swing_sides=swing_sides,
        start_times=starts,
        durations=durations,
        flat_times=np.array([step.flat for step in steps]) - starts,
        swing_liftoffs=swing_liftoffs,
        support_liftoffs=support_liftoffs,
        landings=on_ground(places["landing"]),
        landing_heights=places["landing"][:, 1] - places["support"][:, 1],
        landing_yaws=planar.wrap_angle(yaws["landing"] - headings),
        departures=on_ground(places["departure"]),
        support_yaws=planar.wrap_angle(yaws["support"] - headings),
        departure_yaws=planar.wrap_angle(yaws["departure"] - headings),
        turns=planar.wrap_angle(next_headings - headings),
        rotations=_continuous(rotations).astype(np.float32),
        pelvis_positions=in_support_frame(pelvis_world.reshape(count, samples, 3)),
        support_balls=in_support_frame(balls[rows, :, 1 - swing_sides]),
        swing_balls=in_support_frame(balls[rows, :, swing_sides]),
    )


def _times_of_phases(
    durations: FloatArray, swing_liftoffs: FloatArray, support_liftoffs: FloatArray, samples: int
) -> FloatArray:
    """Time after the support strike of evenly spaced phases, straight between the events [s], shape (E, S)."""
    knot_times, knot_phases = event_knots(durations, swing_liftoffs, support_liftoffs)
    phases = np.linspace(0.0, 1.0, samples)
    return np.stack([np.interp(phases, *knots) for knots in zip(knot_phases, knot_times, strict=True)])


def _ground_lines(places: dict[str, FloatArray], samples: int) -> FloatArray:
    """Height of the ground line at every phase, from before to after the step [m], shape (E, S)."""
    start = 0.5 * (places["departure"][:, 1] + places["support"][:, 1])
    end = 0.5 * (places["support"][:, 1] + places["landing"][:, 1])
    return start[:, None] + (end - start)[:, None] * np.linspace(0.0, 1.0, samples)


def _continuous(rotations: FloatArray) -> FloatArray:
    """Rotations (E, S, J, 4) that do not change sign along the samples."""
    return np.moveaxis(quaternion.continuous(np.moveaxis(rotations, 1, 0)), 0, 1)


def _selected(examples: Examples, keep: BoolArray) -> Examples:
    """Examples at which `keep` (E,) is True."""
    changes: dict[str, Any] = {}
    for field in fields(Examples):
        values = getattr(examples, field.name)
        if isinstance(values, np.ndarray):
            changes[field.name] = values[keep]
    styles = tuple(style for style, kept in zip(examples.styles, keep, strict=True) if kept)
    return replace(examples, styles=styles, **changes)


def _joined(parts: list[Examples]) -> Examples:
    """Examples one after the other."""
    changes: dict[str, Any] = {}
    for field in fields(Examples):
        values = [getattr(part, field.name) for part in parts]
        if isinstance(values[0], np.ndarray):
            changes[field.name] = np.concatenate(values)
    return replace(parts[0], styles=tuple(style for part in parts for style in part.styles), **changes)


def _no_examples(library: ClipLibrary, samples: int) -> Examples:
    """No examples at all, with arrays of the right shapes."""
    joints = len(library.skeleton.joints)
    none, points = np.zeros(0), np.zeros((0, 2))
    paths = np.zeros((0, samples, 3), dtype=np.float32)
    indices: IntArray = np.zeros(0, dtype=np.int64)
    return Examples(
        clip_names=tuple(clip.name for clip in library.clips),
        clip_indices=indices,
        mirrored=np.zeros(0, dtype=bool),
        styles=(),
        swing_sides=indices,
        start_times=none,
        durations=none,
        flat_times=none,
        swing_liftoffs=none,
        support_liftoffs=none,
        landings=points,
        landing_heights=none,
        landing_yaws=none,
        departures=points,
        support_yaws=none,
        departure_yaws=none,
        turns=none,
        rotations=np.zeros((0, samples, joints, 4), dtype=np.float32),
        pelvis_positions=paths,
        support_balls=paths,
        swing_balls=paths,
    )
