"""Plans in and out: a plan exported and imported again is the same plan, and what is imported can be walked."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from pxr import Usd

from tests.importers.step_files import recording_of, stp_of
from tests.strategies import footstep_plans, seeds
from usdfoot.bridge.units import StageUnits
from usdfoot.cli.main import main
from usdfoot.errors import OutputError, SceneError
from usdfoot.maths import quaternion
from usdfoot.model.plan import FootstepPlan
from usdfoot.pipeline.import_plans import PlanFormat, export_plans, import_plans
from usdfoot.readers.plans import read_plan
from usdfoot.readers.stage import read_stage_info
from usdfoot.writers.plans import PlannedAgent, write_plans

HALF = 2e-3
"""Orientations of point instancers are in half precision [rad]."""


def read_back(file) -> dict[str, FootstepPlan]:
    stage = Usd.Stage.Open(str(file))
    prims = stage.GetPrimAtPath("/Plans").GetChildren()
    return {prim.GetName(): read_plan(prim, read_stage_info(stage).units)[0] for prim in prims}


def assert_same(found: FootstepPlan, plan: FootstepPlan) -> None:
    assert found.sides.tolist() == plan.sides.tolist() and found.styles == plan.styles
    assert_allclose(found.positions, plan.positions, atol=1e-5)
    apart = quaternion.to_rotation_vector(quaternion.compose(quaternion.inverse(found.orientations), plan.orientations))
    assert np.linalg.norm(apart, axis=1).max() < HALF
    assert_allclose(found.strike_times, plan.strike_times, atol=1e-5)
    assert_allclose(found.liftoff_times, plan.liftoff_times, atol=1e-5)
    assert_allclose(found.root_weights, plan.root_weights, atol=1e-6)


@st.composite
def any_plans(draw: st.DrawFn) -> FootstepPlan:
    """Plans on slopes, with styles and root weights or without."""
    plan = draw(footstep_plans())
    generator = np.random.default_rng(draw(seeds))
    tilt = quaternion.from_rotation_vector(generator.uniform(-0.3, 0.3, (len(plan), 3)) * draw(st.booleans()))
    styled = draw(st.booleans())
    return FootstepPlan(
        **{
            **vars(plan),
            "orientations": quaternion.compose(tilt, plan.orientations),
            "styles": tuple("old" if i % 3 else "" for i in range(len(plan))) if styled else (),
            "root_weights": generator.uniform(0.0, 1.0, len(plan)) * draw(st.booleans()),
        }
    )


@hypothesis_settings(max_examples=15)
@given(plans=st.lists(any_plans(), min_size=1, max_size=3), up=st.sampled_from("YZ"))
def test_what_is_exported_and_imported_again_is_the_same(plans, up, tmp_path_factory):
    folder = tmp_path_factory.mktemp("plans")
    named = [PlannedAgent(name=f"p{index}", plan=plan) for index, plan in enumerate(plans)]
    units = StageUnits(meters_per_unit=0.01, up_axis=up, time_codes_per_second=48.0)
    first = write_plans(folder / "plans.usdc", named, units=units, frames_per_second=24.0)
    exported = export_plans(first, folder / "plans.csv")
    report = import_plans([exported.file], folder / "again.usdc", scene=first)
    assert report.problems == () and len(report.plans) == len(plans)
    again = read_back(folder / "again.usdc")
    for found, plan in zip(again.values(), plans, strict=True):
        assert_same(found, plan)


def test_files_of_several_programs_become_one_layer(tmp_path, capsys):
    (tmp_path / "table.csv").write_text("foot,x,y,z,yaw,strike,liftoff\nl,0,0,0,0,0,1\nr,0,0,1,0,0.5,1.5\n")
    steps = [(0.0, 0.5, 0, 0.0, 0.1, 0.0), (0.5, 1.0, 1, 0.7, -0.1, 0.0)]
    (tmp_path / "crowd.foot").write_bytes(recording_of([steps, steps]))
    plan = next(iter(import_plans([tmp_path / "table.csv"], tmp_path / "one.usda").plans.values()))
    (tmp_path / "biped.stp").write_text(stp_of(plan))
    (tmp_path / "bad.csv").write_text("foot\n")
    files = [str(tmp_path / name) for name in ("table.csv", "crowd.foot", "biped.stp", "bad.csv")]
    assert main(["import", *files, "--unit", "in", "-o", str(tmp_path / "all.usda"), "-q"]) == 1
    assert "bad.csv:1: lacks columns" in capsys.readouterr().err
    found = read_back(tmp_path / "all.usda")
    assert list(found) == ["table", "crowd_agent_0", "crowd_agent_1", "biped"]
    assert_allclose(found["table"].positions[1], (0.0, 0.0, 0.0254))
    assert_same(found["biped"], plan)
    assert main(["export", str(tmp_path / "all.usda"), "-o", str(tmp_path / "all.csv"), "-q"]) == 0
    lines = (tmp_path / "all.csv").read_text().splitlines()
    assert lines[0] == "plan,foot,x,y,z,yaw,strike,liftoff" and len(lines) == 9
    assert main(["import", str(tmp_path / "table.csv"), str(tmp_path / "walk.bvh"), "-o", "x.usda"]) == 2
    assert "are of several kinds" in capsys.readouterr().err


def test_exports_that_cannot_be(tmp_path):
    Usd.Stage.CreateNew(str(tmp_path / "empty.usda")).Save()
    with pytest.raises(SceneError, match="has no footstep plan"):
        export_plans(tmp_path / "empty.usda", tmp_path / "plans.csv")
    (tmp_path / "table.csv").write_text("foot,x,y,z,yaw,strike,liftoff\nl,0,0,0,0,0,1\nr,0,0,1,0,0.5,1.5\n")
    import_plans([tmp_path / "table.csv"], tmp_path / "plans.usda", plan_format=PlanFormat(up="Z"))
    with pytest.raises(OutputError, match=r"name a file that ends in \.csv"):
        export_plans(tmp_path / "plans.usda", tmp_path / "plans.txt")


def test_real_footsteps_go_out_and_in(shared_data, tmp_path):
    scene = shared_data / "scenes" / "walk_flat.usda"
    report = export_plans(scene, tmp_path / "walk.csv")
    (plan,) = report.plans.values()
    again = import_plans([tmp_path / "walk.csv"], tmp_path / "walk.usda", scene=scene)
    assert Usd.Stage.Open(str(again.file)).GetTimeCodesPerSecond() == 30.0
    (found,) = read_back(again.file).values()
    assert_same(found, plan)
