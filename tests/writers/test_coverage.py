"""Coverage as a stage: what a viewer shows is what was found."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Usd, UsdGeom, UsdValidation

from usdfoot.bridge.units import StageUnits
from usdfoot.model.coverage import EmptyCircle, SpaceCoverage
from usdfoot.writers.coverage import write_coverage

LANDINGS = np.array([[0.1, 0.2], [0.3, 0.2], [0.2, 0.7], [0.2, 0.4]])
TRIANGLES = np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3]])


def space(side=0, **changes):
    mirrored = LANDINGS * ([1.0, 1.0] if side == 0 else [-1.0, 1.0])
    values = {
        "skeleton": "/Rig/Skeleton",
        "style": "default",
        "flight": False,
        "side": side,
        "steps": 4,
        "landings": mirrored,
        "triangles": TRIANGLES,
        "hull": np.array([[0, 1], [1, 2], [0, 2]]),
        "errors": np.array([0.0, 0.05, np.nan, 0.1]),
        "empty_circles": (EmptyCircle(place=mirrored[3], radius=0.2, inside=True, expected_error=0.1),),
    }
    return SpaceCoverage(**{**values, **changes})


@pytest.mark.parametrize(
    "units", [StageUnits(meters_per_unit=0.01, up_axis="Y"), StageUnits(meters_per_unit=1.0, up_axis="Z")]
)
@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
def test_what_is_shown_is_what_was_found(tmp_path, units, suffix):
    file = write_coverage(
        tmp_path / f"coverage{suffix}",
        [space(0), space(1), space(0, flight=True)],
        units=units,
        sources=[],
        provenance={},
    )
    stage = Usd.Stage.Open(str(file))
    assert UsdGeom.GetStageUpAxis(stage) == units.up_axis
    group = stage.GetDefaultPrim().GetChild("Rig_default_ground")
    for side, name in enumerate(("Left", "Right")):
        mesh = UsdGeom.Mesh(group.GetChild(name).GetChild("Landings"))
        points = units.points_to_canonical(np.array(mesh.GetPointsAttr().Get()))
        assert_allclose(points[:, 1], 0.0, atol=1e-7)
        assert_allclose(points[:, [0, 2]], space(side).landings, atol=1e-6)
        corners = points[np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert np.all(normals[:, 1] > 0.0)  # seen from above
        primvars = UsdGeom.PrimvarsAPI(mesh)
        error = primvars.GetPrimvar("usdfoot:expectedError")
        assert error.GetInterpolation() == "vertex"
        expected = np.array([0.0, 0.05, -units.meters_per_unit, 0.1]) / units.meters_per_unit
        assert_allclose(error.Get(), expected, atol=1e-6)
        colours = np.array(primvars.GetPrimvar("displayColor").Get())
        light = colours @ [0.2126, 0.7152, 0.0722]
        assert light[0] < light[1] < light[3] and np.ptp(colours[2]) == 0.0
        hull = UsdGeom.BasisCurves(group.GetChild(name).GetChild("Hull"))
        assert list(hull.GetCurveVertexCountsAttr().Get()) == [2, 2, 2]
        hole = UsdGeom.BasisCurves(group.GetChild(name).GetChild("EmptyCircles"))
        ring = units.points_to_canonical(np.array(hole.GetPointsAttr().Get()))[:, [0, 2]]
        assert_allclose(np.linalg.norm(ring - space(side).empty_circles[0].place, axis=1), 0.2, atol=1e-6)
    boxes = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"])
    ranges = [boxes.ComputeWorldBound(child).ComputeAlignedRange() for child in stage.GetDefaultPrim().GetChildren()]
    assert len(ranges) == 2 and (ranges[0].GetMin()[0] > ranges[1].GetMax()[0])  # side by side
    validators = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    assert [error.GetMessage() for error in validators.Validate(stage)] == []


def test_landings_on_a_line_are_points(tmp_path):
    bare = space(triangles=np.empty((0, 3), dtype=int), hull=np.array([[0, 1]]), empty_circles=())
    file = write_coverage(tmp_path / "line.usda", [bare], units=StageUnits(), sources=[], provenance={})
    stage = Usd.Stage.Open(str(file))
    foot = stage.GetPrimAtPath("/Coverage/Rig_default_ground/Left")
    assert foot.GetChild("Landings").GetTypeName() == "Points" and not foot.GetChild("EmptyCircles")
