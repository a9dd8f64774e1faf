"""Joint pairs: which joints of a skeleton are each other's left and right counterparts."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = ["joint_pairs"]


def joint_pairs(skeleton: Skeleton, biped: Biped) -> IntArray:
    """Counterpart of each joint on the other side, the joint itself in the middle, shape (J,).

    Counterparts have counterparts as parents. Among the children of two such parents the biped's legs come first, then
    names that differ in left/right or in one letter l/r, then, below one parent, the mirrored rest position, below
    two, equal names and the order.
    """
    partners = np.full(len(skeleton.joints), -1)
    legs = dict(pair for roles in (biped.hips, biped.knees, biped.ankles, biped.balls) for pair in (roles, roles[::-1]))
    places, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    images = _mirrored(places, places[list(biped.hips)])
    for joint in range(-1, len(skeleton.joints)):
        partner = partners[joint] if joint >= 0 else -1
        children, others = (np.flatnonzero(skeleton.parents == parent) for parent in (joint, partner))
        _match_names(skeleton, legs, partners, children, others)
        if joint == partner:
            _match_places(images, places, partners, children)
        else:
            _match_order(skeleton, partners, children, others)
    return partners


def _mirrored(places: FloatArray, hips: FloatArray) -> FloatArray:
    """Places (J, 3) reflected in the plane midway between two hips (2, 3)."""
    across = hips[0] - hips[1]
    normal = across / max(float(np.linalg.norm(across)), np.finfo(float).tiny)
    return places - 2.0 * ((places - hips.mean(axis=0)) @ normal)[:, None] * normal


def _match_names(
    skeleton: Skeleton, legs: dict[int, int], partners: IntArray, first: IntArray, second: IntArray
) -> None:
    """Enter the counterparts of siblings `first` among siblings `second`, by legs and names, into partners (J,)."""
    middle = np.array_equal(first, second)
    names = _leaves(skeleton, [*first, *second])
    for joint in map(int, first):
        free = [int(other) for other in second if partners[other] < 0 and (other != joint or not middle)]
        if partners[joint] >= 0:
            continue
        images = _mirror_names(names[joint])
        named = [other for other in free if names[other] in images]
        if legs.get(joint) in free:
            _pair(partners, joint, legs[joint])
        elif named:
            _pair(partners, joint, min(named, key=lambda other: images.index(names[other])))


def _match_places(images: FloatArray, places: FloatArray, partners: IntArray, siblings: IntArray) -> None:
    """Pair siblings that are each the nearest to the other's mirror image (J, 3); the others are their own partners."""
    left = siblings[partners[siblings] < 0]
    if left.size:
        nearest = np.argmin(np.linalg.norm(images[left, None] - places[left], axis=-1), axis=1)
        mutual = nearest[nearest] == np.arange(len(left))
        partners[left] = np.where(mutual, left[nearest], left)


def _match_order(skeleton: Skeleton, partners: IntArray, first: IntArray, second: IntArray) -> None:
    """Pair what is left of children of two counterparts by equal names, then in their order."""
    names = _leaves(skeleton, [*first, *second])
    right = [int(joint) for joint in second if partners[joint] < 0]
    for joint in [int(joint) for joint in first if partners[joint] < 0]:
        if right:
            other = min(right, key=lambda candidate: (names[candidate] != names[joint], right.index(candidate)))
            right.remove(other)
            _pair(partners, joint, other)
        else:
            partners[joint] = joint


def _leaves(skeleton: Skeleton, joints: Iterable[int]) -> dict[int, str]:
    """Leaf names of joints in lower case."""
    return {int(joint): skeleton.joints[joint].rsplit("/", 1)[-1].lower() for joint in joints}


def _pair(partners: IntArray, joint: int, other: int) -> None:
    partners[joint], partners[other] = other, joint


def _mirror_names(name: str) -> list[str]:
    """Names of the other side: left and right exchanged, else any one letter l or r, likeliest first."""
    words = [name.replace("left", "\0").replace("right", "left").replace("\0", "right")]
    swapped = {"l": "r", "r": "l"}
    ends = sorted((i for i, letter in enumerate(name) if letter in swapped), key=lambda i: min(i, len(name) - 1 - i))
    letters = [name[:i] + swapped[name[i]] + name[i + 1 :] for i in ends]
    return ([words[0]] if words[0] != name else []) + letters
