"""Stage units and canonical space convert into each other, and mean what they should."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError
from usdfoot.maths import quaternion

ALL = [
    StageUnits(meters_per_unit=meters, up_axis=up, time_codes_per_second=rate)
    for meters, up, rate in ((0.01, "Y", 24.0), (1.0, "Z", 30.0), (0.0254, "Z", 60.0), (1.0, "Y", 120.0))
]
coordinates = st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=3)


@pytest.mark.parametrize("units", ALL)
@given(point=coordinates)
def test_points_come_back(units, point):
    point = np.array(point)
    assert_allclose(units.points_to_stage(units.points_to_canonical(point)), point, atol=1e-9)
    assert_allclose(units.directions_to_stage(units.directions_to_canonical(point)), point)


def test_a_z_up_stage_in_centimetres_faces_minus_y():
    units = StageUnits(meters_per_unit=0.01, up_axis="Z", time_codes_per_second=24.0)
    assert_allclose(units.points_to_canonical(np.array([[100.0, -200.0, 300.0]])), [[1.0, 3.0, 2.0]])
    assert_allclose(units.directions_to_stage(np.array([0.0, 0.0, 1.0])), [0.0, -1.0, 0.0])
    assert_allclose(units.directions_to_stage(np.array([0.0, 1.0, 0.0])), [0.0, 0.0, 1.0])


@pytest.mark.parametrize("units", ALL)
def test_rotating_then_converting_is_converting_then_rotating(units, generator):
    rotations = quaternion.normalised(generator.normal(size=(20, 4)))
    points = generator.normal(size=(20, 3))
    turned = units.directions_to_canonical(quaternion.rotate(rotations, points))
    canonical = quaternion.rotate(units.rotations_to_canonical(rotations), units.directions_to_canonical(points))
    assert_allclose(canonical, turned, atol=1e-12)
    assert_allclose(units.rotations_to_stage(units.rotations_to_canonical(rotations)), rotations)


@pytest.mark.parametrize("units", ALL)
def test_frames_keep_their_own_axes(units, generator):
    rotations = quaternion.normalised(generator.normal(size=(20, 4)))
    points = generator.normal(size=(20, 3))
    turned = units.directions_to_canonical(quaternion.rotate(rotations, points))
    assert_allclose(quaternion.rotate(units.frames_to_canonical(rotations), points), turned, atol=1e-12)
    back = units.frames_to_stage(units.frames_to_canonical(rotations))
    assert_allclose(quaternion.align_signs(back, rotations), rotations, atol=1e-12)


def test_times_are_codes_over_the_rate():
    units = StageUnits(meters_per_unit=1.0, up_axis="Y", time_codes_per_second=48.0)
    assert_allclose(units.codes_to_times(np.array([0.0, 12.0, 96.5])), [0.0, 0.25, 96.5 / 48.0])
    assert_allclose(units.times_to_codes(units.codes_to_times(np.array([7.75]))), [7.75])


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"meters_per_unit": 0.0}, "metersPerUnit: is 0.0. author a positive number"),
        ({"meters_per_unit": 1e300}, r"metersPerUnit: is 1e\+300. author a number between 1e-12 and 1e\+18"),
        ({"time_codes_per_second": float("nan")}, "timeCodesPerSecond: is nan"),
        ({"up_axis": "X"}, "upAxis: is X. author Y or Z"),
    ],
)
def test_impossible_units_are_named(values, message):
    with pytest.raises(SceneError, match=message):
        StageUnits(**values)
