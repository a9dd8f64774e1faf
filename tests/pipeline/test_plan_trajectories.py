"""Plans of agents with trajectories: they step and fly as their clips do."""

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom

from tests.few_clips import copy_stages
from tests.pipeline.test_plan import composed
from tests.scenes import Units, add_agent, new_stage
from usdfoot.bridge.tokens import Agent
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.plan_trajectories import plan_scene_trajectories
from usdfoot.pipeline.validate import validate

RUNS = ("jog_180", "jog_220", "run_260", "run_320", "run_400", "walk_100", "walk_130", "walk_160", "stand")
LENGTH = 8.0
"""Of the shot [s]."""


def speeds_up(time):
    """How far somebody has gone who walks at 1 m/s, runs at 4 m/s after 5 s, and stops at 8 s [m]."""
    times = np.linspace(0.0, LENGTH, 801)
    speeds = np.interp(times, [0.0, 1.0, 5.0, 6.0, 7.5], [1.0, 1.0, 4.0, 4.0, 0.0])
    return float(np.interp(time, times, np.append(0.0, np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * 0.01))))


@pytest.fixture
def scene(stages, tmp_path):
    """A runner and a robot of the same character, the second moved by physics, on like tracks."""
    copy = copy_stages(stages, tmp_path, kept=RUNS)
    stage = new_stage(tmp_path / "scene.usda", Units(rate=30.0))
    stage.SetEndTimeCode(LENGTH * 30.0)
    for name, asset in (("Motion", "clips.usdc"), ("Person", "human.usdc")):
        stage.DefinePrim(f"/World/{name}").GetReferences().AddReference(str(copy / asset))
    for name, x in (("Runner", 0.0), ("Robot", 4.0)):
        op = UsdGeom.Xform.Define(stage, f"/World/{name}Track").AddTranslateOp()
        for code in range(int(LENGTH * 30.0) + 1):
            op.Set(Gf.Vec3d(x, 0.0, speeds_up(code / 30.0)), code)
        prim = add_agent(
            stage,
            f"/World/{name}",
            trajectory=f"/World/{name}Track",
            character="/World/Person",
            clips="/World/Motion/Clips",
        )
    prim.CreateAttribute(Agent.MOTION, Sdf.ValueTypeNames.Token, custom=False).Set("physics")
    stage.GetRootLayer().Save()
    return tmp_path / "scene.usda"


def test_who_speeds_up_steps_and_flies_as_its_clips_do_and_not_as_people_do(scene, tmp_path):
    runner, robot = (
        plan_scene_trajectories(scene, tmp_path / f"{name}.usdc", agents=name).plans[name]
        for name in ("Runner", "Robot")
    )
    flights = [plan.strike_times[1:] - plan.liftoff_times[:-1] for plan in (runner, robot)]
    assert all((each > 0.0).sum() > 4 for each in flights)
    longest = [each.max() for each in flights]
    assert longest[0] > longest[1] + 0.02
    assert np.median(np.diff(runner.strike_times)[2:-2]) != pytest.approx(np.median(np.diff(robot.strike_times)[2:-2]))


def test_who_speeds_up_and_stops_stays_within_all_targets(scene, tmp_path):
    plan_scene_trajectories(scene, tmp_path / "plans.usdc", agents="Runner")
    crowd = animate(composed(tmp_path / "plans.usdc", scene), tmp_path / "crowd", agents="Runner").crowd_file
    (agent,) = validate(crowd).agents
    assert [figure.name for figure in agent.figures if not figure.passed] == []


def test_feet_of_quick_walks_stand_together_no_longer_than_in_the_clips(shared_data, tmp_path):
    """At 1.9 m/s all but no time: people's feet do for a tenth of the step."""
    stage = new_stage(tmp_path / "scene.usda", Units(meters=0.01, rate=30.0))
    for name in ("character", "clips"):
        stage.DefinePrim(f"/World/{name}").GetReferences().AddReference(
            str(shared_data / "bandai" / f"bandai_{name}.usdc")
        )
    op = UsdGeom.Xform.Define(stage, "/World/Track").AddTranslateOp()
    for code in (0.0, 180.0):
        op.Set(Gf.Vec3d(0.0, 0.0, 190.0 * code / 30.0), code)
    add_agent(stage, "/World/Walker", trajectory="/World/Track", character="/World/character", clips="/World/clips")
    stage.GetRootLayer().Save()
    (plan,) = plan_scene_trajectories(tmp_path / "scene.usda", tmp_path / "plans.usdc").plans.values()
    together = plan.liftoff_times[2:-4] - plan.strike_times[3:-3]
    assert np.median(together) < 0.06 * np.median(np.diff(plan.strike_times))
