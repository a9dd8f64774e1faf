"""Poses as written: what hangs beside the body."""

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose

from tests.writers.crowds import JOINTS, Rig, character_of, wandering_motion, write_character
from usdfoot.bridge.units import StageUnits
from usdfoot.maths import quaternion
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.readers.joints import parent_indices
from usdfoot.writers.poses import pose_agents, rest_character

ANKLE, BALL, HIP = JOINTS.index("root/pelvis/hipL/kneeL/ankleL"), 5, JOINTS.index("root/pelvis/hipR")
BESIDE = {"root/ik": None, "root/ik/foot": ANKLE, "root/ik/foot/ctl": None, "root/ik/foot/ctl/toe": BALL, "aim": HIP}
"""Joints beside the body and the joint of it in whose place they rest; None: elsewhere."""


def with_joints_beside(character, generator):
    """The character with the joints of BESIDE, their axes at random."""
    skeleton = character.skeleton
    joints = (*skeleton.joints, *BESIDE)
    places, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    own = [np.array([0.3, 0.2, 0.1]) * (i + 1) if at is None else places[at] for i, at in enumerate(BESIDE.values())]
    places = np.vstack([places, own])
    turns = np.vstack([turns, quaternion.normalised(generator.normal(size=(len(BESIDE), 4)))])
    parents = parent_indices(joints)
    above, roots = np.maximum(parents, 0), (parents < 0)[:, None]
    back = np.where(roots, [0.0, 0.0, 0.0, 1.0], quaternion.inverse(turns[above]))
    skeleton = replace(
        skeleton,
        joints=joints,
        parents=parents,
        rest_translations=quaternion.rotate(back, places - np.where(roots, 0.0, places[above])),
        rest_rotations=quaternion.compose(back, turns),
    )
    ones = np.ones((len(joints), 3))
    return replace(character, skeleton=skeleton, rest_scales=ones, inherited_scales=ones[:, 0]), places, turns


def test_joints_beside_the_body_go_along_with_the_joint_in_whose_place_they_rest(tmp_path, generator):
    units = StageUnits()
    hero = character_of(write_character(tmp_path / "hero.usda", Rig(units=units)))
    character, rest_places, rest_turns = with_joints_beside(hero, generator)
    motion = wandering_motion("A", character, frames=12, rate=24.0)
    (posed,) = pose_agents([(motion, rest_character(character))], units)
    skeleton = character.skeleton
    places, turns = forward_kinematics(
        skeleton.parents, posed.translations.astype(float), posed.rotations.astype(float)
    )
    for joint, carrier in enumerate(BESIDE.values(), start=len(JOINTS)):
        other = int(skeleton.parents[joint]) if carrier is None else carrier
        to_rest, to_now = quaternion.inverse(rest_turns[other]), quaternion.inverse(turns[:, other])
        expected = quaternion.rotate(to_rest, rest_places[joint] - rest_places[other])
        found = 0.01 * quaternion.rotate(to_now, places[:, joint] - places[:, other])
        assert_allclose(found, np.tile(expected, (12, 1)), atol=1e-6)
        if carrier is not None:
            kept = quaternion.compose(to_rest, rest_turns[joint])
            found = quaternion.compose(to_now, turns[:, joint])
            assert_allclose(np.abs(np.sum(found * kept, axis=-1)), 1.0, atol=1e-6)
