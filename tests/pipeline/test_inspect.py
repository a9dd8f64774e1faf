"""The overlay of a written crowd: as a stage shows it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Sdf, Usd, UsdGeom, UsdValidation

from usdfoot.cli.main import main
from usdfoot.errors import OutputError, SceneError
from usdfoot.pipeline.inspect import inspect


@pytest.fixture(scope="module")
def overlay(stones, tmp_path_factory):
    """An overlay of the stepping stones."""
    return inspect(stones.crowd_file, tmp_path_factory.mktemp("overlay") / "inspect.usda").file


@pytest.fixture(scope="module")
def stage(stones, overlay):
    """As `usdview --sessionLayer` opens it."""
    root, session = (Sdf.Layer.FindOrOpen(str(path)) for path in (stones.crowd_file, overlay))
    return Usd.Stage.Open(root, session)


def test_validators_are_silent_over_the_crowd_and_alone(stage, overlay):
    context = UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())
    for opened in (stage, Usd.Stage.Open(str(overlay))):
        assert [error.GetMessage() for error in context.Validate(opened)] == []


def test_everything_drawn_is_a_guide_below_one_root(stage, overlay):
    layer = Sdf.Layer.FindOrOpen(str(overlay))
    assert [prim.path for prim in layer.rootPrims] == ["/__usdfoot"]
    drawn = [prim for prim in stage.Traverse() if prim.GetPath().HasPrefix("/__usdfoot")]
    shown = [UsdGeom.Imageable(prim) for prim in drawn if prim.IsA(UsdGeom.Imageable)]
    assert {imageable.ComputePurpose() for imageable in shown} == {"guide"}


def test_footsteps_lie_where_the_plan_says(stage):
    plan = UsdGeom.PointInstancer(stage.GetPrimAtPath("/Crowd/Plans/Walker"))
    marks = UsdGeom.PointInstancer(stage.GetPrimAtPath("/__usdfoot/Footsteps"))
    places = (np.array(each.GetPositionsAttr().Get()) for each in (plan, marks))
    assert_allclose(*(each[:, [0, 2]] for each in places), atol=1e-5)


def test_the_com_goes_with_the_pelvis_from_the_first_strike_to_the_last_liftoff(stage):
    points = np.array(UsdGeom.BasisCurves(stage.GetPrimAtPath("/__usdfoot/Com")).GetPointsAttr().Get())
    plan = np.array(UsdGeom.PointInstancer(stage.GetPrimAtPath("/Crowd/Plans/Walker")).GetPositionsAttr().Get())
    assert_allclose(points[0, [0, 2]], plan[:2, [0, 2]].mean(axis=0), atol=0.1)
    assert 0.7 < np.median(points[:, 1] - plan[:, 1].mean()) < 1.2


def test_contacts_appear_and_go(stage):
    contacts = UsdGeom.PointInstancer(stage.GetPrimAtPath("/__usdfoot/Contacts"))
    plan = stage.GetPrimAtPath("/Crowd/Plans/Walker")
    liftoffs = [float(code) for code in plan.GetAttribute("usdfoot:plan:liftoffTimes").Get()]
    codes = np.arange(stage.GetStartTimeCode(), np.floor(max(liftoffs)) + 1.0)
    assert {2 - len(contacts.GetInvisibleIdsAttr().Get(code)) for code in codes} == {1, 2}  # a walk: never none


def test_same_crowd_same_bytes_and_the_crowd_untouched(stones, overlay, tmp_path):
    folder = stones.crowd_file.parent
    before = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    again = inspect(stones.crowd_file, tmp_path / "again.usda")
    assert again.file.read_bytes() == overlay.read_bytes()
    assert {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before
    with pytest.raises(OutputError, match="would replace what it is made from"):
        inspect(stones.crowd_file, folder / "anims.usda")
    with pytest.raises(OutputError, match=r"end.* in .usd"):
        inspect(stones.crowd_file, tmp_path / "overlay.txt")


def test_agents_are_chosen_by_name(stones, tmp_path):
    with pytest.raises(SceneError, match="Walker"):
        inspect(stones.crowd_file, tmp_path / "nobody.usda", agents="Runner*")
    assert inspect(stones.crowd_file, tmp_path / "walkers.usdc", agents="Walk*").agents == ("Walker",)


def test_the_command_line_writes_the_overlay(stones, tmp_path, capsys):
    assert main(["inspect", str(stones.crowd_file), "-o", str(tmp_path / "i.usda"), "--error-scale", "20", "-q"]) == 0
    assert "i.usda" in capsys.readouterr().out
    assert Sdf.Layer.FindOrOpen(str(tmp_path / "i.usda")).GetAttributeAtPath(
        "/__usdfoot.usdfoot:overlay:scale:error"
    ).default == pytest.approx(20.0)
    assert main(["inspect", str(stones.crowd_file), "-q"]) == 2
    assert "give -o" in capsys.readouterr().err
