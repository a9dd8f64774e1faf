"""Examples: steps of a clip library on the character, resampled to common phases (model/examples.py)."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from usdfoot.analysis.character import CharacterMotion, Stands, foot_stands, on_character
from usdfoot.analysis.contact_options import ContactOptions
from usdfoot.analysis.mirror import mirror_map
from usdfoot.analysis.step_table import ROLES, StepTable, tabulate
from usdfoot.analysis.steps import StepLimits, cut_steps
from usdfoot.analysis.timing import EARTH_GRAVITY
from usdfoot.analysis.world import WorldClip, world_clips
from usdfoot.errors import ClipError
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.examples import Examples, event_knots
from usdfoot.model.report import Problem

__all__ = ["build_examples", "times_of_phases"]

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
    worlds: dict[int, WorldClip] = {}
    faults: dict[int, list[str]] = {}
    problems: dict[int, Problem] = {}
    for index, world in enumerate(world_clips(library.clips, library.skeleton, library.biped, options=options)):
        if isinstance(world, ClipError):
            problems[index] = Problem(severity="error", where=library.clips[index].name, message=str(world))
        else:
            worlds[index] = world
    steps = {}
    for index, world in worlds.items():
        steps[index], reasons = cut_steps(world, limits=limits)
        faults[index] = list(reasons)
    table = tabulate(worlds, steps)
    examples = _no_examples(library, samples)
    if len(table):
        motion = on_character(library, [world for index, world in worlds.items() if steps[index]])
        examples, dropped = _examples_of(motion, table, samples, limits)
        for index, reason in dropped:
            faults[index].append(reason)
        used = np.unique(examples.clip_indices)
        reflected = np.isin(table.clips, [index for index in used if mirror and library.clips[index].mirror])
        if reflected.any():
            motion = replace(motion, mirror=mirror_map(library.skeleton, library.biped))
            images, _ = _examples_of(motion, table.mirrored(reflected), samples, limits)
            examples = _in_order(examples, replace(images, mirrored=np.ones(len(images), dtype=bool)))
    standing = [index for index, world in worlds.items() if world.contacts.only_stand]
    return examples, _problems_of(library, {*examples.clip_indices.tolist(), *standing}, faults, problems)


def _problems_of(
    library: ClipLibrary, of_use: Collection[int], faults: Mapping[int, Sequence[str]], problems: Mapping[int, Problem]
) -> list[Problem]:
    """A warning for each fault of each clip, by clip, with those that cannot be used at all.

    Clips of use have a step, or stand all the time as people do who wait.
    """
    listed = []
    for index, clip in enumerate(library.clips):
        if index in problems:
            listed.append(problems[index])
            continue
        unused = () if index in of_use else (f"no usable step in its range: {REMEDY}",)
        listed += [
            Problem(severity="warning", where=clip.name, message=f"{clip.name}: {fault}")
            for fault in (*faults[index], *unused)
        ]
    return listed


def _examples_of(
    motion: CharacterMotion, table: StepTable, samples: int, limits: StepLimits
) -> tuple[Examples, list[tuple[int, str]]]:
    """Examples of the steps of a table, and clips and reasons of the steps left out."""
    stands = _stands_of(motion, table)
    places = {role: stand.positions for role, stand in stands.items()}
    yaws = {role: stand.yaws for role, stand in stands.items()}
    slides = stands["support"].slides
    leg = motion.library.biped.maximal_leg_length
    distances = np.linalg.norm((places["landing"] - places["support"])[:, [0, 2]], axis=1)
    spanned = distances * (1.0 - _flown_shares(table, leg=leg, rise=limits.rise))
    too_far, sliding = spanned > limits.reach * leg, slides > limits.slide * leg / 0.8
    reasons = {i: f"the support foot slides {100.0 * slides[i]:.1f} cm" for i in np.flatnonzero(sliding)}
    flown = np.where(spanned < distances, " without its flight", "")
    reasons |= {
        i: f"it lands {distances[i]:.2f} m away, {spanned[i] / leg:.1f} times the legs' length{flown[i]}, "
        f"{limits.reach:g} at most are steps"
        for i in np.flatnonzero(too_far & ~sliding)
    }
    dropped = [
        (int(table.clips[i]), f"step at {table.starts[i]:.2f} s dropped: {reason}") for i, reason in reasons.items()
    ]
    examples = _sampled(motion, table, places, yaws, samples)
    return _selected(examples, ~(too_far | sliding)), dropped


def _flown_shares(table: StepTable, *, leg: float, rise: float) -> FloatArray:
    """Part of each step that the body flies, shape (E,); none where it would rise by more than `rise` legs [m]."""
    flights = np.maximum(table.ends - table.support_liftoffs, 0.0)
    longest = 2.0 * np.sqrt(2.0 * rise * leg / EARTH_GRAVITY)
    return np.where(flights <= longest, flights / (table.ends - table.starts), 0.0)


def _stands_of(motion: CharacterMotion, table: StepTable) -> dict[str, Stands]:
    """Where the contacts stand that E steps join, E of each role."""
    rows = np.concatenate([table.contacts_of(role) for role in ROLES])
    contacts, where, places = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    flats, liftoffs = (times.T.ravel()[where] for times in (table.flats, table.liftoffs))
    found = foot_stands(motion, contacts[:, 0], flats=flats, liftoffs=liftoffs, sides=contacts[:, 1])
    return {
        role: Stands(positions=found.positions[own], yaws=found.yaws[own], slides=found.slides[own])
        for role, own in zip(ROLES, places.reshape(len(ROLES), -1), strict=True)
    }


def _sampled(
    motion: CharacterMotion,
    table: StepTable,
    places: dict[str, FloatArray],
    yaws: dict[str, FloatArray],
    samples: int,
) -> Examples:
    """Examples of all steps of a table, given the places and yaws of the contacts they join."""
    count, pelvis = len(table), motion.library.biped.pelvis
    durations = table.ends - table.starts
    swing_liftoffs, support_liftoffs = table.swing_liftoffs - table.starts, table.support_liftoffs - table.starts
    headings = planar.circular_mean(np.stack([yaws["support"], yaws["departure"]], axis=1))
    next_headings = planar.circular_mean(np.stack([yaws["support"], yaws["landing"]], axis=1))

    times = table.starts[:, None] + times_of_phases(
        durations, swing_liftoffs=swing_liftoffs, support_liftoffs=support_liftoffs, samples=samples
    )
    rotations, pelvis_world = motion.pose(np.repeat(table.runs, samples), times.ravel())
    balls = motion.feet(rotations[:, motion.legs], pelvis_world)[1].reshape(count, samples, 2, 3)
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
        clip_indices=table.clips,
        mirrored=np.zeros(count, dtype=bool),
        styles=tuple(motion.library.clips[clip].style for clip in table.clips),
        swing_sides=table.swing_sides,
        start_times=table.starts,
        durations=durations,
        flat_times=table.support_flats - table.starts,
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
        support_balls=in_support_frame(balls[rows, :, 1 - table.swing_sides]),
        swing_balls=in_support_frame(balls[rows, :, table.swing_sides]),
    )


def times_of_phases(
    durations: FloatArray, swing_liftoffs: FloatArray, support_liftoffs: FloatArray, *, samples: int
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


def _in_order(own: Examples, images: Examples) -> Examples:
    """Examples and mirror images by clip, each clip's own first."""
    clips = np.concatenate([own.clip_indices, images.clip_indices])
    order = np.lexsort([np.arange(len(clips)) >= len(own), clips])
    changes: dict[str, Any] = {}
    for field in fields(Examples):
        values = [getattr(part, field.name) for part in (own, images)]
        if isinstance(values[0], np.ndarray):
            changes[field.name] = np.concatenate(values)[order]
    styles = (*own.styles, *images.styles)
    return replace(own, styles=tuple(styles[index] for index in order), **changes)


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
