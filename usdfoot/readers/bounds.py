"""What USD bounds a skinned character by: its joints, padded by how far the skin reaches beyond them at rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdSkel, Vt

from usdfoot.bridge.scene import SkinBound, Variants
from usdfoot.bridge.variants import select_variants
from usdfoot.errors import SkeletonError
from usdfoot.maths.types import FloatArray
from usdfoot.readers.joints import parent_indices

__all__ = ["read_bounds"]


def read_bounds(
    asset: str, asset_prim: str, *, variants: Variants = (), skeleton_path: str, joints: Sequence[str]
) -> tuple[SkinBound, ...]:
    """What bounds an agent that references a character, one entry for each Skeleton with skin.

    The character is composed below a SkelRoot, as written agents are. Without any skin its own Skeleton counts alone.

    Args:
        asset: Layer of the character.
        asset_prim: Its prim there.
        variants: What is selected of it.
        skeleton_path: Of its Skeleton relative to the prim, "" if it is the prim.
        joints: Of the animation the agent will have.

    Raises:
        SkeletonError: If its Skeleton does not come along with it.
    """
    stage = Usd.Stage.CreateInMemory()
    root = UsdSkel.Root.Define(stage, "/Agent")
    UsdSkel.BindingAPI.Apply(root.GetPrim())
    root.GetPrim().GetReferences().AddReference(asset, asset_prim)
    select_variants(stage.GetRootLayer().GetPrimAtPath("/Agent"), variants)
    _complete(root.GetPrim())
    cache = UsdSkel.Cache()
    cache.Populate(root, Usd.TraverseInstanceProxies())
    bound = []
    for binding in cache.ComputeSkelBindings(root, Usd.TraverseInstanceProxies()):
        query = cache.GetSkelQuery(binding.GetSkeleton())
        rest = query.ComputeJointSkelTransforms(Usd.TimeCode.Default(), True) if query else None
        if rest:
            padding = max((_padding(rest, target) for target in binding.GetSkinningTargets()), default=0.0)
            bound.append(_bound(binding.GetSkeleton(), root, joints, padding))
    if not bound and skeleton_path:
        skeleton = UsdSkel.Skeleton(root.GetPrim().GetPrimAtPath(skeleton_path))
        if not skeleton:
            what = f"has no Skeleton {skeleton_path} where agents reference it from {asset}"
            raise SkeletonError(asset_prim, what, "see that its references lead nowhere back to it")
        bound.append(_bound(skeleton, root, joints, 0.0))
    return tuple(bound)


def _complete(root: Usd.Prim) -> None:
    """Give Skeletons that lack the rest or bind pose the other, and no animation to any: USD would warn of all."""
    for prim in Usd.PrimRange(root):
        relationship = prim.GetRelationship("skel:animationSource")
        if relationship:
            relationship.SetTargets([])
        skeleton = UsdSkel.Skeleton(prim)
        if not skeleton:
            continue
        topology = UsdSkel.Topology(skeleton.GetJointsAttr().Get() or [])
        bind = skeleton.GetBindTransformsAttr().Get() or []
        rest = skeleton.GetRestTransformsAttr().Get() or []
        if len(rest) != len(topology) == len(bind):
            skeleton.CreateRestTransformsAttr(UsdSkel.ComputeJointLocalTransforms(topology, bind, Gf.Matrix4d(1.0)))
        elif len(bind) != len(topology) == len(rest):
            skeleton.CreateBindTransformsAttr(UsdSkel.ConcatJointTransforms(topology, rest, Gf.Matrix4d(1.0)))


def _bound(skeleton: UsdSkel.Skeleton, root: UsdSkel.Root, joints: Sequence[str], padding: float) -> SkinBound:
    own = [str(joint) for joint in skeleton.GetJointsAttr().Get()]
    rest = skeleton.GetRestTransformsAttr().Get()
    to_prim, _ = UsdGeom.XformCache().ComputeRelativeTransform(skeleton.GetPrim(), root.GetPrim())
    places = {joint: place for place, joint in enumerate(joints)}
    return SkinBound(
        parents=parent_indices(own),
        sources=np.array([places.get(joint, -1) for joint in own]),
        rest_matrices=np.array(rest) if rest and len(rest) == len(own) else np.tile(np.eye(4), (len(own), 1, 1)),
        to_prim=np.array(to_prim),
        padding=padding,
    )


def _padding(rest: Vt.Matrix4dArray, target: UsdSkel.SkinningQuery) -> float:
    """How far a skinned prim reaches beyond the joints at rest, which USD can say only of those with an `extent`."""
    boundable = UsdGeom.Boundable(target.GetPrim())
    if not boundable:
        return 0.0
    if boundable.GetExtentAttr().HasAuthoredValue():
        return float(target.ComputeExtentsPadding(rest, boundable))
    extent = UsdGeom.Boundable.ComputeExtentFromPlugins(boundable, Usd.TimeCode.EarliestTime())
    if not extent:
        return 0.0
    corners: FloatArray = np.stack(np.meshgrid(*np.array(extent, dtype=float).T, indexing="ij"), axis=-1).reshape(-1, 3)
    matrix = np.array(target.GetGeomBindTransform(Usd.TimeCode.EarliestTime()))
    corners = corners @ matrix[:3, :3] + matrix[3, :3]
    pivots = np.array(rest)[:, 3, :3]
    beyond = np.maximum(pivots.min(axis=0) - corners.min(axis=0), corners.max(axis=0) - pivots.max(axis=0))
    return max(0.0, float(beyond.max()))
