"""Legs by joint names: Mixamo, HumanIK, CMU, BVH, Unreal, Unity, Blender, 3ds Max, SMPL and their like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from usdfoot.analysis.joint_words import chain_by_names, is_helper, likeliest_below, words_of
from usdfoot.maths.types import IntArray

__all__ = ["LEG_ROLES", "is_pelvis", "leg_by_names"]

LEG_ROLES = ("hip", "knee", "ankle", "ball")
"""Joints of a leg from the top."""

_WORDS: dict[str, dict[str, float]] = {
    "hip": {
        "upleg": 0.0, "upperleg": 0.0, "legupper": 0.0, "thigh": 0.0, "femur": 0.0, "hip": 0.2, "hipjoint": 0.6,
        "leg": 1.5, "leg1": 0.4,
    },
    "knee": {
        "leg": 0.0, "lowerleg": 0.0, "leglower": 0.0, "lowleg": 0.0, "loleg": 0.0, "calf": 0.0, "shin": 0.0,
        "tibia": 0.0, "knee": 0.0, "shank": 0.0, "leg2": 0.4,
    },
    "ankle": {"foot": 0.0, "ankle": 0.0, "leg3": 0.6},
    "ball": {
        "toebase": 0.0, "toes": 0.0, "toe": 0.0, "toe0": 0.0, "toe1": 0.2, "ball": 0.0, "forefoot": 0.2,
        "metatarsals": 0.8, "metatarsal": 0.8, "foot": 1.0,
    },
}  # fmt: skip

_PELVIS = frozenset({"pelvis", "hip", "hips"})
"""Words for the joint that carries both legs."""


def leg_by_names(
    joints: Sequence[str], parents: IntArray, side: int, *, fixed: Mapping[str, int]
) -> dict[str, int] | None:
    """Joint index by role of one leg, the chain whose names are least in doubt.

    Args:
        joints: Joint paths, J of them.
        parents: Index of each joint's parent, -1 for roots, shape (J,).
        side: 0 = left, 1 = right.
        fixed: Joints already known, by role.

    Returns:
        Hip, knee, ankle and, if found, ball; None if one of the first three is not found.
    """
    best: tuple[float, dict[str, int]] | None = None
    for doubt, chain in chain_by_names(joints, parents, side, words=_WORDS, roles=LEG_ROLES[:3], fixed=fixed):
        ball = likeliest_below(joints, parents, side, words=_WORDS, role="ball", fixed=fixed, ancestor=chain["ankle"])
        # A known ball that is not below the ankle is left to the caller's check.
        total = doubt + (ball[0] if ball else 1.0)
        if best is None or total < best[0]:
            best = total, chain | ({"ball": ball[1]} if ball else {})
    return best[1] if best else None


def is_pelvis(joint: str) -> bool:
    """Whether a joint's name says that it carries both legs."""
    return not _PELVIS.isdisjoint(words_of(joint)) and not is_helper(joint)
