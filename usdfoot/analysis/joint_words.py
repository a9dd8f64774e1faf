"""Words of joint names: which side they name, which role they mean, and how doubtful that is."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Mapping, Sequence

from usdfoot.maths.types import IntArray

__all__ = ["RoleWords", "ancestors", "chain_by_names", "is_end", "is_helper", "likeliest_below", "side_of", "words_of"]

RoleWords = Mapping[str, Mapping[str, float]]
"""Words for each role of a limb and how doubtful they are: 0 is certain."""

_HELPERS = frozenset(
    {
        "twist", "roll", "ik", "fk", "control", "ctrl", "ctl", "pole", "target", "helper", "nub", "end", "tip", "mch",
        "org", "socket", "slot", "corrective", "footsteps", "handle", "null", "aux", "driver", "offset", "weapon",
    }
)  # fmt: skip
"""Words of joints that are not bones of a limb."""

_ENDS = frozenset({"end", "nub", "tip"})
"""Words of joints that only say where the bone above them ends."""

_SIDES = ({"left", "l", "lt", "lf"}, {"right", "r", "rt", "rg"})
_NEUTRAL = frozenset({"def", "bip", "bone", "joint", "jnt", "j", "bind", "skin", "drv"})
_WORD = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+|[A-Z]+|\d+")
_COMMON = 0.7
"""Words in more than this part of a skeleton's names are a prefix that exporters put before all of them."""
_DEPTH_PENALTY = 0.3
"""Doubt added for each joint between two joints of a limb."""
_STRAY_PENALTY = 0.5
"""Doubt added for each word of a name that says neither role nor side."""


def words_of(joint: str) -> list[str]:
    """Words of a joint's leaf name without its namespace, in lower case."""
    leaf = joint.rsplit("/", 1)[-1].rsplit(":", 1)[-1]
    return [word.lower() for word in _WORD.findall(leaf)]


def side_of(name: str) -> int | None:
    """Side that a name says, 0 = left, 1 = right; None if it says none or both."""
    words = words_of(name)
    said = [side for side, sides in enumerate(_SIDES) if not sides.isdisjoint(words)]
    return said[0] if len(said) == 1 else None


def is_helper(joint: str) -> bool:
    """Whether a joint's name says that it is a control, twist or end joint and no bone."""
    return not _HELPERS.isdisjoint(words_of(joint))


def is_end(joint: str) -> bool:
    """Whether a joint's name says that it is the end of the bone above it."""
    return not _ENDS.isdisjoint(words_of(joint))


def ancestors(parents: IntArray, joint: int) -> list[int]:
    """Ancestors of a joint, nearest first."""
    way = []
    while (joint := int(parents[joint])) >= 0:
        way.append(joint)
    return way


def chain_by_names(
    joints: Sequence[str],
    parents: IntArray,
    side: int,
    *,
    words: RoleWords,
    roles: Sequence[str],
    fixed: Mapping[str, int],
) -> list[tuple[float, dict[str, int]]]:
    """All descending combinations of joints whose names may mean the roles, with the doubt of each.

    Args:
        joints: Joint paths, J of them.
        parents: Index of each joint's parent, -1 for roots, shape (J,).
        side: 0 = left, 1 = right.
        words: Of all roles of the limb; the longest known word decides what a name means.
        roles: Wanted, from the top.
        fixed: Joints already known, by role.
    """
    depths = [ancestors(parents, joint) for joint in range(len(joints))]
    first = _candidates(joints, roles[0], side, words, fixed)
    chains: list[tuple[float, dict[str, int]]] = [(doubt, {roles[0]: joint}) for doubt, joint in first]
    for above, role in itertools.pairwise(roles):
        longer = []
        candidates = _candidates(joints, role, side, words, fixed)
        for doubt, chain in chains:
            for more, joint in candidates:
                if chain[above] in depths[joint]:
                    between = 0 if role in fixed else depths[joint].index(chain[above])
                    longer.append((doubt + more + _DEPTH_PENALTY * between, chain | {role: joint}))
        chains = longer
    return chains


def likeliest_below(
    joints: Sequence[str],
    parents: IntArray,
    side: int,
    *,
    words: RoleWords,
    role: str,
    fixed: Mapping[str, int],
    ancestor: int,
) -> tuple[float, int] | None:
    """The joint below an ancestor whose name means a role with the least doubt, and that doubt; None without any."""
    below = []
    for doubt, joint in _candidates(joints, role, side, words, fixed):
        above = ancestors(parents, joint)
        if ancestor in above:
            below.append((doubt + _DEPTH_PENALTY * above.index(ancestor), joint))
    return min(below, default=None)


def _candidates(
    joints: Sequence[str], role: str, side: int, words: RoleWords, fixed: Mapping[str, int]
) -> list[tuple[float, int]]:
    """Joints whose name may mean the role, with the doubt of each."""
    if role in fixed:
        return [(0.0, fixed[role])]
    vocabulary = frozenset(itertools.chain.from_iterable(words.values()))
    names_of = [words_of(joint) for joint in joints]
    neutral = _NEUTRAL | _common_words(names_of)
    found = []
    for index, names in enumerate(names_of):
        if _HELPERS.isdisjoint(names):
            own_side, rest = _take_side(names, vocabulary)
            doubt = _doubt(rest, words[role], vocabulary, neutral) if own_side == side else None
            if doubt is not None:
                found.append((doubt, index))
    return found


def _common_words(names_of: Sequence[Sequence[str]]) -> frozenset[str]:
    """Words in nearly all names of a skeleton, which tell no joint from another."""
    counts = Counter(itertools.chain.from_iterable(map(set, names_of)))
    return frozenset(word for word, count in counts.items() if count > _COMMON * len(names_of))


def _doubt(
    names: Sequence[str], meanings: Mapping[str, float], vocabulary: frozenset[str], neutral: frozenset[str]
) -> float | None:
    """Doubt that the words mean the role; None if they do not. The longest run of words decides the meaning."""
    spans = [(i, j) for i in range(len(names)) for j in range(i + 1, len(names) + 1)]
    spans = [span for span in spans if "".join(names[slice(*span)]) in vocabulary]
    if not spans:
        return None
    start, end = max(spans, key=lambda span: (span[1] - span[0], span[0]))
    meaning = "".join(names[start:end])
    if meaning not in meanings:
        return None
    stray = [name for name in (*names[:start], *names[end:]) if name not in neutral]
    return meanings[meaning] + _STRAY_PENALTY * len(stray)


def _take_side(names: Sequence[str], vocabulary: frozenset[str]) -> tuple[int | None, list[str]]:
    """Side the words name, and the words without it. Written-together sides as in "lfemur" are taken apart."""
    for side, sides in enumerate(_SIDES):
        for i, name in enumerate(names):
            if name in sides:
                return side, [*names[:i], *names[i + 1 :]]
    for side, sides in enumerate(_SIDES):
        for i, name in enumerate(names):
            for prefix in sorted(sides, key=len, reverse=True):
                for rest in (name.removeprefix(prefix), name.removesuffix(prefix)):
                    if rest != name and rest in vocabulary:
                        return side, [*names[:i], rest, *names[i + 1 :]]
    return None, list(names)
