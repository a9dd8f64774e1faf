"""A second USD parser, which shares no code with OpenUSD, composes the crowd and sees feet on their footsteps."""

import numpy as np
import pytest
from pxr import Usd

from tests.clients.joints import joint_positions

lightusd = pytest.importorskip("lightusd", reason="no second USD parser: pip install lightusd")

BALLS = ("LeftToe", "RightToe")


@pytest.fixture(scope="module")
def stage(stones):
    return lightusd.load(str(stones.crowd_file))


def numbers(attribute, code=None):
    return np.array(attribute.get() if code is None else attribute.eval(code), dtype=float)


def matrices(translations, quaternions, scales):
    """Joint matrices for column vectors from the arrays of a SkelAnimation, quaternions real part first."""
    w, x, y, z = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    joints = np.tile(np.eye(4), (len(translations), 1, 1))
    joints[:, :3, :3] = np.moveaxis(np.array(rows), -1, 0) * scales[:, None, :]
    joints[:, :3, 3] = translations
    return joints


def ball_positions(stage, code):
    """Balls in the world by forward kinematics from the arrays this parser reads."""
    animation, agent = stage.prim_at("/Crowd/Anims/Walker"), stage.prim_at("/Crowd/Agents/Walker")
    names = [str(name) for name in animation.attribute("joints").get()]
    local = matrices(
        numbers(animation.attribute("translations"), code),
        numbers(animation.attribute("rotations"), code),
        numbers(animation.attribute("scales")),
    )
    skel = {}
    for name, matrix in zip(names, local, strict=True):
        parent = name.rpartition("/")[0]
        skel[name] = skel[parent] @ matrix if parent else matrix
    yaw = np.radians(float(agent.attribute("xformOp:rotateY").eval(code)))
    turn = np.array([[np.cos(yaw), 0.0, np.sin(yaw)], [0.0, 1.0, 0.0], [-np.sin(yaw), 0.0, np.cos(yaw)]])
    place = numbers(agent.attribute("xformOp:translate"), code)
    return {name.rsplit("/", 1)[-1]: turn @ matrix[:3, 3] + place for name, matrix in skel.items()}


def test_metadata_and_prims_are_those_of_openusd(stage, stones):
    own = Usd.Stage.Open(str(stones.crowd_file))
    assert (stage.up_axis, stage.meters_per_unit, stage.time_codes_per_second) == ("Y", 1.0, 30.0)
    assert (stage.start_time, stage.end_time) == (own.GetStartTimeCode(), own.GetEndTimeCode())

    def below(prim):
        yield str(prim.path), str(prim.type_name)
        for child in prim.children:
            yield from below(child)

    seen = {path: kind for root in stage.root_prims for path, kind in below(root)}
    prims = Usd.PrimRange(own.GetPseudoRoot(), Usd.TraverseInstanceProxies())
    assert seen == {str(prim.GetPath()): str(prim.GetTypeName()) for prim in prims if not prim.IsPseudoRoot()}


def test_every_sample_of_the_animation_is_read_alike(stage, stones):
    opened = Usd.Stage.Open(str(stones.crowd_file))
    own = opened.GetPrimAtPath("/Crowd/Anims/Walker")
    animation = stage.prim_at("/Crowd/Anims/Walker")
    for name in ("translations", "rotations"):
        attribute = animation.attribute(name)
        codes = own.GetAttribute(name).GetTimeSamples()
        assert list(attribute.timesamples.times) == codes
        for code in codes[::20]:
            value = own.GetAttribute(name).Get(code)
            if name == "rotations":
                value = [[quaternion.GetReal(), *quaternion.GetImaginary()] for quaternion in value]
            np.testing.assert_array_equal(numbers(attribute, code), np.array(value, dtype=float))


def test_feet_stand_where_the_plan_puts_them(stage, stones):
    plan = stage.prim_at("/Crowd/Plans/Walker")
    positions, sides = numbers(plan.attribute("positions")), numbers(plan.attribute("protoIndices")).astype(int)
    strikes, liftoffs = (numbers(plan.attribute(f"usdfoot:plan:{name}Times")) for name in ("strike", "liftoff"))
    kept = [step for step, status in enumerate(stones.results["Walker"].status) if status in ("ok", "outsideHull")]
    assert len(kept) > 10
    for step in kept:
        code = float(round(strikes[step] + 0.6 * (liftoffs[step] - strikes[step])))
        balls = ball_positions(stage, code)
        right = joint_positions(stones.crowd_file, "Walker", code)
        for ball in BALLS:
            np.testing.assert_allclose(balls[ball], right[ball], atol=1e-5)
        offset = balls[BALLS[sides[step]]] - positions[step]
        assert np.hypot(offset[0], offset[2]) < 1e-3
