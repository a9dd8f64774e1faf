"""What is missing above a clip's skeleton whose file has other units or another up axis than the scene."""

from __future__ import annotations

import logging
from dataclasses import replace

import numpy as np

from usdfoot.bridge.similarity import Similarity, fold_into_joints
from usdfoot.bridge.units import StageUnits
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton, forward_kinematics
from usdfoot.readers.joints import match_joints
from usdfoot.readers.skeleton import RawSkeleton, skeleton_in

__all__ = ["in_units_of", "stood_up"]

_logger = logging.getLogger(__name__)

_UNIT_MISMATCH = 5.0
"""Legs so many times longer or shorter than the character's are in other units, not of other proportions."""
_ALONG = 0.9
"""Legs whose direction has this cosine to another one go along it."""


def in_units_of(where: str, similarity: Similarity, own: Skeleton, *, skeleton: Skeleton, biped: Biped) -> Similarity:
    """The similarity, rescaled where the clip is evidently in other units than the character.

    Args:
        where: Prim of the clip, for the log.
        similarity: From the clip's skeleton to the canonical world.
        own: The clip's skeleton there.
        skeleton: The character's, canonical.
        biped: The character's.
    """
    if own.joints == skeleton.joints and np.allclose(own.rest_translations, skeleton.rest_translations, atol=1e-6):
        return similarity
    clip_leg = _leg_length(own, match_joints(own.joints, skeleton.joints), biped)
    leg = _leg_length(skeleton, np.arange(len(skeleton.joints)), biped)
    if not (leg > 0.0 and clip_leg > 0.0) or 1.0 / _UNIT_MISMATCH < clip_leg / leg < _UNIT_MISMATCH:
        return similarity
    ratio = clip_leg / leg
    _logger.warning(
        "%s: legs are %.3g times as long as those of %s, the clip is scaled to fit; a scale for other units is missing",
        where,
        ratio,
        skeleton.name,
    )
    return replace(similarity, scale=similarity.scale / ratio, translation=similarity.translation / ratio)


def stood_up(
    where: str,
    similarity: Similarity,
    raw: RawSkeleton,
    *,
    poses: tuple[FloatArray, FloatArray],
    skeleton: Skeleton,
    biped: Biped,
    units: StageUnits,
) -> Similarity:
    """The similarity, turned upright where the clip lies as one of a stage with the other up axis does.

    Its legs must point where they would then, at rest and on average of the samples, and the character's must not.

    Args:
        where: Prim of the clip, for the log.
        similarity: From the clip's skeleton to the canonical world.
        raw: The clip's skeleton.
        poses: Joint-local translations (T, J, 3) and rotations (T, J, 4) of the samples, skeleton units.
        skeleton: The character's, canonical.
        biped: The character's.
        units: Of the stage.
    """
    to_canonical = replace(units, up_axis="Z").axes_to_canonical
    turn = quaternion.inverse(to_canonical) if units.up_axis == "Z" else to_canonical
    lying = quaternion.rotate(quaternion.inverse(turn), np.array([0.0, -1.0, 0.0]))
    own, order = skeleton_in(raw, similarity), match_joints(raw.joints, skeleton.joints)
    rest = _legs_down(own.parents, (own.rest_translations[None], own.rest_rotations[None]), order, biped)
    if rest @ lying < _ALONG:
        return similarity
    moved = _legs_down(
        own.parents, fold_into_joints(similarity, own.parents, translations=poses[0], rotations=poses[1]), order, biped
    )
    character = _legs_down(
        skeleton.parents,
        (skeleton.rest_translations[None], skeleton.rest_rotations[None]),
        np.arange(len(skeleton.joints)),
        biped,
    )
    if moved @ lying < _ALONG or character @ lying > _ALONG:
        return similarity
    _logger.warning(
        "%s: its legs do not point down, as its file has another up axis than the scene; it is turned upright. "
        "rotate the prim above it by 90 degrees about X",
        where,
    )
    return replace(
        similarity,
        rotation=quaternion.compose(turn, similarity.rotation),
        translation=quaternion.rotate(turn, similarity.translation),
    )


def _legs_down(parents: IntArray, poses: tuple[FloatArray, FloatArray], order: IntArray, biped: Biped) -> FloatArray:
    """Direction from hips to ankles on average of poses (T, J, 3) and (T, J, 4), unit or zero, shape (3,).

    The order leads from the biped's joints to those of the poses.
    """
    positions, _ = forward_kinematics(parents, *poses)
    legs = (positions[:, order[list(biped.ankles)]] - positions[:, order[list(biped.hips)]]).mean(axis=(0, 1))
    return np.asarray(legs / max(float(np.linalg.norm(legs)), np.finfo(float).tiny))


def _leg_length(skeleton: Skeleton, order: IntArray, biped: Biped) -> float:
    """Mean length of thigh and shin together at rest; the order leads from the biped's joints to the skeleton's."""
    positions, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    legs = positions[order[[biped.hips, biped.knees, biped.ankles]]]  # (3, 2, 3)
    return float(np.linalg.norm(np.diff(legs, axis=0), axis=-1).sum(axis=0).mean())
