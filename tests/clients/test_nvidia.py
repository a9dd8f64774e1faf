"""NVIDIA's usd-validation-nvidia finds nothing wrong with what is written."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdSkel

nvidia = pytest.importorskip("usd_validation_nvidia", reason="no NVIDIA validation: pip install usd-validation-nvidia")


@pytest.mark.parametrize("name", ["crowd.usd", "crowd.expanded.usda"])
def test_no_rule_fails(stones, name):
    issues = nvidia.ValidationEngine().validate(str(stones.crowd_file.with_name(name))).issues()
    failures = [
        (issue.rule.__name__, issue.message) for issue in issues if issue.severity != nvidia.IssueSeverity.WARNING
    ]
    assert failures == []


def test_the_skin_stays_within_the_extent_but_for_half_a_percent(stones):
    stage = Usd.Stage.Open(str(stones.crowd_file))
    root = UsdSkel.Root(stage.GetPrimAtPath("/Crowd/Agents/Walker"))
    cache = UsdSkel.Cache()
    cache.Populate(root, Usd.TraverseInstanceProxies())
    (binding,) = cache.ComputeSkelBindings(root, Usd.TraverseInstanceProxies())
    skeleton = cache.GetSkelQuery(binding.GetSkeleton())
    for code in (0.0, 61.0, 200.0, 333.0):
        low, high = np.array(root.GetExtentAttr().Get(code), dtype=float)
        xforms = UsdGeom.XformCache(code)
        to_agent = xforms.GetLocalToWorldTransform(binding.GetSkeleton().GetPrim()) * (
            xforms.GetLocalToWorldTransform(root.GetPrim()).GetInverse()
        )
        matrices = skeleton.ComputeSkinningTransforms(code)
        for target in binding.GetSkinningTargets():
            points = UsdGeom.PointBased(target.GetPrim()).GetPointsAttr().Get()
            assert target.ComputeSkinnedPoints(matrices, points, code)
            corners = np.array([to_agent.Transform(point) for point in points])
            room = 0.005 * (high[1] - low[1])
            assert (corners >= low - room).all() and (corners <= high + room).all(), target.GetPrim().GetPath()
