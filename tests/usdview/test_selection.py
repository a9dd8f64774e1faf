"""Which agents and footsteps a selection means."""

import pytest
from pxr import Sdf, Usd

from usdfoot.errors import SceneError
from usdfoot.usdview.overlays import draw, remove_overlays
from usdfoot.usdview.selection import Footstep, Selection, selected_agents, selected_footstep

START = Usd.TimeCode(0.0)


def selection(*paths, **instances):
    return Selection(
        paths=tuple(Sdf.Path(path) for path in paths),
        instances={Sdf.Path(path.replace("__", "/")): frozenset(numbers) for path, numbers in instances.items()},
    )


@pytest.mark.parametrize(
    "path",
    [
        "/Crowd/Agents/Agent_1",
        "/Crowd/Agents/Agent_1/Body/Skin",
        "/Crowd/Plans/Agent_1",
        "/Crowd/Plans/Agent_1/Prints/Left",
        "/Crowd/Anims/Agent_1",
    ],
)
def test_any_prim_of_an_agent_means_the_agent(stage, path):
    assert selected_agents(stage, selection(path)) == ("Agent_1",)


def test_scopes_and_other_prims_mean_nobody(stage):
    assert selected_agents(stage, selection("/Crowd", "/Crowd/Agents", "/")) == ()


def test_instances_of_a_plan_are_footsteps(stage):
    path = Sdf.Path("/Crowd/Plans/Agent_2")
    chosen = Selection(paths=(path,), instances={path: frozenset([7])})
    assert selected_footstep(stage, chosen, START) == Footstep(agent="Agent_2", plan=path, number=7)
    with pytest.raises(SceneError, match="2 footsteps"):
        selected_footstep(stage, Selection(paths=(path,), instances={path: frozenset([7, 8])}), START)


def test_instances_of_an_overlay_are_footsteps_of_their_agents(stage):
    draw(stage, ("Agent_0", "Agent_2"), kinds=("Footsteps", "Com"))
    path = Sdf.Path("/__usdfoot/Footsteps")
    owners, names = (
        stage.GetPrimAtPath(path).GetAttribute(f"usdfoot:overlay:{key}").Get() for key in ("owners", "agents")
    )
    own = [number for number, owner in enumerate(owners) if names[owner] == "Agent_2"]
    chosen = Selection(paths=(path,), instances={path: frozenset([own[4]])})
    assert selected_footstep(stage, chosen, START).agent == "Agent_2"
    assert selected_footstep(stage, chosen, START).number == 4
    assert selected_agents(stage, chosen) == ("Agent_2",)
    assert set(selected_agents(stage, selection("/__usdfoot/Com"))) == {"Agent_0", "Agent_2"}
    remove_overlays(stage)


def test_an_agent_alone_means_the_footstep_that_came_down_last(stage):
    strikes = stage.GetPrimAtPath("/Crowd/Plans/Agent_1").GetAttribute("usdfoot:plan:strikeTimes").Get()
    time = Usd.TimeCode(0.5 * (float(strikes[5]) + float(strikes[6])))
    assert selected_footstep(stage, selection("/Crowd/Agents/Agent_1"), time).number == 5
    with pytest.raises(SceneError, match="3 agents"):
        selected_footstep(stage, Selection(), time)


def test_a_stage_without_agents_says_what_it_needs():
    with pytest.raises(SceneError, match=r"crowd\.usd"):
        selected_agents(Usd.Stage.CreateInMemory(), Selection())
