"""Arms, neck, head and tail by joint names: Mixamo, HumanIK, CMU, Unreal, Unity, Blender, 3ds Max, Daz and others."""

from __future__ import annotations

from collections.abc import Sequence

from usdfoot.analysis.joint_words import chain_by_names, is_helper, words_of
from usdfoot.maths.types import IntArray

__all__ = ["ARM_ROLES", "arm_by_names", "is_head", "is_neck", "is_tail"]

ARM_ROLES = ("upper arm", "lower arm", "hand")
"""Joints of an arm from the shoulder: where the upper arm, the lower arm and the hand begin."""

_WORDS: dict[str, dict[str, float]] = {
    "collar": {"clavicle": 0.0, "collar": 0.0, "collarbone": 0.0, "scapula": 0.0, "shoulderblade": 0.0},
    "upper arm": {
        "upperarm": 0.0, "uparm": 0.0, "armupper": 0.0, "humerus": 0.0, "bicep": 0.2, "arm": 0.3, "arm1": 0.4,
        "shoulder": 0.8, "shoulderjoint": 0.8,
    },
    "lower arm": {
        "lowerarm": 0.0, "loarm": 0.0, "lowarm": 0.0, "armlower": 0.0, "forearm": 0.0, "elbow": 0.0, "radius": 0.0,
        "ulna": 0.2, "arm2": 0.4,
    },
    "hand": {"wrist": 0.0, "hand": 0.1, "palm": 0.5, "arm3": 0.6},
}  # fmt: skip
"""Nobody asks for the collar: its words say that a joint is no arm."""


def arm_by_names(joints: Sequence[str], parents: IntArray, side: int) -> dict[str, int] | None:
    """Joint index by role of one arm, the chain whose names are least in doubt.

    Args:
        joints: Joint paths, J of them.
        parents: Index of each joint's parent, -1 for roots, shape (J,).
        side: 0 = left, 1 = right.

    Returns:
        Upper arm, lower arm and, if found, hand; None if one of the first two is not found.
    """
    for roles in (ARM_ROLES, ARM_ROLES[:2]):
        chains = chain_by_names(joints, parents, side, words=_WORDS, roles=roles, fixed={})
        if chains:
            return min(chains, key=lambda chain: chain[0])[1]
    return None


def is_neck(joint: str) -> bool:
    """Whether a joint's name says that it is part of the neck."""
    return any("neck" in word for word in words_of(joint)) and not is_helper(joint)


def is_head(joint: str) -> bool:
    """Whether a joint's name says that it carries the head."""
    words = words_of(joint)
    return ("head" in words or "skull" in words) and not is_helper(joint)


def is_tail(joint: str) -> bool:
    """Whether a joint's name says that it is part of the tail."""
    return "tail" in words_of(joint) and not is_helper(joint)
