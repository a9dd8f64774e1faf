"""Legs by joint names: Mixamo, HumanIK, CMU, BVH, Unreal, Unity, Blender, 3ds Max, SMPL and their like."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping, Sequence

from usdfoot.maths.types import IntArray

__all__ = ["LEG_ROLES", "is_helper", "is_pelvis", "leg_by_names"]

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
"""Words for each role and how doubtful they are: 0 is certain."""

_HELPERS = frozenset(
    {
        "twist", "roll", "ik", "fk", "control", "ctrl", "ctl", "pole", "target", "helper", "nub", "end", "tip", "mch",
        "org", "socket", "slot", "corrective", "footsteps", "handle", "null", "aux", "driver", "offset", "weapon",
    }
)  # fmt: skip
"""Words of joints that are not bones of the leg."""

_PELVIS = frozenset({"pelvis", "hip", "hips"})
"""Words for the joint that carries both legs."""

_SIDES = ({"left", "l", "lt", "lf"}, {"right", "r", "rt", "rg"})
_NEUTRAL = frozenset({"def", "bip", "bone", "joint", "jnt", "j", "bind", "skin", "drv"})
_WORD = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|\d+")
_VOCABULARY = frozenset(itertools.chain.from_iterable(_WORDS.values()))
_DEPTH_PENALTY = 0.3
"""Doubt added for each joint between two joints of a leg."""
_STRAY_PENALTY = 0.5
"""Doubt added for each word of a name that says neither role nor side."""


def leg_by_names(
    joints: Sequence[str], parents: IntArray, side: int, fixed: Mapping[str, int]
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
    candidates = {role: _candidates(joints, role, side, fixed) for role in LEG_ROLES}
    depths = [_ancestors(parents, joint) for joint in range(len(joints))]
    best: tuple[float, dict[str, int]] | None = None
    for doubt, chain in _chains(candidates, depths, ("hip", "knee", "ankle"), frozenset(fixed)):
        ball = _best_below(candidates["ball"], depths, chain["ankle"])
        # A known ball that is not below the ankle is left to the caller's check.
        total = doubt + (ball[0] if ball else 1.0)
        if best is None or total < best[0]:
            best = total, chain | ({"ball": ball[1]} if ball else {})
    return best[1] if best else None


def is_helper(joint: str) -> bool:
    """Whether a joint's name says that it is a control, twist or end joint and no bone."""
    return not _HELPERS.isdisjoint(_words(joint))


def is_pelvis(joint: str) -> bool:
    """Whether a joint's name says that it carries both legs."""
    words = _words(joint)
    return not _PELVIS.isdisjoint(words) and _HELPERS.isdisjoint(words)


def _chains(
    candidates: Mapping[str, list[tuple[float, int]]],
    depths: Sequence[Sequence[int]],
    roles: Sequence[str],
    fixed: frozenset[str],
) -> list[tuple[float, dict[str, int]]]:
    """All descending combinations of candidates with their doubt."""
    chains: list[tuple[float, dict[str, int]]] = [(doubt, {roles[0]: joint}) for doubt, joint in candidates[roles[0]]]
    for above, role in itertools.pairwise(roles):
        longer = []
        for doubt, chain in chains:
            for more, joint in candidates[role]:
                if chain[above] in depths[joint]:
                    between = 0 if role in fixed else depths[joint].index(chain[above])
                    longer.append((doubt + more + _DEPTH_PENALTY * between, chain | {role: joint}))
        chains = longer
    return chains


def _best_below(
    candidates: Sequence[tuple[float, int]], depths: Sequence[Sequence[int]], ancestor: int
) -> tuple[float, int] | None:
    below = [
        (doubt + _DEPTH_PENALTY * depths[joint].index(ancestor), joint)
        for doubt, joint in candidates
        if ancestor in depths[joint]
    ]
    return min(below, default=None)


def _candidates(joints: Sequence[str], role: str, side: int, fixed: Mapping[str, int]) -> list[tuple[float, int]]:
    """Joints whose name may mean the role, with the doubt of each."""
    if role in fixed:
        return [(0.0, fixed[role])]
    found = []
    for index, joint in enumerate(joints):
        words = _words(joint)
        if _HELPERS.isdisjoint(words):
            own_side, rest = _take_side(words)
            doubt = _doubt(rest, role) if own_side == side else None
            if doubt is not None:
                found.append((doubt, index))
    return found


def _doubt(words: Sequence[str], role: str) -> float | None:
    """Doubt that the words mean the role; None if they do not. The longest run of words decides the meaning."""
    spans = [(i, j) for i in range(len(words)) for j in range(i + 1, len(words) + 1)]
    spans = [span for span in spans if "".join(words[slice(*span)]) in _VOCABULARY]
    if not spans:
        return None
    start, end = max(spans, key=lambda span: (span[1] - span[0], span[0]))
    meaning = "".join(words[start:end])
    if meaning not in _WORDS[role]:
        return None
    stray = [word for word in (*words[:start], *words[end:]) if word not in _NEUTRAL]
    return _WORDS[role][meaning] + _STRAY_PENALTY * len(stray)


def _take_side(words: Sequence[str]) -> tuple[int | None, list[str]]:
    """Side the words name, and the words without it. Written-together sides as in "lfemur" are taken apart."""
    for side, names in enumerate(_SIDES):
        for i, word in enumerate(words):
            if word in names:
                return side, [*words[:i], *words[i + 1 :]]
    for side, names in enumerate(_SIDES):
        for i, word in enumerate(words):
            for name in sorted(names, key=len, reverse=True):
                for rest in (word.removeprefix(name), word.removesuffix(name)):
                    if rest != word and rest in _VOCABULARY:
                        return side, [*words[:i], rest, *words[i + 1 :]]
    return None, list(words)


def _words(joint: str) -> list[str]:
    """Words of a joint's leaf name without its namespace, in lower case."""
    leaf = joint.rsplit("/", 1)[-1].rsplit(":", 1)[-1]
    return [word.lower() for word in _WORD.findall(leaf)]


def _ancestors(parents: IntArray, joint: int) -> list[int]:
    """Ancestors of a joint, nearest first."""
    way = []
    while (joint := int(parents[joint])) >= 0:
        way.append(joint)
    return way
