"""Legs by the shape of the rest pose: the two chains that reach down side by side."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["legs_by_shape", "reaching_child"]

_MIRROR_TOLERANCE = 0.15
"""Largest difference between the two legs' lengths, as a fraction of them."""
_SHORT = 0.02
"""Bones shorter than this fraction of the leg are twist or offset joints."""


def legs_by_shape(parents: IntArray, positions: FloatArray) -> tuple[dict[str, int], dict[str, int]] | None:
    """Joint index by role of the left and right leg, found without names; None if there are no two such chains.

    The legs end in the lowest joints of the rest pose. Their longest two bones are thigh and shin, and the ball is
    the next joint towards the toes, which reach farther than a heel. Left is where +X points when the feet point to +Z.

    Args:
        parents: Index of each joint's parent, -1 for roots, shape (J,).
        positions: Rest positions, +Y up, shape (J, 3).
    """
    height = np.ptp(positions[:, 1])
    leaves = np.setdiff1d(np.arange(len(parents)), parents)
    if len(leaves) < 2 or height <= 0.0:
        return None
    ordered = leaves[np.argsort(positions[leaves, 1], kind="stable")]
    first = _chain(parents, ordered[0])
    for leaf in ordered[1:]:
        second = _chain(parents, leaf)
        shared = len(set(first) & set(second))
        fork = positions[first[shared - 1], 1] if shared else -np.inf
        # Toes of one foot part near the ground, legs part high up.
        if fork - positions[ordered[0], 1] > 0.25 * height:
            pair = [_roles(chain[shared:], parents, positions) for chain in (first, second)]
            return _sorted_sides(pair[0], pair[1], positions)
    return None


def _chain(parents: IntArray, joint: int) -> list[int]:
    """Joints from the root down to a joint."""
    way = [int(joint)]
    while parents[way[-1]] >= 0:
        way.append(int(parents[way[-1]]))
    return way[::-1]


def reaching_child(
    parents: IntArray, positions: FloatArray, joint: int, *, children: Sequence[int] | None = None
) -> int | None:
    """The child at or below which a joint lies farthest from the joint itself; None if all lie on it, or without any.

    Args:
        parents: Index of each joint's parent, -1 for roots, shape (J,).
        positions: Rest positions, shape (J, 3).
        joint: Whose children.
        children: Those that count; None: all.
    """
    distances = np.linalg.norm(positions - positions[joint], axis=1)
    reaches = dict.fromkeys(np.flatnonzero(parents == joint).tolist() if children is None else children, 0.0)
    for other in np.flatnonzero(distances > 0.0).tolist():
        for above in reaches.keys() & set(_chain(parents, other)):
            reaches[above] = max(reaches[above], float(distances[other]))
    best = max(reaches, key=lambda child: reaches[child], default=None)
    return best if best is not None and reaches[best] > 0.0 else None


def _roles(chain: list[int], parents: IntArray, positions: FloatArray) -> dict[str, int] | None:
    """Hip, knee, ankle and, if there is one, ball of a chain that starts below the pelvis."""
    bones = np.linalg.norm(np.diff(positions[chain], axis=0), axis=1)
    if len(bones) < 2:
        return None
    thigh, shin = np.sort(np.argsort(-bones, kind="stable")[:2])
    leg = {"hip": chain[thigh], "knee": chain[thigh + 1], "ankle": chain[shin + 1]}
    ball = reaching_child(parents, positions, leg["ankle"])
    while ball is not None and np.linalg.norm(positions[ball] - positions[leg["ankle"]]) <= _SHORT * bones.sum():
        ball = reaching_child(parents, positions, ball)
    return leg if ball is None else leg | {"ball": ball}


def _sorted_sides(
    first: dict[str, int] | None, second: dict[str, int] | None, positions: FloatArray
) -> tuple[dict[str, int], dict[str, int]] | None:
    """The two legs as (left, right), if they are of one length and stand side by side."""
    if first is None or second is None:
        return None
    lengths = [_length(leg, positions) for leg in (first, second)]
    apart = (positions[first["hip"]] - positions[second["hip"]])[[0, 2]]
    if abs(lengths[0] - lengths[1]) > _MIRROR_TOLERANCE * max(lengths) or not np.linalg.norm(apart) > 0.0:
        return None
    left_direction = np.array([1.0, 0.0])
    if "ball" in first and "ball" in second:
        feet = [(positions[leg["ball"]] - positions[leg["ankle"]])[[0, 2]] for leg in (first, second)]
        forward = feet[0] + feet[1]
        if np.linalg.norm(forward) > _SHORT * max(lengths):
            left_direction = np.array([forward[1], -forward[0]])
    return (first, second) if apart @ left_direction > 0.0 else (second, first)


def _length(leg: dict[str, int], positions: FloatArray) -> float:
    chain = positions[[leg["hip"], leg["knee"], leg["ankle"]]]
    return float(np.linalg.norm(np.diff(chain, axis=0), axis=1).sum())
