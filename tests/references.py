"""Slow, obvious, independent answers that tests compare with."""

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel


def usdskel_positions(stage: Usd.Stage, skeleton: Usd.Prim, animation: Usd.Prim | None, codes) -> np.ndarray:
    """Joint positions in the stage's world as UsdSkel computes them, shape (T, J, 3).

    The skeleton is bound to the animation in the session layer of the stage, which is put back afterwards.
    """
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        if animation is not None:
            binding = UsdSkel.BindingAPI.Apply(skeleton)
            binding.CreateAnimationSourceRel().SetTargets([animation.GetPath()])
        query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(skeleton))
        positions = []
        for code in codes:
            time = Usd.TimeCode(float(code))
            to_world = UsdGeom.XformCache(time).GetLocalToWorldTransform(skeleton)
            joints = query.ComputeJointSkelTransforms(time)
            positions.append([tuple((joint * to_world).ExtractTranslation()) for joint in joints])
        stage.GetSessionLayer().Clear()
    return np.array(positions)


def canonical_points(stage: Usd.Stage, points) -> np.ndarray:
    """Points of a stage's world in metres, +Y up."""
    points = np.asarray(points, dtype=float) * UsdGeom.GetStageMetersPerUnit(stage)
    if UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y:
        return points
    return np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1)
