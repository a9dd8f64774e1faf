"""What is counted of a stage before it is read, against the limits."""

from __future__ import annotations

from collections.abc import Sequence

from pxr import Usd, UsdGeom, UsdSkel

from usdfoot.model.limits import Limits, check_limit

__all__ = ["check_meshes", "check_skeletons"]


def check_skeletons(skeletons: Sequence[Usd.Prim], limits: Limits) -> None:
    """Raises SceneError if a skeleton has too many joints."""
    for prim in skeletons:
        joints = UsdSkel.Skeleton(prim).GetJointsAttr().Get() or ()
        check_limit(prim.GetPath(), "joints", len(joints), limits.joints)


def check_meshes(meshes: Sequence[Usd.Prim], limits: Limits) -> None:
    """Raises SceneError if meshes have too many triangles together; a face of n corners has n - 2 at most."""
    count = 0
    for prim in meshes:
        mesh = UsdGeom.Mesh(prim)
        corners = mesh.GetFaceVertexIndicesAttr().Get(Usd.TimeCode.EarliestTime()) or ()
        faces = mesh.GetFaceVertexCountsAttr().Get(Usd.TimeCode.EarliestTime()) or ()
        count += max(0, len(corners) - 2 * len(faces))
        check_limit(prim.GetPath(), "triangles", count, limits.triangles)
