"""The kinematic walker: footprints in, joint rotations and pelvis path out.

Angles of the upper body follow the legs as measured in people: the pelvis turns forward with the swing leg (4 to
8 degrees), lists towards it (4 to 5), leans with speed; the chest turns against the pelvis; arms swing against the
legs (Murray, Sepic and Barnard 1967, Patterns of sagittal rotation of the upper limbs in walking); the head stays
level and looks where the path turns (Hirasaki, Moore, Raphan and Cohen 1999).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stagecraft.foot_path import FootPath, feet_of, trace_foot
from stagecraft.footprints import Footprint
from stagecraft.leg_ik import solve_leg
from stagecraft.pelvis_path import (
    RATE,
    allowed_height,
    exchanges,
    height_curve,
    height_knots,
    lower,
    planar_path,
    smooth,
    standing_height,
)
from stagecraft.rig import FootShape, Rig
from stagecraft.rotation import FloatArray, about_y, apply
from stagecraft.upper_body import Signals, arm_rotations, pelvis_rotation, torso_rotations

WALK_REACH, RUN_REACH = 0.9975, 0.988
"""Longest hip to ankle distance over the length of the straight leg."""


@dataclass(frozen=True, kw_only=True)
class Motion:
    """The walker over time."""

    times: FloatArray
    """When [s], shape (T,)."""
    pelvis: FloatArray
    """Pelvis joint in the world [m], shape (T, 3)."""
    rotations: FloatArray
    """Joints to world, in the order of the rig, shape (T, J, 3, 3)."""


def walk(prints: Sequence[Footprint], rig: Rig, foot: FootShape, *, breath: float = 0.0) -> Motion:
    """Motion of the person over the interval that `prints` cover, at `RATE`.

    Args:
        prints: at least three footprints, feet alternating.
        rig: the skeleton.
        foot: its feet.
        breath: amplitude of breathing and swaying in place, 0..1, one wave in 4 s.
    """
    start, end = covered(prints)
    times = start + np.arange(int(np.ceil((end - start) * RATE)) + 1) / RATE
    left, right = feet_of(prints)
    feet = [trace_foot(left, right, times, foot), trace_foot(right, left, times, foot)]
    ankles = [
        path.ball - apply(path.rotation, rig.bone(f"{side}Toe"))
        for path, side in zip(feet, ("Left", "Right"), strict=True)
    ]
    planar, heading = planar_path(prints, times)
    planar = planar + breath * np.stack([0.007 * np.sin(np.pi * times / 2.0), 0.003 * np.sin(np.pi * times)], axis=1)
    running = _running(prints, times)
    signals = Signals.measure(planar, heading, feet=feet, ankles=ankles, running=running, breath=breath, times=times)
    pelvis_turn = pelvis_rotation(signals)
    height = _height(prints, times, rig, foot, planar=planar, turn=pelvis_turn, ankles=ankles, running=running)
    pelvis = np.stack([planar[:, 0], height, planar[:, 1]], axis=1)
    rotations = _pose(rig, pelvis, pelvis_turn, signals, feet=feet, ankles=ankles)
    return Motion(times=times, pelvis=pelvis, rotations=rotations)


def covered(prints: Sequence[Footprint]) -> tuple[float, float]:
    """The interval in which both feet and the pelvis know their way [s]: first to last change of feet, or standing."""
    changes = exchanges(prints)
    stands = prints[-1].liftoff == prints[-2].liftoff
    return changes[0].times()[0], prints[-1].liftoff if stands else changes[-1].times()[-1]


def _running(prints: Sequence[Footprint], times: FloatArray) -> FloatArray:
    """1 where the steps have flight, 0 where they do not, gradual in between, shape (T,)."""
    changes = exchanges(prints)
    return smooth(
        np.interp(times, [change.middle for change in changes], [1.0 if change.flight else 0.0 for change in changes]),
        0.15,
    )


def _height(
    prints: Sequence[Footprint],
    times: FloatArray,
    rig: Rig,
    foot: FootShape,
    *,
    planar: FloatArray,
    turn: FloatArray,
    ankles: list[FloatArray],
    running: FloatArray,
) -> FloatArray:
    """Height of the pelvis [m], as high as the gait wants and the legs reach, shape (T,)."""
    length = sum(float(np.linalg.norm(rig.bone(name))) for name in ("LeftLeg", "LeftFoot"))
    longest = length * (WALK_REACH + (RUN_REACH - WALK_REACH) * running)
    limits = [
        allowed_height(ankle, apply(turn, rig.bone(f"{side}UpLeg")), planar, longest)
        for ankle, side in zip(ankles, ("Left", "Right"), strict=True)
    ]
    limit = np.minimum(*limits)
    knots = height_knots(prints, standing_height(foot, rig.place("Hips")[1]))
    for _ in range(12):
        excess = height_curve(knots, times) - limit
        if excess.max() <= 0.0:
            break
        knots = lower(knots, times, np.maximum(excess, 0.0))
    return np.minimum(height_curve(knots, times), limit + 5e-4)


def _pose(
    rig: Rig,
    pelvis: FloatArray,
    pelvis_turn: FloatArray,
    signals: Signals,
    *,
    feet: list[FootPath],
    ankles: list[FloatArray],
) -> FloatArray:
    """World rotations of all joints, shape (T, J, 3, 3)."""
    found = {"Hips": pelvis_turn, **torso_rotations(signals, pelvis_turn)}
    for number, side in enumerate(("Left", "Right")):
        found |= arm_rotations(signals, found["Chest"], side)
        hip = pelvis + apply(pelvis_turn, rig.bone(f"{side}UpLeg"))
        outward = 0.06 if side == "Left" else -0.06
        toward = pelvis_turn @ [outward, 0.0, 1.0] + about_y(feet[number].yaw) @ [0.0, 0.0, 0.8]
        bones = (rig.bone(f"{side}Leg"), rig.bone(f"{side}Foot"))
        found[f"{side}UpLeg"], found[f"{side}Leg"] = solve_leg(hip, ankles[number], toward, bones)
        found[f"{side}Foot"], found[f"{side}Toe"] = feet[number].rotation, feet[number].toe_rotation
    return np.stack([found[name] for name in rig.names], axis=1)


def local_rotations(rig: Rig, world: FloatArray) -> FloatArray:
    """Joint to parent, shape (T, J, 3, 3), of joint to world rotations."""
    parents = [max(parent, 0) for parent in rig.parents]
    local = np.swapaxes(world[:, parents], -1, -2) @ world
    local[:, 0] = world[:, 0]
    return local


def joint_positions(rig: Rig, pelvis: FloatArray, world: FloatArray) -> FloatArray:
    """Joints in the world [m], shape (T, J, 3)."""
    places = np.empty((*world.shape[:2], 3))
    places[:, 0] = pelvis
    for joint, name in enumerate(rig.names[1:], start=1):
        parent = rig.parents[joint]
        places[:, joint] = places[:, parent] + world[:, parent] @ rig.bone(name)
    return places
