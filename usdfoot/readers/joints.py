"""Matches joints of one skeleton or animation to those of another by name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from usdfoot.maths.types import IntArray

__all__ = ["leaf_name", "match_joints", "parent_indices"]

_SEPARATORS = ":_-. "


def leaf_name(joint: str) -> str:
    """Last part of a joint path."""
    return joint.rsplit("/", 1)[-1]


def parent_indices(joints: Sequence[str]) -> IntArray:
    """Index of each joint's nearest listed ancestor, -1 for roots, shape (J,)."""
    index = {joint: i for i, joint in enumerate(joints)}
    parents = np.full(len(joints), -1)
    for i, joint in enumerate(joints):
        ancestor = joint
        while "/" in ancestor and parents[i] < 0:
            ancestor = ancestor.rsplit("/", 1)[0]
            parents[i] = index.get(ancestor, -1)
    return parents


def match_joints(sources: Sequence[str], wanted: Sequence[str]) -> IntArray:
    """Index into `sources` of each wanted joint, -1 where there is none, shape (len(wanted),).

    Full paths are compared first, then leaf names, then leaf names without namespace and without the prefix that all
    of a skeleton's joints share ("mixamorig:Hips" = "mixamorig_Hips" = "Hips"), then these in lower case. A leaf name
    counts only if it is unique on both sides.
    """
    matches = np.full(len(wanted), -1)
    paths = {joint: i for i, joint in enumerate(sources)}
    for i, joint in enumerate(wanted):
        matches[i] = paths.get(joint, -1)
    for rename in (_leaves, _bare_leaves, _lower_leaves):
        if (matches < 0).any():
            _match_unique(matches, rename(sources), rename(wanted))
    return matches


def _match_unique(matches: IntArray, sources: Sequence[str], wanted: Sequence[str]) -> None:
    """Fill the gaps of `matches` with joints whose name is unique on both sides."""
    source_counts, wanted_counts = Counter(sources), Counter(wanted)
    taken = set(matches.tolist())
    index = {name: i for i, name in enumerate(sources) if source_counts[name] == 1 and i not in taken}
    for i in np.flatnonzero(matches < 0).tolist():
        if wanted_counts[wanted[i]] == 1:
            matches[i] = index.get(wanted[i], -1)


def _leaves(joints: Sequence[str]) -> list[str]:
    return [leaf_name(joint) for joint in joints]


def _bare_leaves(joints: Sequence[str]) -> list[str]:
    """Leaf names without namespace and without the prefix most of them share up to a separator."""
    leaves = [leaf.rsplit(":", 1)[-1] for leaf in _leaves(joints)]
    heads = Counter(_head(leaf) for leaf in leaves)
    head, count = heads.most_common(1)[0] if heads else ("", 0)
    shared = head if count > 0.7 * len(leaves) and count > 1 else ""
    return [leaf[len(shared) :] if shared and leaf.startswith(shared) else leaf for leaf in leaves]


def _head(leaf: str) -> str:
    """Part of a name up to its first separator, separator included; empty if it has none."""
    cuts = [leaf.find(separator) for separator in _SEPARATORS if leaf.find(separator) > 0]
    return leaf[: min(cuts) + 1] if cuts else ""


def _lower_leaves(joints: Sequence[str]) -> list[str]:
    return ["".join(c for c in leaf.lower() if c.isalnum()) for leaf in _bare_leaves(joints)]
