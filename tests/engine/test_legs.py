"""Two-bone inverse kinematics of the legs."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from tests.strategies import seeds
from tests.walker_body import SHIN, THIGH
from usdfoot.engine.legs import LegRig, bend_leg, leg_kinematics
from usdfoot.maths import quaternion
from usdfoot.model.skeleton import forward_kinematics

FULL = THIGH + SHIN
LATERAL = np.array([1.0, 0.0, 0.0])


@wp.kernel
def bend(
    rig: LegRig,
    side: int,
    pelvis: wp.array(dtype=wp.vec3f),
    turns: wp.array(dtype=wp.quatf),
    targets: wp.array(dtype=wp.vec3f),
    rotations: wp.array2d(dtype=wp.quatf),
    parents: wp.array(dtype=wp.quatf),
):
    frame = wp.tid()
    leg = leg_kinematics(rig, side, pelvis[frame], turns[frame], rotations, frame)
    parents[frame] = bend_leg(rig, side, leg, targets[frame], rotations, frame)


class Legs:
    """Poses of a walker and what bending does to them."""

    def __init__(self, library, side: int) -> None:
        self.library, self.side = library, side
        biped = library.source.biped
        self.joints = [part[side] for part in (biped.hips, biped.knees, biped.ankles)]

    def pose(self, knees: np.ndarray, hips: np.ndarray) -> np.ndarray:
        """Joint rotations (N, J, 4) with the knees bent and the hips turned (N, 3) [rad]."""
        count = len(knees)
        rest = self.library.source.skeleton.rest_rotations
        rotations = np.repeat(rest[None], count, axis=0)
        rotations[:, self.joints[0]] = quaternion.from_rotation_vector(hips)
        rotations[:, self.joints[1]] = quaternion.from_axis_angle(LATERAL, knees)
        return rotations

    def positions(self, rotations: np.ndarray) -> np.ndarray:
        """Hip, knee and ankle (N, 3, 3) with the pelvis upright at the origin, by forward kinematics."""
        skeleton = self.library.source.skeleton
        pelvis = self.library.source.biped.pelvis
        translations = np.repeat(skeleton.rest_translations[None], len(rotations), axis=0)
        translations[:, pelvis] = 0.0
        turned = rotations.copy()
        turned[:, pelvis] = [0.0, 0.0, 0.0, 1.0]
        parents = skeleton.parents.copy()
        parents[pelvis] = -1
        return forward_kinematics(parents, translations, turned)[0][:, self.joints]

    def bent(self, rotations: np.ndarray, targets: np.ndarray) -> np.ndarray:
        """Rotations after bending to the targets (N, 3)."""
        count = len(rotations)
        device = wp.array(rotations.astype(np.float32), dtype=wp.quatf)
        wp.launch(
            bend,
            dim=count,
            inputs=[
                self.library.rig.arrays,
                self.side,
                wp.zeros(count, dtype=wp.vec3f),
                wp.array(np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)).astype(np.float32), dtype=wp.quatf),
                wp.array(np.ascontiguousarray(targets, dtype=np.float32), dtype=wp.vec3f),
                device,
            ],
            outputs=[wp.zeros(count, dtype=wp.quatf)],
        )
        return device.numpy().astype(float)


@pytest.fixture(scope="module", params=[0, 1], ids=["left", "right"])
def legs(walker_library, request):
    return Legs(walker_library, request.param)


def random_pose(legs: Legs, generator: np.random.Generator, count: int = 32) -> np.ndarray:
    return legs.pose(generator.uniform(0.05, 1.5, count), generator.uniform(-0.6, 0.6, (count, 3)))


def random_targets(generator: np.random.Generator, hips: np.ndarray, shortest: float, longest: float) -> np.ndarray:
    """Points below the hips at a distance of `shortest` to `longest` leg lengths."""
    directions = np.array([0.0, -1.0, 0.0]) + generator.uniform(-0.6, 0.6, hips.shape)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return hips + directions * FULL * generator.uniform(shortest, longest, (len(hips), 1))


@given(seed=seeds)
def test_the_ankle_reaches_its_target_and_bones_keep_their_length(legs, seed):
    generator = np.random.default_rng(seed)
    before = random_pose(legs, generator)
    targets = random_targets(generator, legs.positions(before)[:, 0], 0.2, 0.999)
    after = legs.positions(legs.bent(before, targets))
    assert_allclose(after[:, 2], targets, atol=5e-5)
    assert_allclose(np.linalg.norm(after[:, 1] - after[:, 0], axis=1), THIGH, atol=1e-6)
    assert_allclose(np.linalg.norm(after[:, 2] - after[:, 1], axis=1), SHIN, atol=1e-6)


@given(seed=seeds)
def test_a_leg_already_there_is_left_alone(legs, seed):
    generator = np.random.default_rng(seed)
    before = legs.pose(generator.uniform(0.3, 1.5, 32), generator.uniform(-0.6, 0.6, (32, 3)))
    positions = legs.positions(before)
    assert_allclose(legs.positions(legs.bent(before, positions[:, 2])), positions, atol=1e-4)


@given(seed=seeds)
def test_the_knee_stays_in_the_plane_of_the_pose(legs, seed):
    """A target on the line from hip to ankle changes how far the knee bends, not where to."""
    generator = np.random.default_rng(seed)
    before = legs.pose(generator.uniform(0.2, 1.5, 32), generator.uniform(-0.6, 0.6, (32, 3)))
    hip, knee, ankle = np.moveaxis(legs.positions(before), 1, 0)
    across = ankle - hip
    length = np.linalg.norm(across, axis=1, keepdims=True)
    targets = hip + across / length * FULL * generator.uniform(0.4, 0.98, (32, 1))
    new_hip, new_knee, _ = np.moveaxis(legs.positions(legs.bent(before, targets)), 1, 0)
    normal = np.cross(knee - hip, across)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    assert_allclose(np.sum((new_knee - new_hip) * normal, axis=1), 0.0, atol=1e-4)
    forward = np.cross(across, normal)
    old_side, new_side = (np.sum(vector * forward, axis=1) for vector in (knee - hip, new_knee - new_hip))
    assert np.all(old_side * new_side > 0.0)


@given(seed=seeds, far=st.floats(1.001, 3.0))
def test_a_target_out_of_reach_is_approached_along_the_straight_leg(legs, seed, far):
    generator = np.random.default_rng(seed)
    before = random_pose(legs, generator)
    hip = legs.positions(before)[:, 0]
    targets = random_targets(generator, hip, far, far)
    after = legs.positions(legs.bent(before, targets))
    direction = (targets - hip) / np.linalg.norm(targets - hip, axis=1, keepdims=True)
    assert_allclose(after[:, 2], hip + FULL * direction, atol=2e-4 * FULL)


def test_a_target_at_the_hip_gives_a_finite_folded_leg(legs):
    before = legs.pose(np.array([0.5, 0.01]), np.zeros((2, 3)))
    hip = legs.positions(before)[:, 0]
    after = legs.positions(legs.bent(before, hip + np.array([0.0, -1e-4, 0.0])))
    assert np.isfinite(after).all()
    assert np.all(np.linalg.norm(after[:, 2] - hip, axis=1) < 0.03)


def test_the_knee_does_not_pop_while_the_leg_stretches(legs):
    count = 2001
    before = legs.pose(np.full(count, 0.2), np.zeros((count, 3)))
    hip = legs.positions(before)[:, 0]
    reach = np.linspace(0.9, 1.1, count)[:, None] * FULL
    after = legs.positions(legs.bent(before, hip + np.array([0.0, -1.0, 0.0]) * reach))
    assert np.linalg.norm(np.diff(after[:, 1], axis=0), axis=1).max() < 0.004


@pytest.mark.parametrize("bend_angle", [-2e-3, 0.0, 2e-3])
def test_a_straight_knee_bends_forward_whatever_the_noise(legs, bend_angle):
    before = legs.pose(np.array([bend_angle]), np.zeros((1, 3)))
    hip = legs.positions(before)[:, 0]
    after = legs.positions(legs.bent(before, hip + np.array([[0.0, -0.9 * FULL, 0.0]])))
    knee = (after[:, 1] - hip)[0]
    assert knee[2] > 0.15
    assert abs(knee[0]) < 0.01


def test_a_knee_blended_past_straight_bends_forward_and_does_not_pop(legs):
    """Offsets of a seam may bend a nearly straight knee the wrong way."""
    angles = np.linspace(-0.4, 0.4, 401)
    before = legs.pose(angles, np.zeros((len(angles), 3)))
    hip = legs.positions(before)[:, 0]
    after = legs.positions(legs.bent(before, hip + np.array([0.0, -0.95 * FULL, 0.0])))
    knee = after[:, 1] - hip
    assert knee[:, 2].min() > 0.1
    assert np.abs(knee[:, 0]).max() < 0.01
    assert np.linalg.norm(np.diff(knee, axis=0), axis=1).max() < 0.002
