"""Joints are matched by path, then by unique names, through prefixes and namespaces."""

import numpy as np
from numpy.testing import assert_array_equal

from usdfoot.readers.joints import match_joints, parent_indices


def test_parents_may_skip_joints_that_are_not_listed():
    assert_array_equal(parent_indices(["a", "a/b", "a/c/d", "x", "a/b/e"]), [-1, 0, 0, -1, 1])


def test_order_and_subsets_do_not_matter(generator):
    joints = ["a", "a/b", "a/b/c", "a/d", "a/d/e"]
    order = generator.permutation(len(joints))
    shuffled = [joints[i] for i in order]
    assert_array_equal(np.array(shuffled)[match_joints(shuffled, joints)], joints)
    assert_array_equal(match_joints(["a/d", "a/b"], joints), [-1, 1, -1, 0, -1])


def test_unique_leaf_names_match_where_paths_differ():
    assert_array_equal(match_joints(["Armature/Hips", "Armature/Hips/Leg"], ["Hips", "Hips/Leg"]), [0, 1])
    twice = ["Hips", "Hips/L/End", "Hips/R/End"]
    assert_array_equal(match_joints(["Root/Hips", "Root/Hips/L/End", "Root/Hips/R/End"], twice), [0, -1, -1])


def test_namespaces_and_common_prefixes_do_not_matter():
    plain = ["Hips", "Hips/LeftLeg", "Hips/LeftLeg/LeftFoot"]
    for prefix in ("mixamorig:", "mixamorig_", "char1:mixamorig:", "Bip01_"):
        prefixed = ["/".join(prefix + part for part in joint.split("/")) for joint in plain]
        assert_array_equal(match_joints(prefixed, plain), [0, 1, 2])
        assert_array_equal(match_joints(plain, prefixed), [0, 1, 2])


def test_a_prefix_of_a_few_joints_is_part_of_their_names():
    joints = ["Hips", "Hips/leg_l", "Hips/leg_r", "Hips/Spine"]
    assert_array_equal(match_joints(joints, ["Hips", "Hips/l", "Hips/r"]), [0, -1, -1])


def test_case_and_separators_are_the_last_resort():
    assert_array_equal(match_joints(["hips", "hips/left_leg"], ["Hips", "Hips/LeftLeg"]), [0, 1])
