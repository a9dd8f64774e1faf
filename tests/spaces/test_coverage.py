"""Coverage: the error to expect is that of leaving clips out, empty circles are where no step lands."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial import cKDTree

from usdfoot.analysis.examples import build_examples
from usdfoot.maths import quaternion
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.readers.libraries import read_libraries
from usdfoot.spaces.coverage import cover_spaces, expected_errors, find_empty_circles
from usdfoot.spaces.footsteps import build_footstep_space, solve_footsteps
from usdfoot.spaces.library import build_spaces

KEPT = ("walk_070", "walk_110", "walk_150", "walk_wide", "walk_narrow", "side_left_035", "back_070")


@pytest.fixture(scope="module")
def library(stages):
    found = read_libraries(stages / "clips.usdc").libraries[0]
    return replace(found, clips=tuple(clip for clip in found.clips if clip.name.rsplit("/", 1)[-1] in KEPT))


@pytest.fixture(scope="module")
def examples(library):
    return build_examples(library)[0]


@pytest.fixture(scope="module")
def spaces(library, examples):
    return build_spaces(examples, pelvis=library.biped.pelvis)


def joints(library, examples, example, sample):
    """Joints of one sample of an example in the heading at the step's end, by plain forward kinematics."""
    skeleton, pelvis = library.skeleton, library.biped.pelvis
    assert pelvis == 0
    turn = quaternion.yaw_quaternion(-examples.turns[example])
    rotations = examples.rotations[example, sample].astype(float)
    rotations[pelvis] = quaternion.compose(turn, rotations[pelvis])
    translations = skeleton.rest_translations.copy()
    translations[pelvis] = quaternion.rotate(turn, examples.pelvis_positions[example, sample].astype(float))
    return forward_kinematics(skeleton.parents, translations, rotations)[0]


def test_expected_errors_are_those_of_clips_left_out(library, examples, spaces):
    """Against a plain loop over clips, examples and samples."""
    space = spaces.spaces["default", False, 0]
    landings = spaces.landings[space.examples]
    found = expected_errors(library.skeleton, library.biped.pelvis, examples, space=space, landings=landings)
    clips = examples.clip_indices[space.examples]
    members = space.footsteps.members[::8]
    slow = np.zeros(len(clips))
    for row in np.unique(members[members >= 0]):
        example = space.examples[row]
        rest = np.flatnonzero(clips != clips[row])
        solved = solve_footsteps(build_footstep_space(landings[rest]), landings[row : row + 1])
        others, weights = space.examples[rest[solved.examples[0]]], solved.weights[0]
        distances = []
        for sample in range(0, examples.rotations.shape[1]):
            heaviest = others[np.argmax(weights)]
            blend = {name: 0.0 for name in ("rotations", "pelvis")}
            for other, weight in zip(others, weights, strict=True):
                turn = quaternion.yaw_quaternion(-examples.turns[other])
                reference = examples.rotations[heaviest, sample].astype(float)
                reference[0] = quaternion.compose(quaternion.yaw_quaternion(-examples.turns[heaviest]), reference[0])
                turned = examples.rotations[other, sample].astype(float)
                turned[0] = quaternion.compose(turn, turned[0])
                blend["rotations"] = blend["rotations"] + weight * quaternion.align_signs(turned, reference)
                pelvis = quaternion.rotate(turn, examples.pelvis_positions[other, sample].astype(float))
                blend["pelvis"] = blend["pelvis"] + weight * pelvis
            translations = library.skeleton.rest_translations.copy()
            translations[0] = blend["pelvis"]
            rotations = quaternion.normalised(blend["rotations"])
            places, _ = forward_kinematics(library.skeleton.parents, translations, rotations)
            difference = places - joints(library, examples, example, sample)
            distances.append(np.linalg.norm(difference, axis=-1).mean())
        slow[row] = np.mean(distances)
    assert_allclose(found[::8], [slow[row[row >= 0]].mean() for row in members], atol=1e-9)
    assert found.min() > 0.0


def test_clips_that_are_there_twice_are_expected_to_be_met(library):
    """Up to the 5 mm within which landings are one."""
    names = ("walk_070", "walk_110", "walk_150")
    clips = [clip for clip in library.clips if clip.name.rsplit("/", 1)[-1] in names]
    twice = replace(library, clips=tuple([*clips, *(replace(clip, name=f"{clip.name}_again") for clip in clips)]))
    examples, _ = build_examples(twice)
    covered = cover_spaces(twice.skeleton, twice.biped, examples, spaces=build_spaces(examples, pelvis=0))
    for space in covered:
        assert np.nanmax(space.errors) < 0.01 and np.median(space.errors) < 1e-6


def test_both_feet_mirror_each_other(library, examples, spaces):
    left, right = (
        space for space in cover_spaces(library.skeleton, library.biped, examples, spaces=spaces) if not space.flight
    )
    assert (left.side, right.side) == (0, 1)
    assert_allclose(right.landings, left.landings * [-1.0, 1.0])
    assert_allclose(right.errors, left.errors)
    for circle, image in zip(left.empty_circles, right.empty_circles, strict=True):
        assert_allclose(image.place, circle.place * [-1.0, 1.0])
        assert image.radius == circle.radius


def test_the_largest_empty_circle_is_found_where_it_was_cut():
    grid = np.stack(np.meshgrid(np.arange(0.0, 1.01, 0.05), np.arange(-0.5, 1.01, 0.05)), axis=-1).reshape(-1, 2)
    centre = np.array([0.5, 0.6])
    kept = grid[np.linalg.norm(grid - centre, axis=1) > 0.22]
    space = build_footstep_space(kept)
    first, *others = find_empty_circles(space, np.full(len(space.vertices), 0.07), leg=0.85, flight=True)
    assert_allclose(first.place, centre, atol=0.03)
    assert first.radius == pytest.approx(cKDTree(kept).query(first.place)[0])
    assert first.inside and first.expected_error == pytest.approx(0.07)
    assert not others


def test_steps_to_the_side_are_missed_where_there_are_none():
    z = np.linspace(0.3, 0.8, 12)
    space = build_footstep_space(np.stack([0.1 + 0.05 * (np.arange(12) % 2), z], axis=1))
    circles = find_empty_circles(space, np.full(len(space.vertices), 0.02), leg=0.85, flight=False)
    aside = [circle for circle in circles if circle.place[0] > 0.3]
    assert aside and not aside[0].inside and np.isnan(aside[0].expected_error)
    assert all(circle.place[0] > 0.0 for circle in circles)
    assert not find_empty_circles(space, np.zeros(len(space.vertices)), leg=0.85, flight=True)


def test_one_clip_alone_leaves_single_landings_out(library):
    (clip,) = (clip for clip in library.clips if clip.name.endswith("walk_070"))
    one = replace(library, clips=(clip,))
    examples, _ = build_examples(one)
    for space in cover_spaces(one.skeleton, one.biped, examples, spaces=build_spaces(examples, pelvis=0)):
        assert np.isfinite(space.errors).all() == (len(space.landings) > 1)
