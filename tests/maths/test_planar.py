"""Planar transforms agree with the quaternions about +Y."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from numpy.testing import assert_allclose

from tests.strategies import angles, vectors
from usdfoot.maths import planar, quaternion


@given(angles, vectors(2))
def test_rotate_is_the_rotation_about_y(yaw: float, point: np.ndarray) -> None:
    turned = quaternion.rotate(quaternion.yaw_quaternion(np.array(yaw)), np.array([point[0], 0.0, point[1]]))
    assert_allclose(planar.rotate(np.array(yaw), point), turned[[0, 2]], atol=1e-12)


def test_rotate_takes_one_yaw_for_each_point() -> None:
    turned = planar.rotate(np.array([0.0, 0.5 * np.pi]), np.array([[0.0, 1.0], [0.0, 1.0]]))
    assert_allclose(turned, [[0.0, 1.0], [1.0, 0.0]], atol=1e-15)


@given(angles)
def test_yaw_and_direction_are_inverse(yaw: float) -> None:
    found = planar.yaw_of(planar.direction(np.array(yaw)))
    assert_allclose(planar.wrap_angle(found - yaw), 0.0, atol=1e-12)
    assert_allclose(planar.rotate(np.array(yaw), np.array([0.0, 1.0])), planar.direction(np.array(yaw)), atol=1e-12)


@given(angles)
def test_wrapped_angles_are_the_same_within_half_a_turn(angle: float) -> None:
    wrapped = planar.wrap_angle(np.array(angle))
    assert -np.pi <= wrapped <= np.pi
    assert_allclose(np.exp(1j * wrapped), np.exp(1j * angle), atol=1e-12)


def test_circular_mean_knows_that_half_a_turn_has_two_signs() -> None:
    assert_allclose(np.abs(planar.circular_mean(np.array([np.pi - 0.1, -np.pi + 0.1]))), np.pi)
    assert_allclose(planar.circular_mean(np.array([[0.0, 0.4], [0.2, 0.4]]), axis=0), [0.1, 0.4])
