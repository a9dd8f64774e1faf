"""BVH files: joints end up where a textbook says, and what is wrong is named with its line."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from numpy.testing import assert_allclose

from tests.importers.motion_files import random_bvh
from tests.importers.naive_files import bvh_positions
from tests.strategies import seeds
from usdfoot.errors import ClipError, SceneError
from usdfoot.importers.bvh import import_bvh
from usdfoot.model.limits import Limits
from usdfoot.model.skeleton import forward_kinematics

SMALL = """\
HIERARCHY
ROOT Hips
{
  OFFSET 0 90 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Left:UpLeg
  {
    OFFSET 10 0 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    End Site
    {
      OFFSET 0 -40 0
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.0333333
0 90 0 0 0 0 0 0 0
0 91 5 0 0 90 0 0 0
"""


def imported(tmp_path, text: str, **options):
    file = tmp_path / "clip.bvh"
    file.write_bytes(text.encode())
    return import_bvh(file, **{"unit": "cm", **options})


@hypothesis_settings(max_examples=40)
@given(seed=seeds)
def test_joints_are_where_a_textbook_puts_them(seed, tmp_path_factory):
    text = random_bvh(np.random.default_rng(seed))
    names, expected = bvh_positions("\n".join(line.split("#")[0] for line in text.splitlines()))
    capture = imported(tmp_path_factory.mktemp("bvh"), text, unit="m")
    (clip,) = capture.clips
    places, _ = forward_kinematics(capture.skeleton.parents, clip.translations, clip.rotations)
    assert [joint.rsplit("/", 1)[-1] for joint in capture.skeleton.joints] == names
    assert_allclose(places, expected, atol=1e-6 * max(1.0, np.abs(expected).max()))
    assert clip.rate == 120.0


def test_units_names_and_rates(tmp_path):
    capture = imported(tmp_path, SMALL)
    assert capture.skeleton.joints == ("Hips", "Hips/UpLeg")
    assert_allclose(capture.skeleton.rest_translations, [(0, 0.9, 0), (0.1, 0, 0)])
    assert_allclose(capture.clips[0].translations[1, 0], (0.0, 0.91, 0.05))
    assert capture.clips[0].rate == 30.0 and capture.clips[0].name == "clip"
    for unit, metres in (("inch", 0.0254), ("0.5", 0.5), ("M", 1.0), ("feet", 0.3048)):
        assert_allclose(imported(tmp_path, SMALL, unit=unit).clips[0].translations[0, 0, 1], 90.0 * metres)


@pytest.mark.parametrize(
    ("written", "rate"),
    [
        ("0.0333333", 30),
        ("0.033333", 30),
        ("0.00833333", 120),
        ("0.0417083", 24 / 1.001),
        ("0.04", 25),
        ("0.3", 1 / 0.3),
    ],
)
def test_frame_times_are_rounded_rates(tmp_path, written, rate):
    capture = imported(tmp_path, SMALL.replace("0.0333333", written))
    assert capture.clips[0].rate == pytest.approx(rate, rel=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("HIERARCHY\n", "", r"clip.bvh: does not begin with HIERARCHY"),
        ("ROOT Hips", "JOINT Hips", r"clip.bvh:2: is outside of the ROOT"),
        ("JOINT Left:UpLeg", "JOINT", r"clip.bvh:6: JOINT has no name"),
        ("JOINT Left:UpLeg", "ROOT Leg", r"clip.bvh:6: is a second ROOT"),
        ("JOINT Left:UpLeg", "BONE Leg", r"clip.bvh:6: 'BONE' is unknown"),
        ("OFFSET 10 0 0", "OFFSET 10 0", r"clip.bvh:8: OFFSET has 2 numbers"),
        ("OFFSET 10 0 0", "OFFSET 10 0 x", r"clip.bvh:8: 'x' is no finite number"),
        ("    OFFSET 10 0 0\n", "", r"clip.bvh:13: closes joint Left:UpLeg without OFFSET"),
        ("CHANNELS 3", "CHANNELS 4", r"clip.bvh:9: lists 3 channels, not 4"),
        ("3 Zrotation", "3 Wrotation", r"clip.bvh:9: channel 'Wrotation' is unknown"),
        ("3 Zrotation", "3 Yrotation", r"clip.bvh:9: lists a channel twice"),
        ("\n}\nMOTION", "\nMOTION", r"clip.bvh:2: joint Hips is never closed"),
        ("MOTION\n", "", r"clip.bvh:16: 'Frames:' belongs to no joint. MOTION comes next"),
        ("Frames: 2", "Frames: two", r"clip.bvh:17: 'two' is no number of frames"),
        ("Frames: 2", "Frames: 3", r"clip.bvh:20: is the last: there are 2 lines of frames, and line 17 says 3"),
        ("Frame Time: 0.0333333", "Frame Time: 0", r"clip.bvh:18: '0' is no frame time"),
        ("Frame Time: 0.0333333", "FrameTime", r"clip.bvh:18: stands where 'Frame Time:' was expected"),
        ("0 91 5 0 0 90 0 0 0", "0 91 5 0 0 90 0 0", r"clip.bvh:20: has 8 numbers where there are 9 channels"),
        ("0 91 5", "0 nan 5", r"clip.bvh:20: 'nan' is no finite number"),
        ("0 91 5", "0 1e300 5", r"clip.bvh:20: '1e300' is too large"),
        ("0 91 5", "0 91,5 5", r"clip.bvh:20: '91,5' is no finite number"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path, old, new, message):
    assert old in SMALL
    with pytest.raises(ClipError, match=message):
        imported(tmp_path, SMALL.replace(old, new))


def test_lines_beyond_the_frames_are_left_out(tmp_path, caplog):
    text = SMALL.rstrip() + "\n" + SMALL.rstrip().rsplit("\n", 1)[1] + "\n"
    assert len(imported(tmp_path, text).clips[0].translations) == 2
    assert "has 1 lines after its 2 frames, left out" in caplog.text


def test_units_are_asked_for_and_hostile_sizes_refused(tmp_path):
    with pytest.raises(ClipError, match=r"does not say in which unit.*give --unit"):
        imported(tmp_path, SMALL, unit="")
    with pytest.raises(ClipError, match=r"'parsec' is no known unit"):
        imported(tmp_path, SMALL, unit="parsec")
    with pytest.raises(SceneError, match=r"has 2 joints, more than 1.*--max-joints"):
        imported(tmp_path, SMALL, limits=Limits(joints=1))
    with pytest.raises(SceneError, match=r"has 1000000000 frames, more than 100000.*--max-frames"):
        imported(tmp_path, SMALL.replace("Frames: 2", "Frames: 1000000000"))
    with pytest.raises(ClipError, match=r"clip.bvh: is no text file"):
        imported(tmp_path, "\0" * 100)
    deep = "HIERARCHY\nROOT a {\nOFFSET 0 0 0\n" + "JOINT b {\nOFFSET 0 0 0\n" * 5000
    with pytest.raises(SceneError, match=r"more than 2000"):
        imported(tmp_path, deep)


def test_the_end_of_a_foot_becomes_its_ball(tmp_path):
    def leg(side: str, x: int) -> str:
        chain = [(f"{side}UpLeg", (x, -5, 0)), (f"{side}Leg", (0, -40, 0)), (f"{side}Foot", (0, -40, 0))]
        opening = "".join(f"JOINT {name} {{ OFFSET {a} {b} {c}\nCHANNELS 0\n" for name, (a, b, c) in chain)
        return opening + "End Site {\nOFFSET 0 -6 12\n}" + "}" * 3 + "\n"

    head = "JOINT Head {\nOFFSET 0 60 0\nCHANNELS 0\nEnd Site {\nOFFSET 0 10 0\n} }\n"
    text = "HIERARCHY\nROOT Hips {\nOFFSET 0 0 0\nCHANNELS 1 Yposition\n" + head + leg("Left", 10) + leg("Right", -10)
    capture = imported(
        tmp_path, text.replace("{ OFFSET", "{\nOFFSET") + "}\nMOTION\nFrames: 2\nFrame Time: .04\n0\n1\n"
    )
    leaves = [joint.rsplit("/", 1)[-1] for joint in capture.skeleton.joints]
    assert leaves[-2:] == ["LeftFoot_Toe", "RightFoot_Toe"] and len(leaves) == 10, "neither of the head"
    assert_allclose(capture.clips[0].translations[:, -2:], np.tile((0.0, -0.06, 0.12), (2, 2, 1)))
