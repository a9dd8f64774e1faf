"""Where the joints of a written agent are, as UsdSkel sees them: what other clients are compared with."""

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel


def joint_positions(crowd_file, agent, code):
    """Positions of the joints in the stage's world by leaf name, at a time code."""
    stage = Usd.Stage.Open(str(crowd_file))
    root = UsdSkel.Root(stage.GetPrimAtPath(f"/Crowd/Agents/{agent}"))
    cache = UsdSkel.Cache()
    cache.Populate(root, Usd.TraverseInstanceProxies())
    below = Usd.PrimRange(root.GetPrim(), Usd.TraverseInstanceProxies())
    skeleton = next(prim for prim in below if prim.IsA(UsdSkel.Skeleton))
    query = cache.GetSkelQuery(UsdSkel.Skeleton(skeleton))
    above = UsdGeom.XformCache(Usd.TimeCode(code)).GetLocalToWorldTransform(skeleton)
    matrices = query.ComputeJointSkelTransforms(Usd.TimeCode(code))
    names = [str(joint).rsplit("/", 1)[-1] for joint in query.GetJointOrder()]
    return {name: np.array((matrix * above).ExtractTranslation()) for name, matrix in zip(names, matrices, strict=True)}
