"""Axes: how the local axes of joints differ between two skeletons with the same joints.

A joint's axes are what its children's rest translations, which no pose changes, and its rest rotation are given in.
Rigs of the same body from different programs have other axes; rotations mean something else there.
"""

from __future__ import annotations

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = ["axis_turns", "best_turn", "with_axes"]


def axis_turns(own: Skeleton, other: Skeleton, order: IntArray) -> FloatArray:
    """Rotations C from the axes of `other` to those of `own`, xyzw, shape (K, 4); the identity for joints of own alone.

    C turns the directions to a joint's children onto each other. Where that leaves a turn free (one child or none), the
    rest rotations decide, from the parent's turn on: W_own C = W_other for rotations W in the world of one pose.

    Args:
        own: K joints.
        other: J joints.
        order: Joint of `own` for each of `other`, -1 for none, shape (J,).
    """
    partners = {int(joint): partner for partner, joint in enumerate(order) if joint >= 0}
    rests = [forward_kinematics(each.parents, each.rest_translations, each.rest_rotations)[1] for each in (own, other)]
    turns = np.tile([0.0, 0.0, 0.0, 1.0], (len(own.joints), 1))
    for joint, parent in enumerate(own.parents.tolist()):
        if joint not in partners:
            continue
        partner = partners[joint]
        if parent >= 0 and partners.get(parent) == other.parents[partner]:
            turned = quaternion.compose(turns[parent], other.rest_rotations[partner])
            expected = quaternion.compose(quaternion.inverse(own.rest_rotations[joint]), turned)
        else:
            expected = quaternion.compose(quaternion.inverse(rests[0][joint]), rests[1][partner])
        children = [
            child
            for child in np.flatnonzero(own.parents == joint).tolist()
            if child in partners and other.parents[partners[child]] == partner
        ]
        offsets = _directions(other.rest_translations[[partners[child] for child in children]])
        turns[joint] = best_turn(offsets, _directions(own.rest_translations[children]), expected)
    return turns


def with_axes(
    parents: IntArray, turns: FloatArray, *, translations: FloatArray, rotations: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Joint-local samples (..., K, 3) and (..., K, 4) in axes turned by (K, 4); every joint stays where it is."""
    above = np.where((parents >= 0)[:, None], quaternion.inverse(turns[parents]), [0.0, 0.0, 0.0, 1.0])
    return (
        quaternion.rotate(above, translations),
        quaternion.compose(above, quaternion.compose(rotations, turns)),
    )


def _directions(offsets: FloatArray) -> FloatArray:
    """Offsets (N, 3) as unit vectors, zero where they are none."""
    lengths = np.linalg.norm(offsets, axis=1, keepdims=True)
    return np.where(lengths > 1e-6, offsets / np.maximum(lengths, 1e-6), 0.0)


def best_turn(offsets: FloatArray, images: FloatArray, expected: FloatArray) -> FloatArray:
    """Rotation that turns offsets (K, 3) onto images (K, 3), as near to `expected` (4,) as they leave it free."""
    size = float(np.sum(offsets**2))
    if size < 1e-12:
        return expected
    moments = images.T @ offsets / size
    for _ in range(4):
        left, _, right = np.linalg.svd(moments + 1e-3 * quaternion.to_matrix(expected))
        handed = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
        expected = quaternion.from_matrix((left * handed) @ right)
    return expected
