"""Angular speed and jerk of rotations known in closed form."""

import numpy as np
import pytest

from usdfoot.analysis.smoothness import angular_jerks, angular_jumps, angular_speeds, body_joints, clip_rotations
from usdfoot.maths import quaternion
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton

AXIS = np.array([0.6, 0.0, 0.8])
SKELETON = Skeleton(
    name="s",
    joints=("root", "root/pelvis"),
    parents=np.array([-1, 0]),
    rest_translations=np.zeros((2, 3)),
    rest_rotations=np.tile([0.0, 0.0, 0.0, 1.0], (2, 1)),
)
BIPED = Biped(
    pelvis=1,
    hips=(1, 1),
    knees=(1, 1),
    ankles=(1, 1),
    balls=(1, 1),
    ball_heights=np.zeros(2),
    com=np.zeros(3),
    nominal_leg_length=1.0,
    maximal_leg_length=1.0,
)


def turning(angles):
    return quaternion.from_axis_angle(AXIS, np.asarray(angles))


def test_speed_and_jerk_of_a_cubic_angle():
    times = np.arange(20) / 50.0
    rotations = turning(0.5 * times**3)[:, None]
    np.testing.assert_allclose(angular_jerks(rotations, 50.0), 3.0, rtol=1e-6)
    np.testing.assert_allclose(angular_speeds(turning(2.0 * times), 50.0), 2.0, rtol=1e-9)


def test_a_joint_that_stops_jumps_by_its_speed():
    times = np.arange(11) / 40.0
    stopping = turning(np.minimum(times, times[5]) * 3.0)
    still = turning(np.zeros(11))
    jumps = angular_jumps(np.stack([stopping, still], axis=1), 40.0)
    np.testing.assert_allclose(jumps, np.where(np.arange(1, 10) == 5, 3.0 / np.sqrt(2.0), 0.0), atol=1e-9)


def test_sign_flips_do_not_count():
    rotations = turning(np.linspace(0.0, 1.0, 10))
    flipped = rotations * np.where(np.arange(10) % 2, -1.0, 1.0)[:, None]
    np.testing.assert_allclose(angular_jerks(flipped, 30.0), angular_jerks(rotations, 30.0), atol=1e-7)


def test_clips_are_resampled_within_their_range_and_the_pelvis_is_seen_in_the_world():
    angles = np.linspace(0.0, 1.0, 121)
    clip = Clip(
        name="c",
        rate=120.0,
        start_time=2.0,
        translations=np.zeros((121, 2, 3)),
        rotations=np.stack([turning(angles), turning(angles)], axis=1),
        range_start=2.25,
        range_end=2.75,
    )
    rotations = clip_rotations(clip, SKELETON, BIPED, rate=24.0)
    assert rotations.shape == (13, 2, 4)
    expected = quaternion.align_signs(turning(2.0 * (0.25 + np.arange(13) / 24.0)), rotations[:, 1])
    np.testing.assert_allclose(rotations[:, 1], expected, atol=1e-7)
    assert body_joints(SKELETON, BIPED).tolist() == [1]


def test_what_hangs_beside_the_pelvis_is_no_body():
    joints = ("root", "root/pelvis", "root/pelvis/spine", "root/footsteps", "root/footsteps/left")
    none = np.zeros((5, 3)), np.tile([0.0, 0.0, 0.0, 1.0], (5, 1))
    parents = np.array([-1, 0, 1, 0, 3])
    beside = Skeleton(name="s", joints=joints, parents=parents, rest_translations=none[0], rest_rotations=none[1])
    assert body_joints(beside, BIPED).tolist() == [1, 2]


@pytest.mark.parametrize("rate", [24.0, 30.0, 60.0])
def test_a_clip_at_another_rate_is_as_smooth_as_its_motion(rate):
    def motion(times):
        return np.stack([turning(0.1 * times), turning(1.5 + 0.5 * np.sin(2.0 * np.pi * 2.0 * times))], axis=1)

    flips = np.where(np.arange(121) % 2, -1.0, 1.0)[:, None, None]
    sampled = motion(np.arange(121) / 30.0)
    clip = Clip(name="c", rate=30.0, start_time=0.0, translations=np.zeros((121, 2, 3)), rotations=sampled * flips)
    truth = motion(np.arange(int(4.0 * rate) + 1) / rate)
    truth[:, 1] = quaternion.compose(truth[:, 0], truth[:, 1])
    rotations = clip_rotations(clip, SKELETON, BIPED, rate=rate)
    assert rotations.shape == truth.shape
    for figure in (angular_jerks, angular_jumps):
        expected = np.quantile(figure(truth, rate), 0.99)
        assert np.quantile(figure(rotations, rate), 0.99) == pytest.approx(expected, rel=0.02)


def test_too_few_samples_have_no_jerk():
    assert angular_jerks(turning([0.0, 0.1, 0.2])[:, None], 30.0).shape == (0, 1)
    assert angular_speeds(turning([0.0]), 30.0) == pytest.approx([])
