"""Skinned meshes of a character: their points in the bind pose and the joints that move them."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdSkel

from usdfoot.errors import SceneError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.readers.attributes import array_at, checked, value_at
from usdfoot.readers.joints import match_joints
from usdfoot.readers.skeleton import RawSkeleton

__all__ = ["Skin", "inherited_target", "points_moved_by", "read_skin"]

_logger = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Skin:
    """Points of all meshes bound to one skeleton, in its bind pose."""

    points: FloatArray
    """In skeleton space [skeleton units], shape (P, 3)."""
    joints: IntArray
    """Joints that move each point, -1 for unused entries, shape (P, K)."""
    weights: FloatArray
    """How much, shape (P, K)."""


def read_skin(meshes: Iterable[Usd.Prim], skeleton_prim: Usd.Prim, skeleton: RawSkeleton) -> Skin:
    """Points and influences of the meshes that are bound to the skeleton; malformed ones are left out."""
    parts = []
    for mesh in meshes:
        if inherited_target(mesh, "skel:skeleton") == skeleton_prim.GetPath():
            try:
                part = _read_mesh(mesh, skeleton)
            except SceneError as error:
                _logger.warning("%s. Until then it is left out", error)
                continue
            if part is not None:
                parts.append(part)
    width = max((part[1].shape[1] for part in parts), default=1)
    return Skin(
        points=np.concatenate([part[0] for part in parts] or [np.zeros((0, 3))]),
        joints=np.concatenate([_widen(part[1], width, -1) for part in parts] or [np.zeros((0, 1), dtype=int)]),
        weights=np.concatenate([_widen(part[2], width, 0.0) for part in parts] or [np.zeros((0, 1))]),
    )


def inherited_target(prim: Usd.Prim, name: str) -> Sdf.Path | None:
    """First target of a relationship on the prim or the nearest ancestor that authors it; None if that has none."""
    while prim and not prim.IsPseudoRoot():
        relationship = prim.GetRelationship(name)
        if relationship and relationship.HasAuthoredTargets():
            targets = relationship.GetForwardedTargets()
            return targets[0] if targets else None
        prim = prim.GetParent()
    return None


def points_moved_by(skin: Skin, joints: Sequence[int]) -> FloatArray:
    """Points that move more with the given joints than with all others [skeleton units], shape (P, 3)."""
    shares = np.where(np.isin(skin.joints, joints), skin.weights, 0.0).sum(axis=1)
    return skin.points[shares > 0.5 * skin.weights.sum(axis=1)]


def _read_mesh(mesh: Usd.Prim, skeleton: RawSkeleton) -> tuple[FloatArray, IntArray, FloatArray] | None:
    """Raises SceneError if an attribute is of another type than the schema's."""
    binding = UsdSkel.BindingAPI(mesh)
    points = np.array(array_at(UsdGeom.PointBased(mesh).GetPointsAttr(), Usd.TimeCode.EarliestTime()), dtype=float)
    indices_primvar = UsdGeom.PrimvarsAPI(mesh).FindPrimvarWithInheritance("skel:jointIndices")
    weights_primvar = UsdGeom.PrimvarsAPI(mesh).FindPrimvarWithInheritance("skel:jointWeights")
    if not len(points) or not indices_primvar or not weights_primvar:
        return None
    width = max(1, indices_primvar.GetElementSize())
    indices = np.array(_flattened(indices_primvar, Sdf.ValueTypeNames.IntArray), dtype=int)
    weights = np.array(_flattened(weights_primvar, Sdf.ValueTypeNames.FloatArray), dtype=float)
    if indices.shape != weights.shape or not indices.size or indices.size % width:
        return None
    indices, weights = indices.reshape(-1, width), weights.reshape(-1, width)
    if len(indices) == 1:
        indices, weights = np.repeat(indices, len(points), axis=0), np.repeat(weights, len(points), axis=0)
    if len(indices) != len(points):
        return None
    joints = _skeleton_joints(mesh, skeleton)
    valid = (indices >= 0) & (indices < len(joints))
    matrix = np.array(value_at(binding.GetGeomBindTransformAttr()) or np.eye(4), dtype=float)
    bound = points @ matrix[:3, :3] + matrix[3, :3]
    finite = np.isfinite(bound).all(axis=1)
    if not finite.all():
        _logger.warning("%s: %d of its points are not finite, they are left out", mesh.GetPath(), int((~finite).sum()))
    return bound[finite], np.where(valid, joints[np.where(valid, indices, 0)], -1)[finite], weights[finite]


def _flattened(primvar: UsdGeom.Primvar, expected: Sdf.ValueTypeName) -> Any:
    """Raises SceneError if the values are of another type than expected."""
    value = primvar.ComputeFlattened()
    return () if value is None else checked(primvar.GetAttr(), value, expected)


def _skeleton_joints(mesh: Usd.Prim, skeleton: RawSkeleton) -> IntArray:
    """Skeleton joint of each joint index of a mesh; a mesh may list joints of its own, itself or above it."""
    prim = mesh
    while prim and not prim.IsPseudoRoot():
        attribute = UsdSkel.BindingAPI(prim).GetJointsAttr()
        if attribute and attribute.HasAuthoredValue():
            return match_joints(skeleton.joints, [*map(str, array_at(attribute))])
        prim = prim.GetParent()
    return np.arange(len(skeleton.joints))


def _widen(values: np.ndarray, width: int, fill: float) -> np.ndarray:
    return np.pad(values, ((0, 0), (0, width - values.shape[1])), constant_values=fill)
