"""NVIDIA's usd-validation-nvidia finds nothing wrong with what is written."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdSkel

nvidia = pytest.importorskip("usd_validation_nvidia", reason="no NVIDIA validation: pip install usd-validation-nvidia")

EXTENTS = "ExtentsChecker"
"""Wants, to the last bit, the extent USD falls back on where none is authored. Ours bounds the skin of each joint."""


@pytest.mark.parametrize("name", ["crowd.usd", "crowd.expanded.usda"])
def test_no_rule_fails(stones, name):
    issues = nvidia.ValidationEngine().validate(str(stones.crowd_file.with_name(name))).issues()
    failures = [
        (issue.rule.__name__, issue.message) for issue in issues if issue.severity != nvidia.IssueSeverity.WARNING
    ]
    assert [failure for failure in failures if failure[0] != EXTENTS] == []
    agents = [message for rule, message in failures if rule == EXTENTS]
    assert len(agents) <= 1  # the agent's own; every other extent is right


def test_the_skinned_agent_stays_within_its_extent(stones):
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
            assert (corners >= low - 1e-4).all() and (corners <= high + 1e-4).all(), target.GetPrim().GetPath()
