"""Skeletons as they stand in USD, before units, axes and the transforms above them are applied."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from pxr import Sdf, Tf, Usd, UsdGeom, UsdSkel

from usdfoot.bridge.similarity import Similarity, fold_into_joints
from usdfoot.errors import SkeletonError
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.limits import Limits, check_limit
from usdfoot.model.skeleton import Skeleton
from usdfoot.readers.attributes import array_at, size_at
from usdfoot.readers.joints import parent_indices
from usdfoot.readers.stage import start_code
from usdfoot.readers.transform_faults import place_fault

__all__ = [
    "RawSkeleton",
    "StartTransforms",
    "check_skeletons",
    "fold_scales",
    "is_moving",
    "matrices_of",
    "read_joints",
    "read_skeleton",
    "skeleton_in",
    "split_matrices",
]

_logger = logging.getLogger(__name__)

_EVEN = 1e-3
"""Largest relative difference between the scales of a joint's axes that still counts as uniform."""


@dataclass(frozen=True, kw_only=True)
class RawSkeleton:
    """A UsdSkel Skeleton in its own space and units, joint scales folded into the translations."""

    path: str
    """Prim path."""
    joints: tuple[str, ...]
    """Joint paths, J of them."""
    parents: IntArray
    """Index of each joint's parent, -1 for roots, shape (J,)."""
    translations: FloatArray
    """Rest, joint-local, as if no joint had a scale, shape (J, 3)."""
    rotations: FloatArray
    """Rest, joint-local, xyzw, shape (J, 4)."""
    scales: FloatArray
    """Rest, joint-local, as authored, shape (J, 3)."""
    inherited_scales: FloatArray
    """Product of the uniform scales of all joints above, shape (J,)."""
    bind_matrices: FloatArray | None
    """Bind transforms in skeleton space (row vectors), shape (J, 4, 4); None if they say nothing."""


def read_skeleton(prim: Usd.Prim) -> RawSkeleton:
    """Joints and rest pose of a Skeleton; without a rest pose, or with all joints of it on one spot, the bind pose.

    Raises:
        SkeletonError: If joints are missing, listed twice or after their children, or there is no usable pose.
    """
    skeleton = UsdSkel.Skeleton(prim)
    joints = read_joints(prim)
    if not joints:
        raise SkeletonError(prim.GetPath(), "has no joints", "author the joints attribute of the Skeleton")
    _check_unique(prim, joints)
    _warn_of_names(prim, joints)
    parents = parent_indices(joints)
    bind = _matrices(skeleton.GetBindTransformsAttr(), joints)
    rest = _matrices(skeleton.GetRestTransformsAttr(), joints)
    why = "are not authored for every joint"
    if rest is not None and bind is not None and (parents >= 0).any() and not rest[parents >= 0, 3, :3].any():
        rest, why = None, "put all joints on one spot"
    if rest is None:
        if bind is None:
            raise SkeletonError(
                prim.GetPath(),
                f"has neither restTransforms nor bindTransforms for its {len(joints)} joints",
                "author restTransforms, one matrix a joint",
            )
        _logger.warning("%s: restTransforms %s, the bind pose is used", prim.GetPath(), why)
        try:
            rest = _joint_local(bind, parents)
        except np.linalg.LinAlgError:
            remedy = "author restTransforms, or bindTransforms that have one"
            raise SkeletonError(prim.GetPath(), "bindTransforms have no inverse", remedy) from None
    elif bind is None and (size := size_at(skeleton.GetBindTransformsAttr())):
        what = f"has {size} bindTransforms for its {len(joints)} joints, the rest pose is used"
        _logger.warning("%s: %s", prim.GetPath(), what)
    elif bind is not None and len(joints) > 1 and not np.ptp(bind[:, 3, :3], axis=0).any():
        _logger.warning("%s: bindTransforms put all joints on one spot, the rest pose is used", prim.GetPath())
        bind = None
    translations, rotations, scales = split_matrices(rest)
    folded, inherited = fold_scales(parents, translations[None], scales[None], where=prim.GetPath())
    if not inherited.all():
        flat = [joints[parent] for joint, parent in enumerate(parents) if not inherited[joint]]
        remedy = "author scales other than zero for joints that have others below them"
        raise SkeletonError(prim.GetPath(), "restTransforms shrink joints to nothing", remedy, dict.fromkeys(flat))
    return RawSkeleton(
        path=str(prim.GetPath()),
        joints=joints,
        parents=parents,
        translations=folded[0],
        rotations=rotations,
        scales=scales,
        inherited_scales=inherited,
        bind_matrices=bind,
    )


def read_joints(prim: Usd.Prim) -> tuple[str, ...]:
    """Joint paths of a Skeleton or SkelAnimation.

    Raises:
        SkeletonError: If they are no text.
    """
    return tuple(map(str, array_at(prim.GetAttribute(str(UsdSkel.Tokens.joints)), error=SkeletonError)))


def skeleton_in(raw: RawSkeleton, similarity: Similarity) -> Skeleton:
    """The skeleton seen in the target space of a similarity, at its first sample."""
    first = Similarity(scale=similarity.scale, rotation=similarity.rotation[:1], translation=similarity.translation[:1])
    translations, rotations = fold_into_joints(
        first, raw.parents, translations=raw.translations[None], rotations=raw.rotations[None]
    )
    return Skeleton(
        name=raw.path,
        joints=raw.joints,
        parents=raw.parents,
        rest_translations=translations[0],
        rest_rotations=rotations[0],
    )


def fold_scales(
    parents: IntArray, translations: FloatArray, scales: FloatArray, *, where: object
) -> tuple[FloatArray, FloatArray]:
    """Translations as if no joint had a scale, for joint scales that are uniform and constant.

    A scale of a joint multiplies the translations of all joints below it. Scales that differ between axes or change
    over time cannot be expressed; they count as their mean and are logged where a joint hangs below.

    Args:
        parents: Index of each joint's parent, -1 for roots, shape (J,).
        translations: Joint-local, shape (T, J, 3).
        scales: Joint-local, shape (S, J, 3).
        where: Prim, for the log.

    Returns:
        Translations (T, J, 3) and the product of the scales above each joint (J,).
    """
    uniform = scales.mean(axis=(0, 2))
    spread = np.abs(scales - uniform[:, None]).max(axis=(0, 2))
    has_child = np.isin(np.arange(len(parents)), parents)
    uneven = has_child & (spread > _EVEN * np.abs(uniform))
    if uneven.any():
        _logger.warning(
            "%s: scales of %d joint(s) differ between axes or over time; bones keep their length, the mean is used",
            where,
            int(uneven.sum()),
        )
    inherited = np.ones(len(parents))
    for joint, parent in enumerate(parents):
        if 0 <= parent < joint:
            inherited[joint] = inherited[parent] * uniform[parent]
    inherited[np.abs(inherited - 1.0) < 1e-5] = 1.0
    return translations * inherited[:, None], inherited


def split_matrices(matrices: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Translations (J, 3), rotations xyzw (J, 4) and scales (J, 3) of matrices (J, 4, 4), row vectors, scale first."""
    linear = matrices[:, :3, :3]
    scales = np.linalg.norm(linear, axis=-1)
    axes = linear / np.where(scales > 0.0, scales, 1.0)[..., None]
    mirrored = np.linalg.det(axes) < 0.0
    scales = np.where(mirrored[:, None], -scales, scales)
    axes = np.where(mirrored[:, None, None], -axes, axes)
    rotations = quaternion.from_matrix(np.swapaxes(axes, -1, -2))
    return np.array(matrices[:, 3, :3], dtype=float), rotations, scales


def matrices_of(prim: Usd.Prim, codes: FloatArray) -> FloatArray:
    """Local-to-world matrices (row vectors) of a prim at time codes (K,), shape (K, 4, 4).

    Raises:
        SceneError: If USD cannot compute them.
    """
    cache = UsdGeom.XformCache()
    matrices = []
    try:
        for code in codes:
            cache.SetTime(Usd.TimeCode(float(code)))
            matrices.append(np.array(cache.GetLocalToWorldTransform(prim)))
    except Tf.ErrorException as error:
        raise place_fault(prim, error) from error
    return np.stack(matrices)


def is_moving(prim: Usd.Prim, below: Usd.Prim | None = None) -> bool:
    """Whether a transform on the prim or above it changes over time, up to but without the prim `below` which it is."""
    while prim and not prim.IsPseudoRoot() and prim != below:
        if _moves(prim):
            return True
        prim = prim.GetParent()
    return False


def _moves(prim: Usd.Prim) -> bool:
    """Whether the prim's own transform changes over time."""
    xformable = UsdGeom.Xformable(prim)
    try:
        return bool(xformable) and xformable.TransformMightBeTimeVarying()
    except Tf.ErrorException as error:
        raise place_fault(prim, error) from error


class StartPlace(NamedTuple):
    """Where a prim is at its stage's start."""

    matrix: FloatArray
    """Local-to-world matrix (row vectors), shape (4, 4)."""
    is_moving: bool
    """Whether a transform on it or above it changes over time."""


class StartTransforms:
    """Where many prims of a stage are at its start; what is above them is looked at once. The stage must stay as it is.

    Args:
        stage: Open stage.
    """

    def __init__(self, stage: Usd.Stage) -> None:
        self._cache = UsdGeom.XformCache(start_code(stage))
        self._moving: dict[Sdf.Path, bool] = {}
        self._places: dict[Sdf.Path, StartPlace] = {}

    def place_of(self, prim: Usd.Prim) -> StartPlace:
        """Where a prim is that many may ask about, as one above them."""
        path = prim.GetPath()
        place = self._places.get(path)
        if place is None:
            place = self._places[path] = StartPlace(self.matrix_of(prim), self.is_moving(prim))
        return place

    def matrix_of(self, prim: Usd.Prim) -> FloatArray:
        """Local-to-world matrix (row vectors) of a prim, shape (4, 4).

        Raises:
            SceneError: If USD cannot compute it.
        """
        try:
            return np.array(self._cache.GetLocalToWorldTransform(prim))
        except Tf.ErrorException as error:
            self._cache.Clear()  # or it would say next time that the prim is at the origin
            raise place_fault(prim, error) from error

    def is_moving(self, prim: Usd.Prim) -> bool:
        """Whether a transform on the prim or above it changes over time."""
        if not prim or prim.IsPseudoRoot():
            return False
        path = prim.GetPath()
        if path not in self._moving:
            self._moving[path] = self.is_moving(prim.GetParent()) or _moves(prim)
        return self._moving[path]


def _matrices(attribute: Usd.Attribute, joints: Sequence[str]) -> FloatArray | None:
    """One matrix a joint, shape (J, 4, 4); None if there are not as many.

    Raises:
        SkeletonError: If they are no matrices, or one has values that are not finite.
    """
    matrices = np.array(array_at(attribute, error=SkeletonError), dtype=float)
    if matrices.shape != (len(joints), 4, 4):
        return None
    broken = np.flatnonzero(~np.isfinite(matrices).all(axis=(1, 2)))
    if len(broken):
        what = f"{attribute.GetName()} are not finite"
        raise SkeletonError(attribute.GetPrimPath(), what, "author numbers", [joints[int(i)] for i in broken])
    return matrices


def _joint_local(matrices: FloatArray, parents: IntArray) -> FloatArray:
    """Joint-local matrices of matrices in skeleton space."""
    local = matrices.copy()
    for joint, parent in enumerate(parents):
        if parent >= 0:
            local[joint] = matrices[joint] @ np.linalg.inv(matrices[parent])
    return local


def _check_unique(prim: Usd.Prim, joints: tuple[str, ...]) -> None:
    twice = sorted({joint for joint in joints if joints.count(joint) > 1})
    if twice:
        raise SkeletonError(prim.GetPath(), "lists joints twice", "every joint path must be unique", twice)


def _warn_of_names(prim: Usd.Prim, joints: tuple[str, ...]) -> None:
    """Say so if USD itself cannot tell which joint is below which."""
    wrong = [joint for joint in joints if not Sdf.Path.IsValidPathString(joint)]
    if wrong:
        _logger.warning(
            "%s: %d joint name(s) are no USD paths, so other programs see these joints unconnected; write %s as %s",
            prim.GetPath(),
            len(wrong),
            wrong[0],
            "/".join(Tf.MakeValidIdentifier(name) for name in wrong[0].split("/")),
        )


def check_skeletons(skeletons: Sequence[Usd.Prim], limits: Limits) -> None:
    """Raises SceneError if a skeleton has too many joints."""
    for prim in skeletons:
        count = size_at(UsdSkel.Skeleton(prim).GetJointsAttr())
        check_limit(prim.GetPath(), "joints", count, limit=limits.joints)
