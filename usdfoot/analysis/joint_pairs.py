"""Joint pairs: which joints of a skeleton are each other's left and right counterparts."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton

__all__ = ["joint_pairs"]


def joint_pairs(skeleton: Skeleton, biped: Biped) -> IntArray:
    """Counterpart of each joint on the other side, the joint itself in the middle, shape (J,).

    Counterparts have counterparts as parents. Among the children of two such parents the biped's legs come first, then
    names that differ in left/right or in one letter l/r, then equal names, then the mirrored rest position.
    """
    partners = np.full(len(skeleton.joints), -1)
    legs = dict(pair for roles in (biped.hips, biped.knees, biped.ankles, biped.balls) for pair in (roles, roles[::-1]))
    _match(skeleton, legs, partners, np.flatnonzero(skeleton.parents < 0), np.flatnonzero(skeleton.parents < 0))
    for joint in range(len(skeleton.joints)):
        children = np.flatnonzero(skeleton.parents == joint)
        others = np.flatnonzero(skeleton.parents == partners[joint])
        _match(skeleton, legs, partners, children, others)
    return partners


def _match(skeleton: Skeleton, legs: dict[int, int], partners: IntArray, first: IntArray, second: IntArray) -> None:
    """Enter the counterparts of siblings `first` among siblings `second` into partners (J,)."""
    middle = np.array_equal(first, second)
    names = {int(j): skeleton.joints[j].rsplit("/", 1)[-1].lower() for j in [*first, *second]}
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
    left = [int(joint) for joint in first if partners[joint] < 0]
    right = [int(joint) for joint in second if partners[joint] < 0]
    for joint in left:
        if middle:
            partners[joint] = joint
        elif right:
            other = min(right, key=lambda candidate: (names[candidate] != names[joint], right.index(candidate)))
            right.remove(other)
            _pair(partners, joint, other)
        else:
            partners[joint] = joint


def _pair(partners: IntArray, joint: int, other: int) -> None:
    partners[joint], partners[other] = other, joint


def _mirror_names(name: str) -> list[str]:
    """Names of the other side: left and right exchanged, else any one letter l or r, likeliest first."""
    words = [name.replace("left", "\0").replace("right", "left").replace("\0", "right")]
    swapped = {"l": "r", "r": "l"}
    ends = sorted((i for i, letter in enumerate(name) if letter in swapped), key=lambda i: min(i, len(name) - 1 - i))
    letters = [name[:i] + swapped[name[i]] + name[i + 1 :] for i in ends]
    return ([words[0]] if words[0] != name else []) + letters
