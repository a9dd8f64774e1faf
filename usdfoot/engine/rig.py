"""The character's legs and feet on the device: chains, flat foot, heel, hinge of the knee."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import warp as wp

from usdfoot.analysis.feet import flat_heels
from usdfoot.analysis.flat_feet import LEVEL, flat_turns
from usdfoot.analysis.mirror import SAME_SHAPE, mirror_map
from usdfoot.engine.legs import LegRig
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.examples import Examples
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = ["Foot", "Rig", "build_rest_rig", "build_rig", "measure_feet"]

STANCE_PHASES = np.linspace(0.25, 0.5, 6)
"""Phases of a step at one of which the support foot is flat: the other foot has left the ground, the heel has not."""
STRAIGHT_KNEE = np.radians(3.0)
"""A knee of the rest pose bent by less does not tell which way it bends [rad]."""
REST_REACH = 0.995
"""Largest part of the straight leg to use where no clip tells."""
LONGEST_SHARE = 0.999
"""Part of the clips' samples in which a leg is stretched no farther than it may be."""
REACHES = (0.985, 0.9992)
"""Least and most of that, as a part of the straight leg: the knee never snaps."""


@dataclass(frozen=True, kw_only=True)
class Foot:
    """One foot flat on level ground, pointing along +Z."""

    flat_rotation: FloatArray
    """Ankle joint, shape (4,)."""
    toe_rotation: FloatArray
    """Ball joint, shape (4,)."""
    ball_offset: FloatArray
    """Ball in the ankle joint's frame [m], shape (3,)."""
    heel_offset: FloatArray
    """The heel's point of the sole in the ankle joint's frame, as the foot does not lean [m], shape (3,)."""
    heel_behind: float
    """How far the heel lies behind the ankle [m]; negative: the foot has none and stands on its toes."""

    @property
    def length(self) -> float:
        """Horizontal distance from heel to ball [m]."""
        return float(quaternion.rotate(self.flat_rotation, self.ball_offset - self.heel_offset)[2])


@dataclass(frozen=True, kw_only=True)
class Rig:
    """What the leg kernels need, on host and device."""

    feet: tuple[Foot, Foot]
    leg_joints: IntArray
    """All joints below the pelvis down to both balls."""
    arrays: LegRig

    @property
    def foot_lengths(self) -> FloatArray:
        """From heel to ball of each side [m], shape (2,)."""
        return np.array([foot.length for foot in self.feet])


def measure_feet(skeleton: Skeleton, biped: Biped, rolls: FloatArray) -> tuple[Foot, Foot]:
    """Both feet from a rest pose whose feet stand level; `rolls` [rad] (2,) is how far the clips' lean about it."""
    positions, rotations = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    feet = []
    for side in (0, 1):
        ankle, ball = biped.ankles[side], biped.balls[side]
        across = positions[ball] - positions[ankle]
        upright = quaternion.yaw_quaternion(-planar.yaw_of(across[[0, 2]]))
        across = quaternion.rotate(upright, across)
        roll = quaternion.from_axis_angle(across / np.linalg.norm(across), np.array(rolls[side]))
        level = quaternion.compose(upright, rotations[ankle])
        toes = quaternion.compose(roll, quaternion.compose(upright, rotations[ball]))
        offset = quaternion.rotate(quaternion.inverse(level), across)
        foot = _foot(level, toes, offset, float(biped.ball_heights[side]))
        feet.append(replace(foot, flat_rotation=quaternion.compose(roll, level)))
    return feet[0], feet[1]


def _foot(flat: FloatArray, toes: FloatArray, offset: FloatArray, ball_height: float) -> Foot:
    """A foot from its joints' rotations (4,) when flat and the ball in the ankle's frame (3,)."""
    heel = flat_heels(flat, offset, np.array(ball_height))
    return Foot(
        flat_rotation=flat,
        toe_rotation=toes,
        ball_offset=offset,
        heel_offset=heel,
        heel_behind=-float(quaternion.rotate(flat, heel)[2]),
    )


def _alike(skeleton: Skeleton, biped: Biped, feet: tuple[Foot, Foot]) -> tuple[Foot, Foot]:
    """Both feet as mirror images of the one whose ankle is higher over its ball, so that neither heel sinks in.

    Feet of one shape, whose pitch differs by little, are two measurements of the same; others are left as they are.
    """
    lengths = [float(np.linalg.norm(foot.ball_offset)) for foot in feet]
    across = [quaternion.rotate(foot.flat_rotation, foot.ball_offset) for foot in feet]
    pitches = [float(np.arcsin(vector[1] / length)) for vector, length in zip(across, lengths, strict=True)]
    differences = np.diff(lengths) / SAME_SHAPE, np.diff(biped.ball_heights) / SAME_SHAPE, np.diff(pitches)
    if np.abs(differences[:2]).max() > max(lengths) or abs(differences[2]) > LEVEL:
        return feet
    mirror = mirror_map(skeleton, biped)
    higher = int(np.argmin(pitches))
    ankle, ball = biped.ankles[1 - higher], biped.balls[1 - higher]
    flat, toes = (
        quaternion.compose(quaternion.mirror_x(turn), mirror.relations[joint])
        for turn, joint in ((feet[higher].flat_rotation, ankle), (feet[higher].toe_rotation, ball))
    )
    offset = feet[1 - higher].ball_offset
    to_heel = quaternion.rotate(feet[higher].flat_rotation, feet[higher].heel_offset - feet[higher].ball_offset)
    to_heel = to_heel * [-1.0, 1.0, 1.0] - [0.0, biped.ball_heights[1 - higher] - biped.ball_heights[higher], 0.0]
    heel = offset + quaternion.rotate(quaternion.inverse(flat), to_heel)
    image = replace(feet[higher], flat_rotation=flat, toe_rotation=toes, ball_offset=offset, heel_offset=heel)
    return (feet[higher], image) if higher == 0 else (image, feet[higher])


def _find_feet(skeleton: Skeleton, biped: Biped, examples: Examples) -> tuple[Foot, Foot]:
    """Both feet; where those of the rest pose do not stand level, as the examples stand on them."""
    feet = measure_feet(skeleton, biped, np.zeros(2))
    rows = [np.flatnonzero(examples.swing_sides == 1 - side) for side in (0, 1)]
    middles = [_flattest(skeleton, biped, examples, rows[i], i) for i in (0, 1)]
    ankles = [_pose_joint(skeleton, biped, examples, rows[i], middles[i], biped.ankles[i]) for i in (0, 1)]
    rest, offsets = (np.array([getattr(foot, name) for foot in feet]) for name in ("flat_rotation", "ball_offset"))
    flats = flat_turns(rest, ankles, offsets)
    if flats is None:
        return measure_feet(skeleton, biped, measure_rolls(skeleton, biped, examples))
    standing = []
    for side, foot in enumerate(feet):
        toes = foot.toe_rotation
        if len(rows[side]):
            balls = _pose_joint(skeleton, biped, examples, rows[side], middles[side], biped.balls[side])
            bent = quaternion.compose(quaternion.inverse(ankles[side]), balls)
            toes = quaternion.compose(flats[side], quaternion.mean(bent, np.ones(len(bent))))
        standing.append(_foot(flats[side], toes, offsets[side], float(biped.ball_heights[side])))
    return standing[0], standing[1]


def _flattest(skeleton: Skeleton, biped: Biped, examples: Examples, rows: IntArray, side: int) -> IntArray:
    """Samples of the steps `rows` (N,) at which the heel of the support foot is lowest over its ball, shape (N,)."""
    samples = np.round(STANCE_PHASES * (examples.rotations.shape[1] - 1)).astype(np.intp)
    turns = _pose_joint(skeleton, biped, examples, rows[:, None], samples, biped.ankles[side])
    positions, rotations = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    ankle, ball = biped.ankles[side], biped.balls[side]
    offset = quaternion.rotate(quaternion.inverse(rotations[ankle]), positions[ball] - positions[ankle])
    return samples[np.argmax(quaternion.rotate(turns, offset)[..., 1], axis=1)]


def measure_rolls(skeleton: Skeleton, biped: Biped, examples: Examples) -> FloatArray:
    """Median lean of each foot about its long axis in mid stance against the rest pose [rad], shape (2,).

    A rest pose with the legs apart has rolled feet, although they are level in every stance.
    """
    feet = measure_feet(skeleton, biped, np.zeros(2))
    middle = examples.rotations.shape[1] // 2
    rolls = np.zeros(2)
    for side in (0, 1):
        rows = np.flatnonzero(examples.swing_sides == 1 - side)
        if not rows.size:
            continue
        rotation = _pose_joint(skeleton, biped, examples, rows, middle, biped.ankles[side])
        direction = quaternion.rotate(rotation, feet[side].ball_offset)
        upright = quaternion.yaw_quaternion(-planar.yaw_of(direction[:, [0, 2]]))
        turned = quaternion.compose(upright, rotation)
        flat_direction = quaternion.rotate(feet[side].flat_rotation, feet[side].ball_offset)
        flat_direction = flat_direction / np.linalg.norm(flat_direction)
        pitch = quaternion.between(
            flat_direction, quaternion.rotate(upright, direction / np.linalg.norm(direction, axis=1, keepdims=True))
        )
        rest = quaternion.compose(
            quaternion.inverse(pitch), quaternion.compose(turned, quaternion.inverse(feet[side].flat_rotation))
        )
        rolls[side] = np.median(quaternion.to_rotation_vector(rest) @ flat_direction)
    return rolls


def _pose_joint(
    skeleton: Skeleton, biped: Biped, examples: Examples, rows: IntArray, sample: int | slice | IntArray, joint: int
) -> FloatArray:
    """Rotation of a joint below the pelvis in the support frame, shape (rows, ..., 4)."""
    rotation = examples.rotations[rows, sample, biped.pelvis].astype(float)
    for link in skeleton.chain(biped.pelvis, joint)[1:]:
        rotation = quaternion.compose(rotation, examples.rotations[rows, sample, link].astype(float))
    return rotation


def build_rig(skeleton: Skeleton, biped: Biped, examples: Examples) -> Rig:
    """Legs of a character, with what its examples tell of roll, hinges and reach."""
    axes, reach = _knees(skeleton, biped, examples)
    return _rig(skeleton, biped, _find_feet(skeleton, biped, examples), axes, reach)


def build_rest_rig(skeleton: Skeleton, biped: Biped) -> Rig:
    """Legs of a character as its rest pose stands: feet flat and level, knees that bend the way they are bent.

    Knees that are straight bend forward, the way the feet point.
    """
    feet = measure_feet(skeleton, biped, np.zeros(2))
    places, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    hips, knees, ankles, balls = (places[list(j)] for j in (biped.hips, biped.knees, biped.ankles, biped.balls))
    thighs, shins = _unit(knees - hips), _unit(ankles - knees)
    ahead = (balls - ankles) * np.array([1.0, 0.0, 1.0])
    forward = np.cross(np.array([0.0, 1.0, 0.0]), _unit(ahead))
    bends = np.cross(thighs, shins)
    bent = np.linalg.norm(bends, axis=1, keepdims=True) > np.sin(STRAIGHT_KNEE)
    axes = quaternion.rotate(quaternion.inverse(turns[list(biped.hips)]), np.where(bent, bends, forward))
    return _rig(skeleton, biped, feet, _unit(axes), REST_REACH)


def _unit(vectors: FloatArray) -> FloatArray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)


def _rig(skeleton: Skeleton, biped: Biped, feet: tuple[Foot, Foot], axes: FloatArray, reach: float) -> Rig:
    """The rig of known feet, hinges (2, 3) and reach."""
    feet = _alike(skeleton, biped, feet)
    chains = [skeleton.chain(biped.pelvis, biped.balls[side])[1:] for side in (0, 1)]
    width = max(len(chain) for chain in chains)
    padded = np.full((2, width), -1, dtype=np.int32)
    for side in (0, 1):
        padded[side, : len(chains[side])] = chains[side]
    arrays = LegRig()
    arrays.translations = wp.array(skeleton.rest_translations.astype(np.float32), dtype=wp.vec3f)
    arrays.chains = wp.array(padded, dtype=wp.int32)
    roles = [[joints[side] for joints in (biped.hips, biped.knees, biped.ankles, biped.balls)] for side in (0, 1)]
    arrays.roles = wp.array(np.array(roles, dtype=np.int32), dtype=wp.int32)
    arrays.ball_offsets = wp.array(np.array([foot.ball_offset for foot in feet], dtype=np.float32), dtype=wp.vec3f)
    arrays.heel_offsets = wp.array(np.array([foot.heel_offset for foot in feet], dtype=np.float32), dtype=wp.vec3f)
    inverses = quaternion.inverse(np.array([foot.flat_rotation for foot in feet]))
    ahead = quaternion.rotate(inverses, np.array([0.0, 0.0, 1.0]))
    arrays.flat_forwards = wp.array(ahead.astype(np.float32), dtype=wp.vec3f)
    arrays.flat_toes = wp.array(np.array([foot.toe_rotation for foot in feet], dtype=np.float32), dtype=wp.quatf)
    arrays.ball_heights = wp.array(biped.ball_heights.astype(np.float32), dtype=wp.float32)
    arrays.knee_axes = wp.array(axes.astype(np.float32), dtype=wp.vec3f)
    arrays.reach = float(reach)
    return Rig(feet=feet, leg_joints=np.unique(padded[padded >= 0]), arrays=arrays)


def _knees(skeleton: Skeleton, biped: Biped, examples: Examples) -> tuple[FloatArray, float]:
    """Mean hinge axis of each knee in the hip joint's frame (2, 3), and how far the clips stretch their legs."""
    axes, stretches = np.zeros((2, 3)), []
    for side in (0, 1):
        chain = skeleton.chain(biped.hips[side], biped.ankles[side])
        parents = np.arange(-1, len(chain) - 1)
        rotations = examples.rotations[:, :, chain].astype(float)
        rotations[:, :, 0] = [0.0, 0.0, 0.0, 1.0]
        translations = skeleton.rest_translations[list(chain)].copy()
        translations[0] = 0.0
        positions, _ = forward_kinematics(parents, translations, rotations)
        knee = chain.index(biped.knees[side])
        thigh, shin = positions[..., knee, :], positions[..., -1, :] - positions[..., knee, :]
        total = np.linalg.norm(thigh, axis=-1) + np.linalg.norm(shin, axis=-1)
        stretches.append((np.linalg.norm(positions[..., -1, :], axis=-1) / total).ravel())
        axis = np.cross(thigh, shin).reshape(-1, 3).sum(axis=0)
        axes[side] = axis / np.linalg.norm(axis)
    reach = np.quantile(np.concatenate(stretches), LONGEST_SHARE)
    return axes, float(np.clip(reach, *REACHES))
