"""Skeletons: forward kinematics against matrices, chains, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from tests.strategies import seeds
from usdfoot.errors import SkeletonError
from usdfoot.maths import quaternion
from usdfoot.model.skeleton import Skeleton, forward_kinematics

PARENTS = np.array([-1, 0, 1, 0, 3, -1])


def skeleton(**changes: object) -> Skeleton:
    values: dict = {
        "name": "/World/Rig",
        "joints": ("Hips", "Hips/Leg", "Hips/Leg/Foot", "Hips/Spine", "Hips/Spine/Head", "Prop"),
        "parents": PARENTS,
        "rest_translations": np.zeros((6, 3)),
        "rest_rotations": np.tile([0.0, 0.0, 0.0, 1.0], (6, 1)),
    }
    return Skeleton(**(values | changes))


@given(seeds)
def test_forward_kinematics_is_the_product_of_matrices(seed: int) -> None:
    generator = np.random.default_rng(seed)
    translations, rotations = generator.normal(size=(3, 6, 3)), quaternion.normalised(generator.normal(size=(3, 6, 4)))
    positions, turned = forward_kinematics(PARENTS, translations, rotations)
    for pose in range(3):
        for joint in range(6):
            matrix, ancestor = np.eye(4), joint
            while ancestor >= 0:
                local = np.eye(4)
                local[:3, :3] = Rotation(rotations[pose, ancestor]).as_matrix()
                local[:3, 3] = translations[pose, ancestor]
                matrix, ancestor = local @ matrix, PARENTS[ancestor]
            assert_allclose(positions[pose, joint], matrix[:3, 3], atol=1e-12)
            assert_allclose(Rotation(turned[pose, joint]).as_matrix(), matrix[:3, :3], atol=1e-12)


def test_forward_kinematics_shares_translations_among_poses_and_keeps_its_input(generator: np.random.Generator) -> None:
    translations, rotations = generator.normal(size=(6, 3)), quaternion.normalised(generator.normal(size=(4, 6, 4)))
    before = translations.copy(), rotations.copy()
    positions, _ = forward_kinematics(PARENTS, translations, rotations)
    single, _ = forward_kinematics(PARENTS, translations, rotations[2])
    assert_allclose(positions[2], single)
    assert_allclose(translations, before[0], atol=0)
    assert_allclose(rotations, before[1], atol=0)


def test_chain_runs_from_ancestor_to_joint() -> None:
    assert skeleton().chain(0, 2) == (0, 1, 2)
    assert skeleton().chain(3, 3) == (3,)


def test_chain_to_a_joint_elsewhere_is_refused() -> None:
    with pytest.raises(SkeletonError, match=r"/World/Rig: Prop is not below Hips"):
        skeleton().chain(0, 5)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"joints": ()}, "/World/Rig: has no joints. author the joints"),
        ({"rest_translations": np.zeros((5, 3))}, r"has 6 joints but arrays of shapes .*\(5, 3\)"),
        ({"parents": np.array([-1, 0, 1, 4, 3, -1])}, "joints listed before their parents: Hips/Spine. order parents"),
    ],
)
def test_inconsistent_skeletons_are_refused(changes: dict, message: str) -> None:
    with pytest.raises(SkeletonError, match=message):
        skeleton(**changes)
