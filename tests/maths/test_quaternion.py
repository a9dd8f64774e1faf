"""Quaternions against scipy's Rotation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation, Slerp

from tests.strategies import angles, unit_quaternions, vectors
from usdfoot.maths import quaternion


def assert_same_rotation(first: np.ndarray, second: np.ndarray, *, atol: float = 1e-12) -> None:
    """Unit quaternions that agree up to sign."""
    assert_allclose(np.linalg.norm(first, axis=-1), 1.0, atol=1e-12)
    assert_allclose(quaternion.align_signs(first, second), second, rtol=0, atol=atol)


@given(unit_quaternions(3), unit_quaternions(3))
def test_compose(first: np.ndarray, second: np.ndarray) -> None:
    assert_same_rotation(quaternion.compose(first, second), (Rotation(first) * Rotation(second)).as_quat())


def test_compose_broadcasts(generator: np.random.Generator) -> None:
    one, many = quaternion.normalised(generator.normal(size=4)), quaternion.normalised(generator.normal(size=(5, 2, 4)))
    composed = quaternion.compose(one, many)
    assert composed.shape == (5, 2, 4)
    assert_same_rotation(composed[3, 1], (Rotation(one) * Rotation(many[3, 1])).as_quat())


@given(unit_quaternions(3))
def test_inverse(rotations: np.ndarray) -> None:
    assert_same_rotation(quaternion.inverse(rotations), Rotation(rotations).inv().as_quat())


@given(unit_quaternions(4), vectors(3))
def test_rotate(rotations: np.ndarray, vector: np.ndarray) -> None:
    assert_allclose(quaternion.rotate(rotations, vector), Rotation(rotations).apply(vector), atol=1e-12)


@given(unit_quaternions(4))
def test_matrices_both_ways(rotations: np.ndarray) -> None:
    matrices = quaternion.to_matrix(rotations)
    assert_allclose(matrices, Rotation(rotations).as_matrix(), atol=1e-12)
    back = quaternion.from_matrix(matrices)
    assert back[..., 3].min() >= 0.0
    assert_same_rotation(back, rotations)


@given(vectors(3, size=3.0))
def test_exponential_map(vector: np.ndarray) -> None:
    assert_same_rotation(quaternion.from_rotation_vector(vector), Rotation.from_rotvec(vector).as_quat())


@given(unit_quaternions(4))
def test_logarithm_is_the_shorter_rotation(rotations: np.ndarray) -> None:
    logarithm = quaternion.to_rotation_vector(rotations)
    assert np.linalg.norm(logarithm, axis=-1).max() <= np.pi + 1e-12
    assert_same_rotation(quaternion.from_rotation_vector(logarithm), rotations)


@pytest.mark.parametrize("angle", [0.0, 1e-14, 1e-9, 1e-7, 1e-4])
def test_logarithm_of_tiny_rotations_is_exact(angle: float) -> None:
    vector = angle * np.array([0.6, 0.0, -0.8])
    assert_allclose(
        quaternion.to_rotation_vector(quaternion.from_rotation_vector(vector)), vector, rtol=1e-12, atol=1e-26
    )


@given(unit_quaternions(1), angles)
def test_axis_angle(rotation: np.ndarray, angle: float) -> None:
    axis = quaternion.rotate(rotation, np.array([0.0, 0.0, 1.0]))
    expected = Rotation.from_rotvec(axis * angle).as_quat()
    assert_same_rotation(quaternion.from_axis_angle(axis, np.array([angle])), expected)


@given(angles)
def test_yaw_turns_forward_from_z_to_x(yaw: float) -> None:
    turned = quaternion.rotate(quaternion.yaw_quaternion(np.array(yaw)), np.array([0.0, 0.0, 1.0]))
    assert_allclose(turned, [np.sin(yaw), 0.0, np.cos(yaw)], atol=1e-12)


@given(unit_quaternions(1), vectors(3, size=1.0), st.sampled_from([0.0, 1e-9, 1.0]))
def test_between_turns_one_onto_the_other_by_the_least_angle(
    rotation: np.ndarray, offset: np.ndarray, amount: float
) -> None:
    start = quaternion.rotate(rotation[0], np.array([0.0, 0.0, 1.0]))
    for base in (start, -start):
        end = base + amount * offset
        if np.linalg.norm(end) < 0.1:
            continue
        end = end / np.linalg.norm(end)
        found = quaternion.between(start, end)
        assert_allclose(quaternion.rotate(found, start), end, atol=1e-7)
        angle = np.linalg.norm(quaternion.to_rotation_vector(found))
        assert angle == pytest.approx(np.arctan2(np.linalg.norm(np.cross(start, end)), start @ end), abs=1e-7)


@given(unit_quaternions(2), st.floats(0.0, 1.0))
def test_slerp(ends: np.ndarray, fraction: float) -> None:
    start, end = ends
    assume(abs(start @ end) > 1e-6)  # half a turn apart both ways are short
    expected = Slerp([0.0, 1.0], Rotation(ends))(fraction).as_quat()
    assert_same_rotation(quaternion.slerp(start, end, np.array(fraction)), expected, atol=1e-9)


@given(unit_quaternions(5), st.lists(st.booleans(), min_size=5, max_size=5))
def test_continuous_only_flips_signs(rotations: np.ndarray, flips: list[bool]) -> None:
    flipped = rotations * np.where(flips, -1.0, 1.0)[:, None]
    smooth = quaternion.continuous(flipped)
    assert np.all(np.sum(smooth[1:] * smooth[:-1], axis=1) >= 0.0)
    assert_allclose(np.abs(smooth), np.abs(rotations), atol=0)
    assert_allclose(smooth[0], flipped[0], atol=0)


def test_mean_does_not_see_signs_and_agrees_with_scipy(generator: np.random.Generator) -> None:
    centre = quaternion.normalised(generator.normal(size=4))
    near = quaternion.compose(centre, quaternion.from_rotation_vector(generator.normal(scale=0.3, size=(4, 3))))
    weights = np.array([0.1, 0.2, 0.3, 0.4])
    expected = Rotation(near).mean(weights).as_quat()
    signs = np.array([1.0, -1.0, -1.0, 1.0])[:, None]
    assert_same_rotation(quaternion.mean(near, weights), expected)
    assert_same_rotation(quaternion.mean(near * signs, weights), expected)
    batched = quaternion.mean(np.stack([near, near], axis=1), weights)
    assert batched.shape == (2, 4)


@given(unit_quaternions(1), vectors(3))
def test_mirror_image_of_a_rotation_turns_mirror_images(rotation: np.ndarray, vector: np.ndarray) -> None:
    flip = np.array([-1.0, 1.0, 1.0])
    mirrored = quaternion.rotate(quaternion.mirror_x(rotation[0]), vector * flip)
    assert_allclose(mirrored, quaternion.rotate(rotation[0], vector) * flip, atol=1e-12)
