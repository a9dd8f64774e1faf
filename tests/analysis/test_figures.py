"""Figures against truth laid by hand and slow, obvious loops."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from usdfoot.analysis.feet import heels_ahead
from usdfoot.analysis.figures import (
    FrameRanges,
    contact_figures,
    frames_between,
    largest_distances,
    smallest_in_ranges,
    sole_offsets,
    timing_faults,
)
from usdfoot.maths import quaternion
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton

RATE = 30.0
TIMES = np.arange(61) / RATE


def swinging_ball(*, strike=0.5, liftoff=1.5, ramp=0.3):
    """A ball that comes down at `strike`, stands at x = 1 and leaves at `liftoff`, 0.3 m from and to either side."""
    x = np.ones(len(TIMES))
    before, after = strike > TIMES, liftoff < TIMES
    x[before] -= ramp * np.minimum((strike - TIMES[before]) / 0.2, 1.0)
    x[after] += ramp * np.minimum((TIMES[after] - liftoff) / 0.2, 1.0)
    return np.stack([x, np.full_like(x, 0.04), np.zeros_like(x)], axis=1)


def test_frames_between_takes_both_ends():
    ranges = frames_between(TIMES, np.array([0.1, 0.11, 0.101]), np.array([0.2, 0.19, 0.102]), offset=100)
    assert ranges.first.tolist() == [103, 104, 104] and ranges.counts.tolist() == [4, 2, 0]
    frames, intervals = ranges.flattened()
    assert frames.tolist() == [103, 104, 105, 106, 104, 105] and intervals.tolist() == [0, 0, 0, 0, 1, 1]


@given(st.integers(0, 2**31), st.integers(1, 6))
def test_largest_distances_and_smallest_values_agree_with_loops(seed, count):
    generator = np.random.default_rng(seed)
    points = generator.normal(size=(40, 3))
    first = generator.integers(0, 30, count)
    counts = np.minimum(generator.integers(0, 11, count), 40 - first)
    ranges = FrameRanges(first=first, counts=counts)
    largest, smallest = largest_distances(points, ranges), smallest_in_ranges(points[:, 0], ranges)
    for i in range(count):
        own = points[first[i] : first[i] + counts[i]]
        pairs = [np.linalg.norm(a - b) for a in own for b in own]
        assert largest[i] == pytest.approx(max(pairs, default=0.0), abs=1e-12)
        if len(own):
            assert smallest[i] == own[:, 0].min()
        else:
            assert np.isnan(smallest[i])


@pytest.mark.parametrize("cloud", ["noise", "rounded", "two places", "one place", "circle"])
def test_largest_distances_of_long_ranges_are_those_of_all_pairs(cloud):
    count, generator = 700, np.random.default_rng(3)
    angles = generator.uniform(0.0, 2.0 * np.pi, count)
    points = {
        "noise": 1e-6 * generator.normal(size=(count, 3)),
        "rounded": np.round(generator.normal(size=(count, 3))) * 1e-6 + [3.1, 0.0, -2.0],
        "two places": np.array([[0.0, 1.0, 2.0], [0.0, 1.0, 2.001]])[generator.integers(0, 2, count)],
        "one place": np.ones((count, 3)),
        "circle": 1e-4 * np.stack([np.cos(angles), np.zeros(count), np.sin(angles)], axis=1),
    }[cloud]
    ranges = FrameRanges(first=np.array([0, 5, 100]), counts=np.array([600, 10, 600]))
    gaps = np.linalg.norm(points[:, None] - points, axis=2)
    expected = [gaps[:600, :600].max(), gaps[5:15, 5:15].max(), gaps[100:, 100:].max()]
    assert_allclose(largest_distances(points, ranges), expected, atol=1e-15)


def test_who_stands_for_minutes_is_measured_without_comparing_every_pair(monkeypatch):
    points = 1e-6 * np.random.default_rng(4).normal(size=(100_000, 3))
    monkeypatch.setattr("usdfoot.analysis.figures.BLOCK", 10**12)  # all pairs would not fit into memory
    (largest,) = largest_distances(points, FrameRanges(first=np.array([0]), counts=np.array([len(points)])))
    ends = points[np.argsort(np.linalg.norm(points, axis=1))[-500:]]
    assert largest == pytest.approx(np.linalg.norm(ends[:, None] - ends, axis=2).max(), abs=1e-15)


def test_contact_figures_of_a_known_drift():
    balls = np.tile([1.0, 0.04, 2.0], (len(TIMES), 1))
    balls[:, 0] += np.linspace(0.0, 0.006, len(TIMES))  # 0.1 mm a frame
    frames = np.arange(len(TIMES))
    yaws = 0.31 + 1e-4 * (frames - 15) * (frames - 45)  # 0.31 in the middle of both contacts
    forwards = quaternion.rotate(quaternion.yaw_quaternion(yaws), np.array([0.0, -0.07, 0.13]))
    planted = frames_between(TIMES, np.array([0.0, 1.0, 1.001]), np.array([1.0, 2.0, 1.002]))
    figures = contact_figures(
        balls,
        forwards,
        planted,
        targets=np.array([[1.0, 0.0, 2.0], [1.0, 0.5, 2.003], [0.0, 0.0, 0.0]]),
        orientations=quaternion.yaw_quaternion(np.array([0.3, 0.3, 0.0])),
    )
    np.testing.assert_allclose(figures.slide[:2], 0.003, atol=1e-12)
    second = np.hypot(np.linspace(0.003, 0.006, 31), 0.003).mean()
    np.testing.assert_allclose(figures.placement_error[:2], [0.0015, second], atol=1e-12)
    np.testing.assert_allclose(figures.yaw_error[:2], 0.01, atol=1e-12)
    assert np.isnan([figures.slide[2], figures.placement_error[2], figures.yaw_error[2]]).all()


def test_yaw_is_seen_along_the_normal_of_the_print():
    slope = quaternion.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(-0.4))
    turned = quaternion.compose(slope, quaternion.yaw_quaternion(np.array(0.7)))
    forward = quaternion.rotate(turned, np.array([0.0, -0.5, 1.0]))
    figures = contact_figures(
        np.zeros((2, 3)),
        np.tile(forward, (2, 1)),
        FrameRanges(first=np.array([0]), counts=np.array([2])),
        targets=np.zeros((1, 3)),
        orientations=turned[None],
    )
    assert figures.yaw_error[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("strike", "liftoff", "faults"),
    [
        (0.5, 1.5, [False, False, False]),
        (0.4, 1.5, [True, False, False]),  # comes down 0.1 s after flat
        (0.6, 1.5, [False, True, False]),  # stands 0.1 s before the strike
        (0.52, 1.5, [False, False, False]),  # within the frame allowed
        (0.5, 1.35, [False, False, True]),  # still stands two frames after the liftoff
    ],
)
def test_timing_rules(strike, liftoff, faults):
    found = timing_faults(
        TIMES,
        swinging_ball(),
        strike_times=np.array([strike]),
        flat_times=np.array([strike + 0.01]),
        liftoff_times=np.array([liftoff]),
    )
    assert found.tolist() == [faults]


def test_stepping_on_the_spot_is_no_early_strike():
    balls = np.tile([1.0, 0.04, 0.0], (len(TIMES), 1))
    swing = (TIMES > 0.5) & (TIMES < 1.0)
    balls[swing, 1] += 0.1 * np.sin((TIMES[swing] - 0.5) * 2.0 * np.pi)
    found = timing_faults(
        TIMES,
        balls,
        strike_times=np.array([0.0, 1.0]),
        flat_times=np.array([0.05, 1.05]),
        liftoff_times=np.array([0.5, 2.0]),
    )
    assert not found.any()


def test_heel_lies_behind_the_ankle_on_the_sole():
    skeleton = Skeleton(
        name="feet",
        joints=("p", "p/la", "p/la/lb", "p/ra", "p/ra/rb"),
        parents=np.array([-1, 0, 1, 0, 3]),
        rest_translations=np.array([[0, 1, 0], [0.1, -0.9, 0], [0, 0, 0.13], [-0.1, -0.9, 0], [0, 0.05, 0.12]], float),
        rest_rotations=np.array([[0, 0, 0, 1]] + [[0.38268343, 0, 0, 0.92387953], [0, 0, 0, 1]] * 2, float),
    )
    biped = Biped(
        pelvis=0,
        hips=(1, 3),
        knees=(1, 3),
        ankles=(1, 3),
        balls=(2, 4),
        ball_heights=np.array([0.03, 0.04]),
        com=np.zeros(3),
        nominal_leg_length=0.8,
        maximal_leg_length=0.9,
    )
    offsets = sole_offsets(skeleton, biped)
    pitched = quaternion.rotate(skeleton.rest_rotations[[1, 3]], offsets)
    np.testing.assert_allclose(pitched[0], [0.0, -0.13 * np.sqrt(0.5) - 0.03, -0.4 * 0.13], atol=1e-7)
    np.testing.assert_allclose(pitched[1, 2], -0.4 * np.hypot(0.05, 0.12), atol=1e-7)


def test_a_foot_that_stands_on_its_toes_rests_on_the_pad_under_the_ball():
    steep = heels_ahead(np.array([0.2, 0.135]), np.array([0.33, 0.056]), np.array([0.07, 0.034]))
    np.testing.assert_allclose(steep, [0.2 - 0.07, -0.4 * np.hypot(0.135, 0.056)])
