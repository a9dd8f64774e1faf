"""Mirror images: the left/right reflection of clips for rigs with any orientation of joints.

Let S reflect in the plane x = 0. Each joint j takes the mirror image of its partner p(j), the joint of the other side
or itself in the middle: its rotation in the world becomes S R_p S C with a constant C for the difference between the
local axes of the two. In joint-local terms, with C' of the parent: q_j = C'^-1 (S q_p S) C, t_j = C'^-1 S t_p.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.axes import best_turn
from usdfoot.analysis.joint_pairs import joint_pairs
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton

__all__ = ["REFLECTION", "SAME_SHAPE", "MirrorMap", "mirror_map", "mirrored_rotations"]

REFLECTION = np.array([-1.0, 1.0, 1.0])
CONTRADICTION = 0.2
"""Angle between what rest rotations and children say from which on the rest pose is not believed [rad]."""
SQUARE_MISFIT = 0.12
"""How far it may miss the children, relative to their distance."""
SQUARE_ANGLE = 0.7
"""How far a quarter turn of the axes may be from the relation it replaces [rad]."""
SAME_SHAPE = 0.01
"""Children that a turn brings this near their images, relative to their distance, are mirror images of each other."""


@dataclass(frozen=True, kw_only=True)
class MirrorMap:
    """How joints exchange their motion in the mirror image."""

    partners: IntArray
    """Joint whose mirror image each joint takes, shape (J,)."""
    relations: FloatArray
    """Constant C of each joint, xyzw, shape (J, 4)."""
    parent_inverses: FloatArray
    """Inverse of the parent's C, the identity for roots, xyzw, shape (J, 4)."""


def mirror_map(skeleton: Skeleton, biped: Biped) -> MirrorMap:
    """Partners and relations of a skeleton's joints.

    The relation follows from the children: C must turn each child's rest translation onto the mirror image of its
    partner's. Where that leaves a turn free (one child or none), the rest rotations decide, from the parent's relation
    on. If they contradict the children somewhere, the rest pose is a frame of some animation; then a quarter turn of
    the axes near the relation, as rigging programs make them, is preferred to it.
    """
    partners = joint_pairs(skeleton, biped)
    mirror, contradiction = _related(skeleton, partners, square=False)
    return _related(skeleton, partners, square=True)[0] if contradiction > CONTRADICTION else mirror


def _related(skeleton: Skeleton, partners: IntArray, *, square: bool) -> tuple[MirrorMap, float]:
    """Relations of all joints, and the largest angle [rad] between what rest rotations and children say."""
    relations = np.tile([0.0, 0.0, 0.0, 1.0], (len(partners), 1))
    inverses = relations.copy()
    contradiction = 0.0
    for joint, parent in enumerate(skeleton.parents):
        if parent >= 0:
            inverses[joint] = quaternion.inverse(relations[parent])
        image = quaternion.mirror_x(skeleton.rest_rotations[partners[joint]])
        own = quaternion.compose(quaternion.inverse(inverses[joint]), skeleton.rest_rotations[joint])
        expected = quaternion.compose(quaternion.inverse(image), own)
        children = np.flatnonzero(skeleton.parents == joint)
        # What hangs on one side only, as a holster does, has no image on the other.
        children = children[skeleton.parents[partners[children]] == partners[joint]]
        offsets = skeleton.rest_translations[children]
        images = skeleton.rest_translations[partners[children]] * REFLECTION
        relations[joint] = best_turn(offsets, images, expected)
        between = quaternion.compose(quaternion.inverse(expected), relations[joint])
        contradiction = max(contradiction, float(np.linalg.norm(quaternion.to_rotation_vector(between))))
        if square:
            relations[joint] = _squared(offsets, images, relations[joint])
    return MirrorMap(partners=partners, relations=relations, parent_inverses=inverses), contradiction


def _squared(offsets: FloatArray, images: FloatArray, relation: FloatArray) -> FloatArray:
    """The rotation of axes onto axes nearest to a relation (4,), or that itself if the children or the angle forbid.

    It is turned on by as little as brings the children exactly onto their images, where they can be: axes drawn by hand
    are rarely square to the last digit.
    """
    matrix = quaternion.to_matrix(relation)
    axes = np.where(np.abs(matrix) > np.cos(SQUARE_ANGLE), np.sign(matrix), 0.0)
    is_rotation = np.allclose(axes @ axes.T, np.eye(3)) and np.linalg.det(axes) > 0.0
    size = float(np.linalg.norm(offsets))
    if not is_rotation or np.linalg.norm(images - offsets @ axes.T) > SQUARE_MISFIT * size + 1e-9:
        return relation
    turned = best_turn(offsets, images, quaternion.from_matrix(axes))
    same = np.linalg.norm(images - quaternion.rotate(turned, offsets)) <= SAME_SHAPE * size
    return turned if same else quaternion.from_matrix(axes)


def mirrored_rotations(rotations: FloatArray, mirror: MirrorMap) -> FloatArray:
    """Mirror image of joint-local rotations (..., J, 4)."""
    images = quaternion.mirror_x(rotations[..., mirror.partners, :])
    return quaternion.compose(mirror.parent_inverses, quaternion.compose(images, mirror.relations))
