"""Examples: steps of a clip library on the character, resampled to common phases (model/examples.py)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from usdfoot.analysis.contacts import ContactOptions
from usdfoot.analysis.mirror import MirrorMap, mirror_contacts, mirror_map, mirrored_clip
from usdfoot.analysis.motion import partial_kinematics
from usdfoot.analysis.steps import Step, StepLimits, cut_steps
from usdfoot.analysis.world import WorldClip, world_clip
from usdfoot.errors import ClipError
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.contacts import Contacts
from usdfoot.model.examples import Examples, event_knots
from usdfoot.model.report import Problem
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = ["build_examples"]

CONTACT_SAMPLES = 33
"""Samples of a contact over which the planted ball is averaged."""


@dataclass(frozen=True, kw_only=True)
class _CharacterMotion:
    """A world clip on the character's skeleton: its rest translations, the pelvis path scaled by leg length."""

    rotations: CubicSpline
    """Of time: joint-local quaternions, the pelvis's in the world, shape (J * 4,)."""
    pelvis: CubicSpline
    """Of time: pelvis joint in the world [m], shape (3,)."""
    first: float
    last: float
    """First and last time [s]."""


@dataclass(frozen=True, kw_only=True)
class _Stand:
    """One contact on the character."""

    position: FloatArray
    """Ground under the planted ball [m], shape (3,)."""
    yaw: float
    """Direction from ankle to ball [rad]."""
    slide: float
    """Largest drift of the ball over the middle of the contact [m]."""


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
        Examples in order of clips and time, each clip's mirror images after its own, and a Problem for each step or clip
        that was not used.
    """
    limits = limits or StepLimits()
    mirror_images = mirror_map(library.skeleton, library.biped)
    rows: list[dict[str, object]] = []
    problems: list[Problem] = []
    for index, clip in enumerate(library.clips):
        try:
            world = world_clip(clip, library.skeleton, library.biped, options=options)
        except ClipError as error:
            problems.append(Problem(severity="error", where=clip.name, message=str(error)))
            continue
        steps, reasons = cut_steps(world, limits=limits)
        found, faults = _clip_examples(library, world, steps, samples, limits, index, mirrored=False)
        rows += found
        if mirror and clip.mirror:
            rows += _clip_examples(
                library, *_mirror_world(world, steps, mirror_images), samples, limits, index, mirrored=True
            )[0]
        for reason in [*reasons, *faults]:
            problems.append(Problem(severity="warning", where=clip.name, message=f"{clip.name}: {reason}"))
        if not found:
            problems.append(
                Problem(
                    severity="warning",
                    where=clip.name,
                    message=f"{clip.name}: no usable step in its range. Author usdfoot:clip:start and :end, or its events",
                )
            )
    return _stacked(library, rows, samples), problems


def _mirror_world(
    world: WorldClip, steps: tuple[Step, ...], mirror: MirrorMap
) -> tuple[WorldClip, tuple[Step, ...]]:
    """Mirror image of a world clip and its steps."""
    image = replace(world, clip=mirrored_clip(world.clip, mirror), contacts=mirror_contacts(world.contacts))
    return image, tuple(replace(step, swing_side=1 - step.swing_side) for step in steps)


def _clip_examples(
    library: ClipLibrary,
    world: WorldClip,
    steps: tuple[Step, ...],
    samples: int,
    limits: StepLimits,
    index: int,
    *,
    mirrored: bool,
) -> tuple[list[dict[str, object]], list[str]]:
    """Examples of one clip as rows of fields, and reasons for the steps left out."""
    rows: list[dict[str, object]] = []
    faults: list[str] = []
    if not steps:
        return rows, faults
    motion = _on_character(library, world)
    scale = library.biped.maximal_leg_length / 0.8
    for step in steps:
        support, swing = 1 - step.swing_side, step.swing_side
        stand = _stand(library, motion, world.contacts, support, step.support)
        departure = _stand(library, motion, world.contacts, swing, step.departure)
        landing = _stand(library, motion, world.contacts, swing, step.landing)
        distance = float(np.linalg.norm((landing.position - stand.position)[[0, 2]]))
        if stand.slide > limits.slide * scale:
            faults.append(f"step at {step.start:.2f} s dropped: the support foot slides {100 * stand.slide:.1f} cm")
            continue
        if distance > limits.reach * library.biped.maximal_leg_length:
            faults.append(f"step at {step.start:.2f} s dropped: it lands {distance:.2f} m away")
            continue
        row = _example(library, motion, step, stand, departure, landing, samples)
        rows.append({**row, "clip_indices": index, "mirrored": mirrored, "styles": world.clip.style})
    return rows, faults


def _on_character(library: ClipLibrary, world: WorldClip) -> _CharacterMotion:
    """Splines of a world clip on the character, everything above the pelvis folded into the pelvis."""
    skeleton, pelvis = library.skeleton, library.biped.pelvis
    positions, world_rotations = partial_kinematics(skeleton, world.clip, np.array([pelvis]))
    rotations = world.clip.rotations.copy()
    for joint in skeleton.chain(_root_above(skeleton, pelvis), pelvis)[:-1]:
        rotations[:, joint] = skeleton.rest_rotations[joint]
    rotations[:, pelvis] = quaternion.continuous(world_rotations[:, 0])
    ratio = library.biped.maximal_leg_length / world.leg_length
    times = world.clip.times
    return _CharacterMotion(
        rotations=CubicSpline(times, rotations.reshape(len(times), -1)),
        pelvis=CubicSpline(times, ratio * positions[:, 0]),
        first=float(times[0]),
        last=float(times[-1]),
    )


def _root_above(skeleton: Skeleton, joint: int) -> int:
    """The joint without a parent that `joint` hangs from."""
    while skeleton.parents[joint] >= 0:
        joint = int(skeleton.parents[joint])
    return joint


def _pose(motion: _CharacterMotion, times: FloatArray, joints: int) -> tuple[FloatArray, FloatArray]:
    """Joint-local rotations (N, J, 4), the pelvis's in the world, and pelvis positions (N, 3) at times (N,)."""
    rotations = quaternion.normalised(motion.rotations(times).reshape(len(times), joints, 4))
    return rotations, motion.pelvis(times)


def _legs(
    library: ClipLibrary, rotations: FloatArray, pelvis: FloatArray, side: int
) -> tuple[FloatArray, FloatArray]:
    """Ankle and ball joints [m] (N, 3) each of one leg, by forward kinematics from the pelvis."""
    skeleton, biped = library.skeleton, library.biped
    chain = np.array(skeleton.chain(biped.pelvis, biped.balls[side]))
    translations = np.repeat(skeleton.rest_translations[None, chain], len(pelvis), axis=0)
    translations[:, 0] = pelvis
    positions, _ = forward_kinematics(np.arange(-1, len(chain) - 1), translations, rotations[:, chain])
    return positions[:, list(chain).index(biped.ankles[side])], positions[:, -1]


def _stand(library: ClipLibrary, motion: _CharacterMotion, contacts: Contacts, side: int, index: int) -> _Stand:
    """Where the character's foot stands in a contact, mean over the planted interval."""
    foot = contacts[side]
    start = max(float(foot.flat_times[index]), motion.first)
    end = min(float(foot.liftoff_times[index]), motion.last)
    times = np.linspace(min(start, end), end, CONTACT_SAMPLES)
    rotations, pelvis = _pose(motion, times, len(library.skeleton.joints))
    ankles, balls = _legs(library, rotations, pelvis, side)
    middle = slice(CONTACT_SAMPLES // 10, -(CONTACT_SAMPLES // 10))
    ball = balls.mean(axis=0)
    forward = (balls - ankles)[:, [0, 2]]
    return _Stand(
        position=ball - np.array([0.0, library.biped.ball_heights[side], 0.0]),
        yaw=float(planar.circular_mean(planar.yaw_of(forward))),
        slide=float(np.linalg.norm(balls[middle] - ball, axis=-1).max()),
    )


def _example(
    library: ClipLibrary,
    motion: _CharacterMotion,
    step: Step,
    stand: _Stand,
    departure: _Stand,
    landing: _Stand,
    samples: int,
) -> dict[str, object]:
    """Fields of one example."""
    joints = len(library.skeleton.joints)
    heading = float(planar.circular_mean(np.array([stand.yaw, departure.yaw])))
    next_heading = float(planar.circular_mean(np.array([stand.yaw, landing.yaw])))
    events = np.array([step.end, step.swing_liftoff, step.support_liftoff]) - step.start
    knot_times, knot_phases = event_knots(*(events[i : i + 1] for i in range(3)))
    phases = np.linspace(0.0, 1.0, samples)
    times = step.start + np.interp(phases, knot_phases[0], knot_times[0])
    rotations, pelvis = _pose(motion, times, joints)
    support_ball = _legs(library, rotations, pelvis, 1 - step.swing_side)[1]
    swing_ball = _legs(library, rotations, pelvis, step.swing_side)[1]

    def planar_offset(place: FloatArray) -> FloatArray:
        return planar.rotate(np.array(-heading), (place - stand.position)[..., [0, 2]])

    line_start = 0.5 * (departure.position[1] + stand.position[1])
    line_end = 0.5 * (stand.position[1] + landing.position[1])
    line = line_start + phases * (line_end - line_start)

    def in_support_frame(points: FloatArray) -> FloatArray:
        ground = planar_offset(points)
        return np.stack([ground[:, 0], points[:, 1] - line, ground[:, 1]], axis=1)

    turned = quaternion.compose(quaternion.yaw_quaternion(np.array(-heading)), rotations[:, library.biped.pelvis])
    rotations[:, library.biped.pelvis] = turned
    return {
        "swing_sides": step.swing_side,
        "start_times": step.start,
        "durations": step.end - step.start,
        "flat_times": step.flat - step.start,
        "swing_liftoffs": step.swing_liftoff - step.start,
        "support_liftoffs": step.support_liftoff - step.start,
        "landings": planar_offset(landing.position),
        "landing_heights": landing.position[1] - stand.position[1],
        "landing_yaws": planar.wrap_angle(np.array(landing.yaw - heading)),
        "departures": planar_offset(departure.position),
        "support_yaws": planar.wrap_angle(np.array(stand.yaw - heading)),
        "departure_yaws": planar.wrap_angle(np.array(departure.yaw - heading)),
        "turns": planar.wrap_angle(np.array(next_heading - heading)),
        "rotations": quaternion.continuous(rotations),
        "pelvis_positions": in_support_frame(pelvis),
        "support_balls": in_support_frame(support_ball),
        "swing_balls": in_support_frame(swing_ball),
    }


def _stacked(library: ClipLibrary, rows: list[dict[str, object]], samples: int) -> Examples:
    """Rows of fields as arrays."""
    joints = len(library.skeleton.joints)

    def stack(name: str, shape: tuple[int, ...] = (), kind: type = float) -> FloatArray:
        return np.array([row[name] for row in rows], dtype=kind).reshape(len(rows), *shape)

    return Examples(
        clip_names=tuple(clip.name for clip in library.clips),
        clip_indices=stack("clip_indices", kind=np.int64),
        mirrored=stack("mirrored", kind=np.bool_),
        styles=tuple(str(row["styles"]) for row in rows),
        swing_sides=stack("swing_sides", kind=np.int64),
        start_times=stack("start_times"),
        durations=stack("durations"),
        flat_times=stack("flat_times"),
        swing_liftoffs=stack("swing_liftoffs"),
        support_liftoffs=stack("support_liftoffs"),
        landings=stack("landings", (2,)),
        landing_heights=stack("landing_heights"),
        landing_yaws=stack("landing_yaws"),
        departures=stack("departures", (2,)),
        support_yaws=stack("support_yaws"),
        departure_yaws=stack("departure_yaws"),
        turns=stack("turns"),
        rotations=stack("rotations", (samples, joints, 4), np.float32),
        pelvis_positions=stack("pelvis_positions", (samples, 3), np.float32),
        support_balls=stack("support_balls", (samples, 3), np.float32),
        swing_balls=stack("swing_balls", (samples, 3), np.float32),
    )
