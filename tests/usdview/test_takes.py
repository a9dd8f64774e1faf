"""Takes: the selected agents otherwise, and the crowd as it was."""

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdSkel

from tests.digests import digests
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.usdview.overlays import shown_kinds, toggle_overlay
from usdfoot.usdview.selection import Selection
from usdfoot.usdview.takes import animate_again, drop_takes, keep_take

NOW = Usd.TimeCode(40.0)
ONE = Selection(paths=(Sdf.Path("/Crowd/Agents/Agent_1"),))


def rotations(stage, agent):
    animation = UsdSkel.Animation(stage.GetPrimAtPath(f"/Crowd/Anims/{agent}"))
    return np.array(animation.GetRotationsAttr().Get(NOW))


def root_weights(stage, agent):
    return np.array(stage.GetPrimAtPath(f"/Crowd/Plans/{agent}").GetAttribute("usdfoot:result:rootWeight").Get())


def test_selected_agents_are_shown_with_another_root_weight_and_as_they_were(shot, opened):
    before = digests(shot)
    was = {name: rotations(opened, name) for name in ("Agent_0", "Agent_1")}
    toggle_overlay(opened, Selection(), NOW, kind="Errors")
    take = animate_again(opened, ONE, NOW, root_weight=0.6)
    assert sorted(take.report.results) == ["Agent_1"]
    assert root_weights(opened, "Agent_1").max() == pytest.approx(0.6) and root_weights(opened, "Agent_0").max() == 0.0
    assert np.abs(rotations(opened, "Agent_1") - was["Agent_1"]).max() > 1e-3
    assert np.array_equal(rotations(opened, "Agent_0"), was["Agent_0"])
    assert shown_kinds(opened) == ("Errors",)  # drawn again
    after = digests(shot)
    assert {name: after[name] for name in before} == before
    assert {name.split("/")[1] for name in set(after) - set(before)} == {"takes"}
    assert drop_takes(opened, ONE, NOW) == 1
    assert np.array_equal(rotations(opened, "Agent_1"), was["Agent_1"])
    assert digests(shot) == before


def test_a_later_take_is_shown_over_an_earlier_one(shot, opened):
    first = animate_again(opened, ONE, NOW, root_weight=0.3)
    second = animate_again(opened, ONE, NOW, root_weight=0.5, seam="crossfade")
    assert (first.folder.name, second.folder.name) == ("0001", "0002")
    assert root_weights(opened, "Agent_1").max() == pytest.approx(0.5)
    assert drop_takes(opened, Selection(), NOW) == 2


def test_a_take_is_kept_in_the_crowd(shot, opened):
    was = rotations(opened, "Agent_0")
    animate_again(opened, ONE, NOW, root_weight=0.5)
    shown = rotations(opened, "Agent_1")
    assert sorted(keep_take(opened, Selection(), NOW).results) == ["Agent_0", "Agent_1", "Agent_2"]
    assert opened.GetSessionLayer().empty and not any((shot / "crowd" / "takes").iterdir())
    fresh = Usd.Stage.Open(str(shot / "crowd" / "crowd.usd"))
    for stage in (opened, fresh):
        np.testing.assert_allclose(rotations(stage, "Agent_1"), shown, atol=1e-5)
        assert np.array_equal(rotations(stage, "Agent_0"), was)
    animate_again(opened, ONE, NOW, seam="crossfade")
    with pytest.raises(SceneError, match=r"and their seam is one that is asked of all\. make a take of all agents"):
        keep_take(opened, ONE, NOW)
    assert len(opened.GetSessionLayer().subLayerPaths) > 0  # still shown
    drop_takes(opened, ONE, NOW)
    take = animate_again(opened, Selection(), NOW, seam="crossfade", root_weight=0.0)
    shown = rotations(opened, "Agent_0")
    keep_take(opened, Selection(), NOW)
    np.testing.assert_allclose(rotations(opened, "Agent_0"), shown, atol=1e-5)
    assert not take.folder.exists()
    with pytest.raises(SceneError, match="the session layer: shows no take"):
        keep_take(opened, Selection(), NOW)


def test_an_option_out_of_range_leaves_nothing(shot, opened):
    with pytest.raises(UsdfootError, match="crossfade"):
        animate_again(opened, ONE, NOW, seam="glue")
    with pytest.raises(UsdfootError, match="between 0 and 1"):
        animate_again(opened, ONE, NOW, root_weight=2.0)
    assert not (shot / "crowd" / "takes").exists()
    assert opened.GetSessionLayer().empty
