"""The standing pose is symmetric, stands on its feet, and is found where clips stand."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.builders import Gait, build_walker
from tests.engine.walkers import library_of
from tests.walker_body import BALL_HEIGHT, HIP_WIDTH
from usdfoot.analysis.examples import build_examples
from usdfoot.analysis.mirror import mirror_map
from usdfoot.analysis.standing import StandingPose, find_standing_pose
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.skeleton import forward_kinematics


def joints_of(pose: StandingPose, library: ClipLibrary) -> np.ndarray:
    skeleton = library.skeleton
    translations, parents = skeleton.rest_translations.copy(), skeleton.parents.copy()
    translations[pose.pelvis], parents[pose.pelvis] = pose.pelvis_position, -1
    rotations = pose.rotations.copy()
    rotations[pose.pelvis] = pose.pelvis_rotation
    return forward_kinematics(parents, translations, rotations)[0]


@pytest.mark.parametrize("twisted", [False, True])
def test_pose_put_together_from_steps(twisted: bool) -> None:
    library = build_walker(twisted=twisted).library
    examples, _ = build_examples(library)
    pose = find_standing_pose(library, examples)
    joints, biped = joints_of(pose, library), library.biped
    partners = mirror_map(library.skeleton, biped).partners
    assert_allclose(joints[1:], joints[partners][1:] * [-1.0, 1.0, 1.0], atol=1e-6)
    balls, ankles, hips = joints[list(biped.balls)], joints[list(biped.ankles)], joints[list(biped.hips)]
    assert_allclose(balls[:, 1], BALL_HEIGHT, atol=1e-6)
    assert_allclose(balls.mean(axis=0)[[0, 2]], 0.0, atol=1e-6)
    assert_allclose(ankles[:, [0, 2]], hips[:, [0, 2]], atol=1e-6)  # the legs are upright
    assert_allclose(ankles[:, 0], [HIP_WIDTH, -HIP_WIDTH], atol=0.01)
    assert 0.9 < np.linalg.norm(hips[0] - ankles[0]) / biped.maximal_leg_length <= 1.0


def test_stand_in_a_clip_is_found() -> None:
    walker = build_walker(Gait(step_length=0.02, step_width=0.2, duty=0.8, heel_strike=False))
    time = 0.5 * (walker.contacts.left.strike_times[1] + walker.contacts.right.liftoff_times[1])
    sample = [int(np.argmin(np.abs(walker.clip.times - time)))] * 30
    standing = replace(
        walker.clip,
        name="/Stand",
        translations=walker.clip.translations[sample],
        rotations=walker.clip.rotations[sample],
    )
    walk = build_walker()
    library = replace(walk.library, clips=(walk.clip, standing))
    examples, _ = build_examples(library)
    pose = find_standing_pose(library, examples)
    assert pose.clip == 1
    joints = joints_of(pose, library)
    balls = joints[list(library.biped.balls)]
    assert_allclose(balls[0], [0.1, BALL_HEIGHT, 0.0], atol=5e-3)
    assert_allclose(balls[1], [-0.1, BALL_HEIGHT, 0.0], atol=5e-3)


def test_where_no_foot_stands_for_a_whole_step_those_that_stand_longest_show_how() -> None:
    slow = Gait(step_time=0.4, step_length=0.6, duty=0.42)
    leap = Gait(step_time=0.4, step_length=2.6, duty=0.2)
    stances = []
    for gaits in ((slow,), (slow, leap)):
        library = library_of(gaits)
        joints = joints_of(find_standing_pose(library, build_examples(library)[0]), library)
        legs = [library.biped.hips, library.biped.knees, library.biped.ankles, library.biped.balls]
        stances.append(joints[np.array(legs)])
    assert_allclose(stances[1], stances[0], atol=0.02)


def test_without_examples_the_rest_pose_stands() -> None:
    library = replace(build_walker().library, clips=())
    examples, _ = build_examples(library)
    pose = find_standing_pose(library, examples)
    joints = joints_of(pose, library)
    assert_allclose(joints[library.biped.pelvis][1], library.skeleton.rest_translations[1, 1], atol=1e-6)
