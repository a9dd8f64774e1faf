"""Skeleton: a hierarchy of joints with a rest pose; Pose: where the joints of one are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.errors import SkeletonError
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["Pose", "Skeleton", "forward_kinematics"]


@dataclass(frozen=True, kw_only=True)
class Skeleton:
    """Joints in the order of the character's USD Skeleton, parents before children.

    Raises:
        SkeletonError: If arrays disagree in length or a parent comes after its child.
    """

    name: str
    """Prim path of the Skeleton, for messages."""
    joints: tuple[str, ...]
    """Full joint paths, J of them."""
    parents: IntArray
    """Index of each joint's parent, -1 for roots, shape (J,)."""
    rest_translations: FloatArray
    """Joint-local rest translations [m], shape (J, 3)."""
    rest_rotations: FloatArray
    """Joint-local rest rotations, unit xyzw, shape (J, 4)."""

    def __post_init__(self) -> None:
        count = len(self.joints)
        if count == 0:
            raise SkeletonError(self.name, "has no joints", "author the joints attribute")
        shapes = (self.parents.shape, self.rest_translations.shape, self.rest_rotations.shape)
        if shapes != ((count,), (count, 3), (count, 4)):
            what = f"has {count} joints but arrays of shapes {shapes}"
            raise SkeletonError(self.name, what, "give one parent, translation and rotation a joint")
        late = np.flatnonzero(self.parents >= np.arange(count))
        if late.size:
            raise SkeletonError(
                self.name,
                "joints listed before their parents",
                "order parents first",
                [self.joints[i] for i in late],
            )

    def ancestors(self, joint: int) -> list[int]:
        """Joints above a joint, the nearest first."""
        above = []
        while self.parents[joint] >= 0:
            joint = int(self.parents[joint])
            above.append(joint)
        return above

    def chain(self, ancestor: int, joint: int) -> tuple[int, ...]:
        """Joint indices on the way down from `ancestor` to `joint`, both included.

        Raises:
            SkeletonError: If `joint` is not below `ancestor`.
        """
        way = [joint]
        while way[-1] != ancestor:
            parent = int(self.parents[way[-1]])
            if parent < 0:
                what = f"{self.joints[joint]} is not below {self.joints[ancestor]}"
                raise SkeletonError(self.name, what, "name joints of one chain, from the hip down")
            way.append(parent)
        return tuple(reversed(way))


@dataclass(frozen=True, kw_only=True)
class Pose:
    """One pose of a skeleton in its own space."""

    places: FloatArray
    """Joint positions [m], shape (J, 3)."""
    turns: FloatArray
    """Joint rotations, shape (J, 4)."""


def forward_kinematics(
    parents: IntArray, translations: FloatArray, rotations: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Joint positions and rotations in skeleton space from joint-local ones.

    Args:
        parents: Index of each joint's parent, -1 for roots, parents first, shape (J,).
        translations: Joint-local translations [m], shape (..., J, 3).
        rotations: Joint-local unit quaternions xyzw, shape (..., J, 4).

    Returns:
        Positions [m] (..., J, 3) and rotations (..., J, 4) in skeleton space.
    """
    translations = np.broadcast_to(translations, (*rotations.shape[:-1], 3))
    positions_skel = np.array(translations, dtype=float)
    rotations_skel = np.array(rotations, dtype=float)
    for joints in _generations(parents)[1:]:
        above = rotations_skel[..., parents[joints], :]
        turned = quaternion.rotate(above, translations[..., joints, :])
        positions_skel[..., joints, :] = positions_skel[..., parents[joints], :] + turned
        rotations_skel[..., joints, :] = quaternion.compose(above, rotations[..., joints, :])
    return positions_skel, rotations_skel


def _generations(parents: IntArray) -> list[list[int]]:
    """Joints with 0, 1, 2 ... joints above them."""
    depths: list[int] = []
    for parent in parents.tolist():
        depths.append(depths[parent] + 1 if parent >= 0 else 0)
    generations: list[list[int]] = [[] for _ in range(max(depths, default=0) + 1)]
    for joint, depth in enumerate(depths):
        generations[depth].append(joint)
    return generations
