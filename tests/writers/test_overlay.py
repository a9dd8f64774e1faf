"""Overlays in layers of any units and axes."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Usd, UsdGeom

from usdfoot.bridge.units import StageUnits
from usdfoot.maths import quaternion
from usdfoot.model.overlay import Lines, Marks, Overlay
from usdfoot.pipeline.overlay_shapes import bar
from usdfoot.writers.layers import LayerFormat
from usdfoot.writers.overlay import overlay_layer

UNITS = [
    StageUnits(meters_per_unit=1.0, up_axis="Y", time_codes_per_second=24.0),
    StageUnits(meters_per_unit=0.01, up_axis="Z", time_codes_per_second=30.0),
]
RISE, SIZE = 0.7, np.array([2.0, 0.5, 0.25])


def drawing():
    """A bar that rises, seen at the first two of three times, and a line."""
    marks = Marks(
        path="Errors/Blend",
        shapes=(bar("Bar", (1.0, 0.0, 0.0)),),
        times=np.array([0.0, 0.5, 1.0]),
        kinds=np.zeros((3, 1), dtype=int),
        positions=np.array([[[1.0, 0.0, 2.0]], [[1.0, RISE, 2.0]], [[1.0, RISE, 2.0]]]),
        orientations=np.tile(quaternion.yaw_quaternion(np.array(0.3)), (3, 1, 1)),
        scales=np.tile(SIZE, (3, 1, 1)),
        hidden=np.array([[False], [False], [True]]),
        agents=np.zeros(1, dtype=int),
        footsteps=np.zeros(1, dtype=int),
    )
    lines = Lines(
        path="Com",
        counts=np.array([2]),
        points=np.array([[0.0, 1.0, 0.0], [0.0, 1.0, 3.0]]),
        colors=np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        width=0.01,
        agents=np.zeros(1, dtype=int),
    )
    return Overlay(agents=("A",), marks=(marks,), lines=(lines,))


@pytest.fixture(params=UNITS, ids=["m Y 24", "cm Z 30"])
def written(request):
    units = request.param
    rates = LayerFormat(units=units, frames_per_second=24.0, start_code=0.0, end_code=100.0)
    return Usd.Stage.Open(overlay_layer(drawing(), rates)), units


def world_corners(stage, units, time):
    """Canonical corners of the only bar as USD places its instance."""
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath("/__usdfoot/Errors/Blend"))
    code = float(units.times_to_codes(np.array(time)))
    matrices = instancer.ComputeInstanceTransformsAtTime(code, code)
    points = np.array(UsdGeom.Mesh(stage.GetPrimAtPath("/__usdfoot/Errors/Blend/Shapes/Bar")).GetPointsAttr().Get())
    return [
        units.points_to_canonical(points @ np.array(matrix)[:3, :3] + np.array(matrix)[3, :3]) for matrix in matrices
    ]


@pytest.mark.parametrize(("time", "height"), [(0.0, 0.0), (0.25, 0.5 * RISE), (0.5, RISE)])
def test_instances_stand_in_the_world_where_they_were_put(written, time, height):
    stage, units = written
    (corners,) = world_corners(stage, units, time)
    turn = quaternion.yaw_quaternion(np.array(0.3))
    expected = quaternion.rotate(turn, bar("Bar", (0, 0, 0)).points * SIZE) + [1.0, height, 2.0]
    assert_allclose(corners, expected, atol=2e-3)  # orientations are half precision


@pytest.mark.parametrize(("time", "seen"), [(0.0, True), (0.9, True), (1.0, False)])
def test_hidden_instances_are_gone(written, time, seen):
    stage, units = written
    instancer = UsdGeom.PointInstancer(stage.GetPrimAtPath("/__usdfoot/Errors/Blend"))
    mask = instancer.ComputeMaskAtTime(float(units.times_to_codes(np.array(time))))
    assert (not mask or mask[0]) == seen  # an empty mask hides nothing


def test_extents_hold_everything_at_any_time(written):
    stage, units = written
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["guide"])
    box = cache.ComputeWorldBound(stage.GetPrimAtPath("/__usdfoot/Errors")).GetRange()
    for time in (0.0, 0.5):
        for corner in world_corners(stage, units, time)[0]:
            point = units.points_to_stage(corner).tolist()
            assert all(
                low - 0.2 <= value <= high + 0.2 for low, value, high in zip(box.min, point, box.max, strict=True)
            )


def test_lines_keep_length_colour_and_width(written):
    stage, units = written
    curves = UsdGeom.BasisCurves(stage.GetPrimAtPath("/__usdfoot/Com"))
    assert_allclose(
        units.points_to_canonical(np.array(curves.GetPointsAttr().Get())), [[0, 1, 0], [0, 1, 3]], atol=1e-6
    )
    assert_allclose(np.array(curves.GetWidthsAttr().Get()) * units.meters_per_unit, 0.01)
    assert_allclose(curves.GetDisplayColorPrimvar().Get(), [[1, 0, 0], [0, 0, 1]])
