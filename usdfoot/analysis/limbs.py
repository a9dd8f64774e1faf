"""What else a biped has beside its legs: spine, neck, arms or wings, tail, found by the shape of the rest pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.arm_names import is_tail
from usdfoot.analysis.joint_pairs import joint_pairs
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton

__all__ = ["Limbs", "find_limbs"]

SHORTEST_ARM = 0.15
"""Limbs shorter than this part of the leg are no arms (ears, eyes, fins)."""
SHORTEST_BONE = 0.6
"""The upper arm is the first bone of an arm that has at least this part of its longest one; collar bones have less."""


@dataclass(frozen=True, kw_only=True)
class Limbs:
    """Joints outside the legs that take part in the motion, each chain from the pelvis outward."""

    spine: tuple[int, ...]
    """Above the pelvis up to where the arms branch off; all of the trunk where there are none."""
    neck: tuple[int, ...]
    """From there to the head."""
    tail: tuple[int, ...]
    upper_arms: tuple[int, int] | None
    """Left and right."""
    lower_arms: tuple[int, int] | None
    hands: tuple[int, int] | None
    """Where the lower arms end."""


def find_limbs(skeleton: Skeleton, biped: Biped, places: FloatArray) -> Limbs:
    """The limbs of a character.

    Chains of joints in the middle of the body that lead backward more than up or down, or are named so, are tails; the
    longest other one that does not hang down is the spine, even where the legs hang on it, as 3ds Max has them. The
    longest pair of chains that branches off the spine is the arms.

    Args:
        skeleton: The character's.
        biped: Its legs.
        places: Rest positions in the body's frame, +Z ahead [m], shape (J, 3).
    """
    partners = joint_pairs(skeleton, biped)
    ways = [set(skeleton.chain(biped.pelvis, hip)) for hip in biped.hips]
    legs = ways[0] ^ ways[1]
    reach = _reaches(skeleton, places, legs)
    middle = [j for j in _children(skeleton, biped.pelvis) if partners[j] == j and j not in legs]
    chains = [_longest_chain(skeleton, partners, reach, joint) for joint in middle]
    tails: list[tuple[int, ...]] = []
    trunks: list[tuple[int, ...]] = []
    for chain in chains:
        x, y, z = places[chain[-1]] - places[biped.pelvis]
        if is_tail(skeleton.joints[chain[0]]) or -z > abs(y):
            tails.append(chain)
        elif -y < np.hypot(x, z):
            trunks.append(chain)
    trunk = max(trunks, key=lambda chain: reach[chain[0]], default=())
    tail = max(tails, key=lambda chain: reach[chain[0]], default=())
    shortest = SHORTEST_ARM * biped.maximal_leg_length
    arms = [
        (joint, float(reach[joint]), at)
        for at, above in enumerate((biped.pelvis, *trunk))
        for joint in _children(skeleton, above)
        if partners[joint] != joint and joint not in legs and reach[joint] > shortest
    ]
    if not arms:
        return Limbs(spine=trunk, neck=(), tail=tail, upper_arms=None, lower_arms=None, hands=None)
    first, _, at = max(arms, key=lambda arm: arm[1])
    pair = _left_first(first, int(partners[first]), places)
    joints = [_arm(skeleton, reach, places, joint) for joint in pair]
    return Limbs(
        spine=trunk[:at],
        neck=trunk[at:],
        tail=tail,
        upper_arms=(joints[0][0], joints[1][0]),
        lower_arms=(joints[0][1], joints[1][1]),
        hands=(joints[0][2], joints[1][2]),
    )


def _children(skeleton: Skeleton, joint: int) -> list[int]:
    return [int(child) for child in np.flatnonzero(skeleton.parents == joint)]


def _reaches(skeleton: Skeleton, places: FloatArray, legs: set[int]) -> FloatArray:
    """Length of the longest way down from each joint's parent through it to a leaf but by the legs [m], shape (J,)."""
    reach = np.zeros(len(places))
    for joint in sorted(set(range(len(places))) - legs, reverse=True):
        below = max((reach[child] for child in _children(skeleton, joint)), default=0.0)
        parent = skeleton.parents[joint]
        reach[joint] = below + (np.linalg.norm(places[joint] - places[parent]) if parent >= 0 else 0.0)
    return reach


def _longest_chain(skeleton: Skeleton, partners: IntArray, reach: FloatArray, joint: int) -> tuple[int, ...]:
    """The longest way down from a joint along joints in the middle of the body."""
    way = [joint]
    while True:
        below = [child for child in _children(skeleton, way[-1]) if partners[child] == child]
        if not below:
            return tuple(way)
        way.append(max(below, key=lambda child: reach[child]))


def _left_first(first: int, second: int, places: FloatArray) -> tuple[int, int]:
    return (first, second) if places[first, 0] > places[second, 0] else (second, first)


def _arm(skeleton: Skeleton, reach: FloatArray, places: FloatArray, joint: int) -> tuple[int, int, int]:
    """Joints at the begin of the upper arm, of the lower arm, and at its end."""
    way = [joint]
    while below := _children(skeleton, way[-1]):
        way.append(max(below, key=lambda child: reach[child]))
    bones = np.linalg.norm(np.diff(places[way], axis=0), axis=1)
    if not len(bones):
        return joint, joint, joint
    upper = int(np.argmax(bones >= SHORTEST_BONE * bones.max()))
    lower = min(upper + 1, len(way) - 1)
    return way[upper], way[lower], way[min(upper + 2, len(way) - 1)]
