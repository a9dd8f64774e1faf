"""What the engine knows of a character's feet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.engine.plans import way
from tests.engine.walkers import in_world
from usdfoot.analysis.figures import sole_offsets
from usdfoot.engine.animate import prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.rig import build_rig, measure_feet
from usdfoot.maths import quaternion


@pytest.fixture(scope="module")
def tiptoe_library(walker_library):
    """The same clips on a character whose rest pose is a frame of them: one foot steep, the other with its toes up."""
    skeleton, biped = walker_library.source.skeleton, walker_library.source.biped
    rest = skeleton.rest_rotations.copy()
    for ankle, pitch in zip(biped.ankles, (0.9, -0.4), strict=True):
        turn = quaternion.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(pitch))
        rest[ankle] = quaternion.compose(turn, rest[ankle])
    source = replace(walker_library.source, skeleton=replace(skeleton, rest_rotations=rest))
    return prepare_library(source, EngineOptions())


def test_feet_are_flat_whatever_the_rest_pose_shows(walker_library, tiptoe_library):
    for level, found in zip(walker_library.rig.feet, tiptoe_library.rig.feet, strict=True):
        drops = [quaternion.rotate(foot.flat_rotation, foot.ball_offset)[1] for foot in (level, found)]
        assert drops[1] == pytest.approx(drops[0], abs=0.005)
        assert_allclose(found.heel_offset, level.heel_offset, atol=0.01)


def test_heels_are_those_that_validate_measures_though_clips_lean_the_feet(walker_library):
    source = walker_library.source
    skeleton, biped = source.skeleton, source.biped
    level, leaning = (measure_feet(skeleton, biped, np.array(rolls)) for rolls in ((0.0, 0.0), (0.2, -0.2)))
    for side, heel in enumerate(sole_offsets(skeleton, biped)):
        assert_allclose(leaning[side].heel_offset, heel, atol=1e-9)
        assert abs(leaning[side].flat_rotation @ level[side].flat_rotation) < 0.999


def test_planted_feet_do_not_stand_as_the_rest_pose_does(animate, walker_library, tiptoe_library):
    plan = way(stand_first=0.6, stand_last=0.6)
    level, found = (
        in_world(library.source, animate([plan], library=library)[0]) for library in (walker_library, tiptoe_library)
    )
    ankles = list(walker_library.source.biped.ankles)
    difference = np.linalg.norm(found.positions[:, ankles] - level.positions[:, ankles], axis=-1)
    assert np.median(difference) < 0.005
    assert difference.max() < 0.03


def elevation(foot):
    """Of the direction from ankle to ball of a flat foot [rad]."""
    across = quaternion.rotate(foot.flat_rotation, foot.ball_offset)
    return np.arcsin(across[1] / np.linalg.norm(across))


def test_feet_of_one_shape_are_flat_alike(walker_library):
    """A rest pose with one foot a little steeper; the sole of neither may sink in, so the steeper one counts."""
    skeleton, biped = walker_library.source.skeleton, walker_library.source.biped
    rest = skeleton.rest_rotations.copy()
    turn = quaternion.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(0.03))
    rest[biped.ankles[0]] = quaternion.compose(turn, rest[biped.ankles[0]])
    source = replace(walker_library.source, skeleton=replace(skeleton, rest_rotations=rest))
    left, right = build_rig(source.skeleton, biped, walker_library.examples).feet
    level = walker_library.rig.feet[0]
    assert_allclose(elevation(left), elevation(level) - 0.03, atol=1e-6)
    assert_allclose(elevation(right), elevation(left), atol=1e-9)
    assert_allclose(right.heel_offset, left.heel_offset * [-1.0, 1.0, 1.0], atol=1e-9)
