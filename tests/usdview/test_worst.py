"""The worst step of a crowd with one footstep that nobody can reach."""

import numpy as np
import pytest
from pxr import Sdf, Usd

from usdfoot.errors import SceneError
from usdfoot.usdview.selection import Selection
from usdfoot.usdview.worst import find_worst_step

NOW = Usd.TimeCode.Default()
ERRORS = "usdfoot:result:placementError"


@pytest.fixture
def missed(stage):
    """Agent_2 misses footstep 5 by 0.2 m, Agent_0 footstep 3 by 0.1 m."""
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        for agent, step, error in (("Agent_0", 3, 0.1), ("Agent_2", 5, 0.2)):
            attribute = stage.GetPrimAtPath(f"/Crowd/Plans/{agent}").GetAttribute(ERRORS)
            values = np.zeros(len(attribute.Get()))
            values[step], values[0] = error / 1.0, np.nan
            attribute.Set(values.tolist())
    yield stage
    stage.GetSessionLayer().Clear()


def test_it_is_found_with_its_time_and_prims(missed):
    worst = find_worst_step(missed, Selection(), NOW)
    plan = missed.GetPrimAtPath("/Crowd/Plans/Agent_2")
    assert (worst.agent, worst.plan, worst.number) == ("/Crowd/Agents/Agent_2", plan.GetPath(), 5)
    assert worst.time == Usd.TimeCode(float(plan.GetAttribute("usdfoot:plan:strikeTimes").Get()[5]))
    assert worst.placement_error == pytest.approx(0.2)
    assert worst.status == "ok"


def test_only_the_selected_agents_count(missed):
    chosen = Selection(paths=(Sdf.Path("/Crowd/Plans/Agent_0"),))
    assert (find_worst_step(missed, chosen, NOW).agent, find_worst_step(missed, chosen, NOW).number) == (
        "/Crowd/Agents/Agent_0",
        3,
    )


def test_a_crowd_without_results_is_said_to_have_none(stage):
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        for prim in stage.GetPrimAtPath("/Crowd/Plans").GetChildren():
            prim.GetAttribute(ERRORS).Block()
    with pytest.raises(SceneError, match="no results"):
        find_worst_step(stage, Selection(), NOW)
    stage.GetSessionLayer().Clear()
