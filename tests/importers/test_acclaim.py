"""ASF and AMC files: joints end up where a textbook says, and what is wrong is named with its line."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from numpy.testing import assert_allclose

from tests.importers.motion_files import random_acclaim
from tests.importers.naive_files import acclaim_positions
from tests.strategies import seeds
from usdfoot.errors import ClipError, SceneError
from usdfoot.importers.amc import import_amc
from usdfoot.importers.asf import import_asf
from usdfoot.model.limits import Limits
from usdfoot.model.skeleton import forward_kinematics

ASF = """\
:version 1.10
:units
  length 0.5
  angle deg
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
  begin
    name thigh
    direction 0 -1 0
    length 2
    axis 0 0 20 XYZ
    dof rx rz
  end
  begin
    name shin
    direction 0 -1 0
    length 3
    axis 0 0 0 XYZ
    dof ry
  end
:hierarchy
  begin
    root thigh
    thigh shin
  end
"""
AMC = """\
:FULLY-SPECIFIED
:DEGREES
1
root 0 5 0 0 0 0
thigh 10 20
shin 5
2
root 0 5 1 0 0 0
thigh 11 20
shin 6
"""


def imported(folder, asf: str = ASF, amc: str = AMC, *, unit: str = "m", rate: float = 120.0, limits=None):
    (folder / "a.asf").write_bytes(asf.encode())
    (folder / "a_1.amc").write_bytes(amc.encode())
    limits = limits or Limits()
    skeleton = import_asf(folder / "a.asf", unit=unit, limits=limits)
    return import_amc(folder / "a_1.amc", skeleton, rate=rate, limits=limits)


@hypothesis_settings(max_examples=40)
@given(seed=seeds)
def test_joints_are_where_a_textbook_puts_them(seed, tmp_path_factory):
    asf, amc = random_acclaim(np.random.default_rng(seed))
    names, expected = acclaim_positions(asf, amc, degrees=1.0 if "angle deg" in asf else 180.0 / np.pi)
    capture, problems = imported(tmp_path_factory.mktemp("acclaim"), asf, amc, unit="in")
    (clip,) = capture.clips
    places, _ = forward_kinematics(capture.skeleton.parents, clip.translations, clip.rotations)
    mine = [joint.rsplit("/", 1)[-1] for joint in capture.skeleton.joints]
    assert problems == () and sorted(mine) == sorted(names)
    assert_allclose(places[:, [mine.index(name) for name in names]], expected * 0.0254 / 0.45, atol=1e-6)
    assert clip.rate == 120.0 and clip.start_time == pytest.approx(7 / 120.0)


def test_a_bone_nobody_moves_keeps_still_with_a_warning(tmp_path):
    capture, (problem,) = imported(tmp_path, amc=AMC.replace("shin 5\n", "").replace("shin 6\n", ""))
    assert "does not move shin, which keep still" in problem.message
    assert_allclose(np.ptp(capture.clips[0].rotations[:, 2], axis=0), 0.0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (":units", "units", r"a.asf: says no scale under :units"),
        ("length 0.5", "length 0", r"a.asf:3: is no scale"),
        ("angle deg", "angle turns", r"a.asf:4: 'turns' is no unit of angle"),
        (":hierarchy", ":tree", r"a.asf: has no :hierarchy"),
        ("name shin", "name thigh", r"a.asf:19: bone thigh is there already"),
        ("    name shin\n", "", r"a.asf:18: begins a bone without a name"),
        ("direction 0 -1 0\n    length 2", "direction 0 0 0\n    length 2", r"a.asf:13: is no direction"),
        (
            "direction 0 -1 0\n    length 2",
            "direction 0 -1\n    length 2",
            r"a.asf:13: has 2 numbers where there are",
        ),
        ("    length 3\n", "", r"a.asf:18: bone shin has no length"),
        ("0 0 20 XYZ", "0 0 20 XYY", r"a.asf:15: 'xyy' is no order of axes"),
        ("dof ry", "dof l", r"a.asf:23: degree of freedom 'l' is not read"),
        ("thigh shin", "thigh foot", r"a.asf:28: 'foot' is no bone"),
        ("    thigh shin\n", "", r"a.asf: bones do not hang on the root: shin"),
        ("thigh shin", "thigh shin shin", r"a.asf:28: bone shin hangs on another bone already"),
    ],
)
def test_what_is_wrong_with_a_skeleton_is_named(tmp_path, old, new, message):
    assert old in ASF
    with pytest.raises(ClipError, match=message):
        imported(tmp_path, ASF.replace(old, new), unit="" if "units" in old else "m")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("2\nroot", "3\nroot", r"a_1.amc:7: frame 3 follows 1"),
        ("shin 6\n", "", r"a_1.amc:7: the frame that begins here has no shin"),
        ("shin 6", "shin 6 7", r"a_1.amc:10: has 2 numbers where there are 1"),
        ("shin 6", "shin x", r"a_1.amc:10: 'x' is no finite number"),
        ("shin 6", "foot 6", r"a_1.amc:10: 'foot' is no bone of the ASF file"),
        ("shin 6", "thigh 1 2", r"a_1.amc:10: frame 2 has thigh twice"),
        ("\n1\nroot", "\nroot", r"a_1.amc:3: 'root' stands before the first frame"),
    ],
)
def test_what_is_wrong_with_a_motion_is_named(tmp_path, old, new, message):
    assert old in AMC
    with pytest.raises(ClipError, match=message):
        imported(tmp_path, amc=AMC.replace(old, new))


def test_what_the_files_do_not_say_is_asked_for(tmp_path):
    with pytest.raises(ClipError, match=r"a.asf: says length 0.5 under :units, but not of which unit. give --unit"):
        imported(tmp_path, unit="")
    with pytest.raises(ClipError, match=r"a_1.amc: does not say how many frames a second it has. give --rate"):
        imported(tmp_path, rate=0.0)
    with pytest.raises(SceneError, match=r"has 2 frames, more than 1"):
        imported(tmp_path, limits=Limits(frames=1))
    with pytest.raises(SceneError, match=r"has 3 joints, more than 2"):
        imported(tmp_path, limits=Limits(joints=2))
