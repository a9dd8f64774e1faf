"""Time samples come onto one regular grid without moving what they say."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from pxr import Usd, UsdSkel, Vt

from usdfoot.errors import ClipError
from usdfoot.maths import quaternion
from usdfoot.readers.samples import (
    SampledArray,
    interpolate_linear,
    interpolate_rotations,
    read_samples,
    regular_codes,
)


@given(st.floats(-100, 100), st.floats(0.05, 1.0), st.integers(2, 200))
def test_regular_samples_keep_their_codes(start, spacing, count):
    codes = start + spacing * np.arange(count)
    assert_allclose(regular_codes([codes], 24.0), codes, atol=1e-9)


def test_samples_of_two_attributes_are_merged():
    grid = regular_codes([np.array([1.0, 2.0, 3.0]), np.array([1.5, 2.5])], 24.0)
    assert_allclose(grid, [1.0, 1.5, 2.0, 2.5, 3.0])


def test_irregular_samples_get_the_median_spacing_and_keep_their_ends():
    grid = regular_codes([np.array([0.0, 1.0, 2.0, 2.5, 3.0, 4.0, 5.0])], 24.0)
    assert_allclose(grid, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0])


def test_sparse_keys_are_filled_in_to_see_contacts():
    grid = regular_codes([np.array([0.0, 12.0, 24.0])], 24.0)
    assert_allclose(grid, np.arange(25.0))


def test_samples_of_another_length_are_left_out_and_said(caplog):
    stage = Usd.Stage.CreateInMemory()
    animation = UsdSkel.Animation.Define(stage, "/Walk")
    for code, values in ((0.0, [(0, 0, 0), (1, 0, 0)]), (1.0, [(0, 0, 0)]), (2.0, [(0, 0, 0), (3, 0, 0)])):
        animation.CreateTranslationsAttr().Set(values, code)
    assert read_samples(animation.GetTranslationsAttr(), 2).codes.tolist() == [0.0, 2.0]
    assert (
        "/Walk.translations: 1 sample(s) that hold other than 2 values are left out, first at time code 1"
        in caplog.text
    )


def test_samples_of_a_damaged_file_are_named(tmp_path):
    path, count = tmp_path / "damaged.usdc", 1237
    stage = Usd.Stage.CreateNew(str(path))
    translations = UsdSkel.Animation.Define(stage, "/Walk").CreateTranslationsAttr()
    for code in (0.0, 1.0):
        translations.Set(Vt.Vec3fArray.FromNumpy(np.full((count, 3), code, dtype=np.float32)), code)
    stage.Save()
    del stage, translations
    path.write_bytes(path.read_bytes().replace(struct.pack("<Q", count), struct.pack("<Q", 1 << 60)))
    stage = Usd.Stage.Open(str(path))
    with pytest.raises(ClipError, match=r"/Walk.translations: cannot be read\. \w+"):
        read_samples(UsdSkel.Animation(stage.GetPrimAtPath("/Walk")).GetTranslationsAttr(), count)


def test_a_single_default_gives_no_grid():
    assert len(regular_codes([np.array([0.0])], 24.0)) == 1


@pytest.mark.parametrize("code", [-1.0, 0.0, 0.25, 2.0, 3.5, 9.0])
def test_values_are_linear_between_and_held_outside(code):
    samples = SampledArray(codes=np.array([0.0, 2.0, 4.0]), values=np.array([[[0.0]], [[2.0]], [[10.0]]]))
    expected = np.interp(code, [0.0, 2.0, 4.0], [0.0, 2.0, 10.0])
    assert_allclose(interpolate_linear(samples, np.array([code])), [[[expected]]])


def test_rotations_take_the_shorter_arc_and_keep_their_sign():
    axis = np.array([0.0, 1.0, 0.0])
    angles = np.array([0.0, 0.5, 1.0])
    values = quaternion.from_axis_angle(axis, angles)[:, None] * np.array([1.0, -1.0, 2.0])[:, None, None]
    result = interpolate_rotations(SampledArray(codes=angles, values=values), np.linspace(0.0, 1.0, 11))
    assert_allclose(result[:, 0], quaternion.from_axis_angle(axis, np.linspace(0.0, 1.0, 11)), atol=1e-12)
