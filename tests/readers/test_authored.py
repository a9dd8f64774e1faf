"""What is authored on a prim, and nothing else."""

from pxr import UsdGeom

from tests.scenes import new_stage
from usdfoot.readers.authored import authored


def test_only_authored_values_count():
    stage = new_stage()
    sphere = UsdGeom.Sphere.Define(stage, "/World/Ball")
    assert authored(sphere.GetPrim(), "radius") is None
    assert authored(sphere.GetPrim(), "nothing") is None
    sphere.GetRadiusAttr().Set(2.0, 5.0)
    assert authored(sphere.GetPrim(), "radius") == 2.0
