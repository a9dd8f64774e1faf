"""The kernels against slow, obvious numpy, one frame at a time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import warp as wp
from numpy.testing import assert_allclose

from tests.engine.plans import way
from tests.engine.synthesis import slow_phases, synthesise
from usdfoot.engine.clock_kernel import read_samples
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.pose_source import pose_feet
from usdfoot.engine.poses import device_library, device_segments, place_segments, pose_frames
from usdfoot.maths import quaternion
from usdfoot.model.examples import LIFTOFF_PHASES
from usdfoot.model.skeleton import forward_kinematics

SEGMENT_TIMES = 9


@pytest.fixture(scope="module", params=[0.0, 0.5], ids=["four", "eight"])
def made(walker_library, request):
    """Segments of up to four examples, and of up to eight with the root's."""
    plans = [way(turn=0.15, length=0.5), way(length=0.95, step_time=0.35, duty=0.4)]
    return synthesise(walker_library, plans, options=EngineOptions(root_weight=request.param))


@pytest.fixture(scope="module")
def frames(made):
    """Instants in all segments, with their poses from the kernels, seams left open."""
    setup, joints = made.setup, np.arange(len(made.setup.skeleton.joints))
    rows = np.repeat(np.arange(len(setup.segments)), SEGMENT_TIMES)
    shares = np.tile(np.linspace(0.0, 1.0, SEGMENT_TIMES), len(setup.segments))
    begins, ends = setup.segments.begins[rows], setup.segments.ends[rows]
    times = begins + shares * (ends - begins)
    arrays = place_segments(setup, device_segments(setup, made.blend))
    poses = pose_frames(setup, arrays, rows=rows, times=times, joints=joints)
    samples = slow_phases(setup.segments, rows, times) * (setup.examples.rotations.shape[1] - 1)
    return rows, times, samples, poses


def clock_samples(setup, blend, rows: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Samples of the examples that the kernels read at instants of segments."""
    samples = wp.empty(len(rows), dtype=wp.float32)
    clock = wp.array(times - setup.contacts.starts[setup.segments.agents[rows]], dtype=wp.float64)
    last = float(setup.examples.rotations.shape[1] - 1)
    inputs = [device_segments(setup, blend).clocks, wp.array(rows.astype(np.int32), dtype=wp.int32), clock, last]
    wp.launch(read_samples, dim=len(rows), inputs=inputs, outputs=[samples])
    return samples.numpy()


def naive_blend(rotations: np.ndarray, examples: np.ndarray, weights: np.ndarray, sample: float) -> np.ndarray:
    """Joint-local rotations (J, 4) of one frame: the examples at the sample, signs aligned to the heaviest, summed."""
    row = min(int(sample), rotations.shape[1] - 2)
    fraction = sample - row
    poses = [
        (1.0 - fraction) * rotations[example, row].astype(float) + fraction * rotations[example, row + 1]
        for example in examples
    ]
    total = np.zeros_like(poses[0])
    for weight, pose in zip(weights, poses, strict=True):
        total += weight * quaternion.align_signs(pose, poses[0])
    return quaternion.normalised(total)


def naive_slerps(rotations: np.ndarray, examples: np.ndarray, weights: np.ndarray, sample: float) -> np.ndarray:
    """As `naive_blend`, the examples slerped one after the other, each by its part of the weight so far."""
    row = min(int(sample), rotations.shape[1] - 2)
    fraction = sample - row
    result, weighed = None, 0.0
    for example, weight in zip(examples, weights, strict=True):
        if weight > 0.0:
            before, after = rotations[example, row].astype(float), rotations[example, row + 1].astype(float)
            pose = quaternion.normalised((1.0 - fraction) * before + fraction * quaternion.align_signs(after, before))
            weighed += weight
            result = pose if result is None else quaternion.slerp(result, pose, np.array(weight / weighed))
    return result


def naive_position(values: np.ndarray, examples: np.ndarray, weights: np.ndarray, sample: float) -> np.ndarray:
    row = min(int(sample), values.shape[1] - 2)
    fraction = sample - row
    each = (1.0 - fraction) * values[examples, row].astype(float) + fraction * values[examples, row + 1]
    return weights @ each


def test_blended_rotations_are_the_aligned_sums(made, frames):
    rows, _, samples, poses = frames
    rotations, pelvis = poses.rotations.numpy(), made.setup.library.pelvis
    joints = np.delete(np.arange(rotations.shape[1]), pelvis)
    for frame, (row, sample) in enumerate(zip(rows, samples, strict=True)):
        expected = naive_blend(made.setup.examples.rotations, made.blend.examples[row], made.blend.weights[row], sample)
        got = quaternion.align_signs(rotations[frame].astype(float), expected)
        assert_allclose(got[joints], expected[joints], atol=2e-6)


def test_on_request_rotations_are_slerped_one_after_the_other(made, frames):
    """[B] 4.4: the pose a footstep is measured by is theirs too, so that landings are corrected as well as of sums."""
    setup = made.setup
    library = device_library(setup.examples, setup.rig, pelvis=setup.pelvis, slerps=True)
    slerped = replace(setup, library=library)
    rows, times, samples, _ = frames
    joints = np.delete(np.arange(len(setup.skeleton.joints)), setup.pelvis)
    arrays = place_segments(slerped, device_segments(slerped, made.blend))
    every = np.arange(len(setup.skeleton.joints))
    rotations = pose_frames(slerped, arrays, rows=rows, times=times, joints=every).rotations.numpy().astype(float)
    for frame, (row, sample) in enumerate(zip(rows, samples, strict=True)):
        expected = naive_slerps(setup.examples.rotations, made.blend.examples[row], made.blend.weights[row], sample)
        got = quaternion.align_signs(rotations[frame], expected)
        assert_allclose(got[joints], expected[joints], atol=3e-6)


def test_the_sum_is_near_the_mean_rotation(made, frames):
    """Design.md section 7: the eigenvector mean is the oracle of the aligned sums."""
    rows, _, samples, poses = frames
    rotations = poses.rotations.numpy().astype(float)
    for frame in range(0, len(rows), 7):
        row, sample = rows[frame], int(samples[frame])
        whole = made.setup.examples.rotations[made.blend.examples[row], sample].astype(float)
        mean = quaternion.mean(whole, made.blend.weights[row])
        apart = quaternion.to_rotation_vector(quaternion.compose(quaternion.inverse(mean), rotations[frame]))
        body = np.delete(np.linalg.norm(apart, axis=-1), [0, made.setup.library.pelvis])
        step = np.linalg.norm(
            quaternion.to_rotation_vector(
                quaternion.compose(
                    quaternion.inverse(whole),
                    made.setup.examples.rotations[
                        made.blend.examples[row], min(sample + 1, made.setup.examples.rotations.shape[1] - 1)
                    ].astype(float),
                )
            ),
            axis=-1,
        ).max()
        assert body.max() < 0.02 + step


def test_the_support_ball_is_where_it_was_in_the_examples(made, frames):
    """[B] Eq. 2: root(t) = footstep * FK_ball(t)^-1, with the ball's own drift in the examples kept."""
    rows, _, samples, poses = frames
    setup, blend = made.setup, made.blend
    contacts, examples = setup.contacts, setup.examples
    skeleton = setup.skeleton
    pelvis = setup.library.pelvis
    balls = pose_feet(setup.rig, poses).balls
    checked = 0
    for frame, row in enumerate(rows):
        support = setup.segments.supports[row]
        if samples[frame] > LIFTOFF_PHASES[1] * (examples.rotations.shape[1] - 1) - 1e-6:
            continue  # from the liftoff of a run on, the body follows the examples' pelvis
        checked += 1
        side = contacts.sides[support]
        origin = contacts.positions[support] - setup.origins[setup.segments.agents[row]]
        local = naive_position(examples.support_balls, blend.examples[row], blend.weights[row], samples[frame])
        offset = balls[frame, side] - origin
        assert_allclose(np.linalg.norm(offset[[0, 2]]), np.linalg.norm(local[[0, 2]]), atol=1e-5)
        if contacts.agents[support] == 0:  # a flat walk without flight: nothing is added to the height
            assert_allclose(offset[1], local[1], atol=1e-5)
        rotations = naive_blend(examples.rotations, blend.examples[row], blend.weights[row], samples[frame])
        rotations[pelvis] = poses.pelvis_rotations.numpy()[frame]
        translations = skeleton.rest_translations.copy()
        translations[pelvis] = poses.pelvis_positions.numpy()[frame]
        parents = skeleton.parents.copy()
        parents[pelvis] = -1
        positions, _ = forward_kinematics(parents, translations, rotations)
        ball = [11, 15][side]
        assert_allclose(positions[ball], balls[frame, side], atol=1e-5)
    assert checked > 60


def test_the_body_turns_with_the_plan(made, frames):
    """At the strikes the pelvis has the blended heading plus the plan's."""
    rows, times, samples, poses = frames
    setup, blend = made.setup, made.blend
    pelvis = setup.library.pelvis
    for frame, row in enumerate(rows):
        if setup.segments.stands[row] or times[frame] != setup.segments.begins[row]:
            continue
        own = naive_blend(setup.examples.rotations, blend.examples[row], blend.weights[row], samples[frame])[pelvis]
        heading = quaternion.yaw_quaternion(setup.contacts.headings[setup.segments.supports[row]])
        expected = quaternion.compose(heading, own)
        got = quaternion.align_signs(poses.pelvis_rotations.numpy()[frame].astype(float), expected)
        assert_allclose(got, expected, atol=1e-5)


def test_weights_are_a_partition_heaviest_first(made):
    weights = made.blend.weights
    assert_allclose(weights.sum(axis=1), 1.0, atol=1e-12)
    assert weights.min() >= 0.0
    assert np.all(weights[:, 0] >= weights.max(axis=1) - 1e-12)


def test_samples_rise_from_strike_to_strike_as_pchip_and_straight_pieces_say(made):
    setup, segments = made.setup, made.setup.segments
    rows = np.repeat(np.arange(len(segments)), 50)
    times = (
        segments.begins[rows]
        + np.tile(np.linspace(0.0, 1.0, 50), len(segments)) * (segments.ends - segments.begins)[rows]
    )
    samples = clock_samples(setup, made.blend, rows, times)
    last = setup.examples.rotations.shape[1] - 1
    assert_allclose(samples, last * slow_phases(segments, rows, times), atol=1e-4)
    rising = samples.reshape(len(segments), 50)
    assert np.all(np.diff(rising, axis=1) > 0.0)
    assert_allclose(rising[:, -1], last, rtol=1e-6)
