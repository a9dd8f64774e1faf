"""Rigs made from another one, so that what a clip must look like on them is known."""

from dataclasses import replace

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton, forward_kinematics
from usdfoot.retarget.rig import Rig, build_rig


def world(skeleton: Skeleton) -> tuple[np.ndarray, np.ndarray]:
    return forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)


def from_world(skeleton: Skeleton, places, turns) -> Skeleton:
    """The skeleton with a rest pose of these joint positions and rotations."""
    above = np.where(skeleton.parents < 0, 0, skeleton.parents)
    roots = (skeleton.parents < 0)[:, None]
    back = np.where(roots, [0.0, 0.0, 0.0, 1.0], quaternion.inverse(turns[above]))
    offsets = places - np.where(roots, 0.0, places[above])
    return replace(
        skeleton,
        rest_translations=quaternion.rotate(back, offsets),
        rest_rotations=quaternion.compose(back, turns),
    )


def other_axes(skeleton: Skeleton, generator) -> tuple[Skeleton, np.ndarray]:
    """The same bones in the same rest pose with random joint axes, and the turns (J, 4) of the axes."""
    places, turns = world(skeleton)
    axes = quaternion.normalised(generator.normal(size=turns.shape))
    return from_world(skeleton, places, quaternion.compose(turns, axes)), axes


def swung(skeleton: Skeleton, swings: dict[int, np.ndarray]) -> Skeleton:
    """The same bones and axes in another rest pose: joints and all below them turned about themselves in the world."""
    local = skeleton.rest_rotations.copy()
    for joint, swing in swings.items():
        _, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, local)
        parent = turns[skeleton.parents[joint]]
        change = quaternion.compose(quaternion.compose(quaternion.inverse(parent), swing), parent)
        local[joint] = quaternion.compose(change, local[joint])
    return replace(skeleton, rest_rotations=local)


def spread_arms(rig: Rig) -> Skeleton:
    """The rig with its arms spread to the sides, elbows straight: a T-pose."""
    skeleton = rig.skeleton
    for side, arm in enumerate(rig.body.arms):
        outward = np.array([1.0 if side == 0 else -1.0, 0.0, 0.0])
        for start, end in ((arm.upper, arm.lower), (arm.lower, arm.hand)):
            places, _ = world(skeleton)
            bone = places[end] - places[start]
            skeleton = swung(skeleton, {start: quaternion.between(bone / np.linalg.norm(bone), outward)})
    return skeleton


def scaled(skeleton: Skeleton, biped: Biped, factor: float) -> tuple[Skeleton, Biped]:
    """All lengths times a factor."""
    bigger = replace(
        biped,
        ball_heights=factor * biped.ball_heights,
        com=factor * biped.com,
        nominal_leg_length=factor * biped.nominal_leg_length,
        maximal_leg_length=factor * biped.maximal_leg_length,
    )
    return replace(skeleton, rest_translations=factor * skeleton.rest_translations), bigger


def reproportioned(skeleton: Skeleton, factors: dict[int, float]) -> Skeleton:
    """Bones that end at joints times factors; the feet are brought back to the ground."""
    stretches = np.ones(len(skeleton.joints))
    for joint, factor in factors.items():
        stretches[joint] = factor
    longer = replace(skeleton, rest_translations=skeleton.rest_translations * stretches[:, None])
    drop = world(longer)[0][:, 1].min() - world(skeleton)[0][:, 1].min()
    places, turns = world(longer)
    return from_world(longer, places - np.array([0.0, drop, 0.0]), turns)


def rig_of(skeleton: Skeleton, biped: Biped) -> Rig:
    return build_rig(skeleton, biped)
