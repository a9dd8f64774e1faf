"""Arms, spine and tail by shape, and how they answer to the steps."""

from __future__ import annotations

import numpy as np
import pytest

from usdfoot.analysis.body import find_body
from usdfoot.maths import quaternion
from usdfoot.model.skeleton import Skeleton, forward_kinematics
from usdfoot.physics.biped import measure_biped
from usdfoot.physics.rhythm import SIGNALS
from usdfoot.physics.style import BodyStyle
from usdfoot.physics.upper_body import build_upper_body
from usdfoot.readers.scene import read_scene


def character(stages, scene):
    library = read_scene(stages / f"physics_{scene}.usda").crowd.libraries[0]
    places, _ = forward_kinematics(
        library.skeleton.parents, library.skeleton.rest_translations, library.skeleton.rest_rotations
    )
    return library, find_body(library.skeleton, library.biped, places)


def names(skeleton: Skeleton, joints) -> list[str]:
    return [skeleton.joints[joint].rsplit("/", 1)[-1] for joint in joints or ()]


@pytest.mark.parametrize(
    ("scene", "spine", "tail", "arms"),
    [
        ("human_run", ["Spine", "Spine1", "Chest"], [], ["LeftArm", "RightArm"]),
        ("bird_walk", ["Breast"], ["Tail1", "Tail2"], ["LeftWing", "RightWing"]),
        (
            "dinosaur_leaps",
            ["Trunk", "Chest"],
            ["Tail1", "Tail2", "Tail3", "Tail4", "Tail5"],
            ["LeftUpperArm", "RightUpperArm"],
        ),
    ],
)
def test_limbs_are_found_by_shape(stages, scene, spine, tail, arms):
    library, body = character(stages, scene)
    assert names(library.skeleton, body.trunk) == spine
    assert names(library.skeleton, body.tail) == tail
    assert names(library.skeleton, [arm.upper for arm in body.arms]) == arms


def test_spread_arms_hang_down(stages):
    library, body = character(stages, "human_run")
    skeleton, biped = library.skeleton, library.biped
    rotations = skeleton.rest_rotations.copy()
    for arm, sign in zip(body.arms, (1.0, -1.0), strict=True):  # up to a T
        _, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, rotations)
        lift = quaternion.from_axis_angle(np.array([0.0, 0.0, 1.0]), np.array(sign * 1.45))
        above = turns[skeleton.parents[arm.upper]]
        change = quaternion.compose(quaternion.compose(quaternion.inverse(above), lift), above)
        rotations[arm.upper] = quaternion.compose(change, rotations[arm.upper])
    spread = Skeleton(
        name="T",
        joints=skeleton.joints,
        parents=skeleton.parents,
        rest_translations=skeleton.rest_translations,
        rest_rotations=rotations,
    )
    upper = build_upper_body(spread, biped, measure_biped(spread, biped), style=BodyStyle())
    places, _ = forward_kinematics(spread.parents, spread.rest_translations, upper.local)
    before, _ = forward_kinematics(spread.parents, spread.rest_translations, rotations)
    for arm in body.arms:
        assert abs(before[arm.hand, 0] - before[arm.upper, 0]) > 0.5  # it was a T
        along = places[arm.hand] - places[arm.upper]
        assert along[1] < -0.9 * np.linalg.norm(along)


def test_the_head_stays_level_and_joints_of_the_tail_lag_in_turn(stages):
    library, body = character(stages, "dinosaur_leaps")
    upper = build_upper_body(
        library.skeleton, library.biped, measure_biped(library.skeleton, library.biped), style=BodyStyle()
    )
    trunk = [*body.trunk, *body.neck]
    style = BodyStyle()
    for signal, axis, amount in (("stride", 1, style.turn), ("lean", 2, -style.sway), ("bob", 0, -style.pitch)):
        assert upper.gains[trunk, SIGNALS.index(signal), axis].sum() == pytest.approx(amount)
    assert upper.lags[list(body.tail)].tolist() == [1, 2, 3, 4, 5]
