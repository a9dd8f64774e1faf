"""Libraries of the analytic walker, and what its motions do in the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tests.builders import Gait, build_walker
from usdfoot.analysis.figures import sole_offsets
from usdfoot.maths import quaternion
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.motion import Motion
from usdfoot.model.skeleton import forward_kinematics

WALKS = tuple(
    Gait(step_length=length, step_width=width, step_time=time)
    for length, time in ((0.0, 0.6), (0.35, 0.55), (0.55, 0.5), (0.75, 0.45))
    for width in (0.09, 0.18, 0.28)
)
OTHERS = (
    Gait(step_length=-0.35, step_time=0.55, heel_strike=False),
    Gait(step_length=0.5, turn=0.3, step_time=0.55),
    Gait(step_length=0.0, sideways=0.12, step_width=0.3, step_time=0.6, heel_strike=False),
    Gait(step_length=0.9, step_time=0.36, duty=0.4, step_width=0.12),
    Gait(step_length=1.1, step_time=0.35, duty=0.4, step_width=0.12),
    Gait(step_length=1.0, step_time=0.35, duty=0.4, step_width=0.24),
)


def library_of(gaits: Sequence[Gait], *, rate: float = 60.0, footsteps: int = 8, mirror: bool = True) -> ClipLibrary:
    """One clip for each gait."""
    walkers = [build_walker(gait, rate=rate, footsteps=footsteps) for gait in gaits]
    clips = [
        replace(walker.clip, name=f"/Walker/Clips/clip{index}", mirror=mirror) for index, walker in enumerate(walkers)
    ]
    return replace(walkers[0].library, clips=tuple(clips))


@dataclass(frozen=True, kw_only=True)
class WorldMotion:
    """Joints of a motion in the world, those above the pelvis at the origin."""

    times: FloatArray
    positions: FloatArray  # (F, J, 3)
    rotations: FloatArray  # (F, J, 4)
    balls: FloatArray  # (F, 2, 3)
    ankles: FloatArray  # (F, 2, 3)
    heels: FloatArray  # (F, 2, 3), points of the sole
    pelvis: FloatArray  # (F, 3)


def in_world(library: ClipLibrary, motion: Motion) -> WorldMotion:
    """A motion by forward kinematics from root, pelvis and joint rotations."""
    skeleton, biped = library.skeleton, library.biped
    frames = len(motion.times)
    turn = quaternion.yaw_quaternion(motion.root_yaws)
    translations = np.repeat(skeleton.rest_translations[None], frames, axis=0)
    rotations = motion.rotations.astype(float)
    translations[:, biped.pelvis] = motion.root_positions + quaternion.rotate(turn, motion.pelvis_positions)
    rotations[:, biped.pelvis] = quaternion.compose(turn, motion.pelvis_rotations)
    parents = skeleton.parents.copy()
    parents[biped.pelvis] = -1
    positions, world = forward_kinematics(parents, translations, rotations)
    ankles = list(biped.ankles)
    return WorldMotion(
        times=motion.times,
        positions=positions,
        rotations=world,
        balls=positions[:, list(biped.balls)],
        ankles=positions[:, ankles],
        heels=positions[:, ankles] + quaternion.rotate(world[:, ankles], sole_offsets(skeleton, biped)),
        pelvis=positions[:, biped.pelvis],
    )


def between(times: FloatArray, start: float, end: float) -> BoolArray:
    """Which times lie from start to end."""
    return (times >= start - 1e-9) & (times <= end + 1e-9)
