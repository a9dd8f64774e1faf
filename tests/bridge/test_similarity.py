"""Similarities compose like the matrices they come from, and fold into joints without moving any."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Gf

from usdfoot.bridge.similarity import Similarity, fold_into_joints, similarity_of_matrices, unfold_from_joints
from usdfoot.errors import SkeletonError
from usdfoot.maths import quaternion
from usdfoot.model.skeleton import forward_kinematics

PARENTS = np.array([-1, 0, 1, 1, -1, 4])


def any_similarity(generator, count=1):
    return Similarity(
        scale=float(generator.uniform(0.01, 3.0)),
        rotation=quaternion.continuous(quaternion.normalised(generator.normal(size=(count, 4)))),
        translation=generator.normal(size=(count, 3)),
    )


def matrix(scale, rotation_axis, degrees, translation):
    scaled = Gf.Matrix4d().SetScale(Gf.Vec3d(*scale))
    turned = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(*rotation_axis), degrees))
    return scaled * turned * Gf.Matrix4d().SetTranslate(Gf.Vec3d(*translation))


def test_matrices_map_points_as_gf_does(generator):
    gf_matrix = matrix((0.01, 0.01, 0.01), (1, 2, 3), 77.0, (4.0, 5.0, 6.0))
    similarity = similarity_of_matrices(np.array(gf_matrix)[None], "/Rig")
    points = generator.normal(size=(10, 3))
    expected = [tuple(gf_matrix.Transform(Gf.Vec3d(*map(float, point)))) for point in points]
    assert_allclose(similarity.apply(points), expected, atol=1e-12)


def test_inverse_and_composition(generator):
    first, second = any_similarity(generator), any_similarity(generator)
    points = generator.normal(size=(10, 3))
    assert_allclose(second.after(first).apply(points), second.apply(first.apply(points)), atol=1e-12)
    assert_allclose(first.inverse().apply(first.apply(points)), points, atol=1e-12)


def test_a_moving_similarity_is_known_between_its_samples(generator):
    similarity = any_similarity(generator, 3)
    times = np.array([1.0, 1.5, 2.5])
    same = similarity.at(times, times)
    assert_allclose(same.translation, similarity.translation, atol=1e-12)
    assert_allclose(quaternion.align_signs(same.rotation, similarity.rotation), similarity.rotation, atol=1e-12)
    between = similarity.at(times, np.array([0.0, 1.75, 9.0]))
    assert_allclose(between.translation[[0, 2]], similarity.translation[[0, 2]], atol=1e-12)
    assert_allclose(between.translation[1], [0.75, 0.25] @ similarity.translation[1:], atol=1e-12)
    part, whole = (
        quaternion.to_rotation_vector(quaternion.compose(quaternion.inverse(similarity.rotation[1]), end))
        for end in (between.rotation[1], similarity.rotation[2])
    )
    assert_allclose(part, 0.25 * whole, atol=1e-9)


@pytest.mark.parametrize("count", [1, 7])
def test_folding_moves_every_joint_by_the_similarity(generator, count):
    similarity = any_similarity(generator, count)
    translations = generator.normal(size=(7, 6, 3))
    rotations = quaternion.normalised(generator.normal(size=(7, 6, 4)))
    before, _ = forward_kinematics(PARENTS, translations, rotations)
    folded = fold_into_joints(similarity, PARENTS, translations=translations, rotations=rotations)
    after, _ = forward_kinematics(PARENTS, *folded)
    turned = quaternion.rotate(similarity.rotation[:, None], before)
    assert_allclose(after, similarity.scale * turned + similarity.translation[:, None], atol=1e-12)
    back = unfold_from_joints(similarity, PARENTS, translations=folded[0], rotations=folded[1])
    assert_allclose(back[0], translations, atol=1e-12)
    assert_allclose(quaternion.align_signs(back[1], rotations), rotations, atol=1e-12)


@pytest.mark.parametrize(
    ("scale", "message"),
    [
        ((1.0, 1.0, 2.0), "/Rig: has a transform above it with shear or different scales"),
        ((-1.0, 1.0, 1.0), "/Rig: is mirrored by a transform above it. bake the negative scale"),
        ((0.0, 1.0, 1.0), "/Rig: has a transform above the joints that is not finite or scales to nothing"),
    ],
)
def test_other_matrices_are_refused(scale, message):
    with pytest.raises(SkeletonError, match=message):
        similarity_of_matrices(np.array(matrix(scale, (0, 1, 0), 30.0, (0, 0, 0)))[None], "/Rig")


def test_shear_and_a_scale_that_changes_are_refused():
    sheared = np.eye(4)
    sheared[0, 1] = 0.3
    growing = np.stack([np.eye(4), np.diag([2.0, 2.0, 2.0, 1.0])])
    for matrices in (sheared[None], growing):
        with pytest.raises(SkeletonError, match="shear or different scales"):
            similarity_of_matrices(matrices, "/Rig")
