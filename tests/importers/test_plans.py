"""Footsteps from other programs: what the files say is what the plans are; what is wrong is named with its line."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from numpy.testing import assert_allclose

from tests.importers.step_files import recording_of, stp_of
from tests.strategies import footstep_plans
from usdfoot.errors import PlanError, SceneError
from usdfoot.importers.foot_recordings import import_foot_recording
from usdfoot.importers.plan_table import import_plan_table
from usdfoot.importers.stp import import_stp
from usdfoot.model.limits import Limits

TABLE = """\
foot,x,y,z,yaw,strike,liftoff
left,0.1,0,0,0,0.5,1.2
R,-0.1,0,0.5,90,1.0,1.7
left,0.1,0.2,1,-180,1.5,2.2
"""


def table(folder, text: str, **options):
    (folder / "walk.csv").write_bytes(text.encode())
    return import_plan_table(folder / "walk.csv", **options)


def stp(folder, text: str, **options):
    (folder / "walk.stp").write_text(text)
    return import_stp(folder / "walk.stp", **{"unit": "in", **options})


def test_a_row_is_a_footstep(tmp_path):
    (plan,) = table(tmp_path, TABLE).values()
    assert plan.sides.tolist() == [0, 1, 0] and plan.styles == ()
    assert_allclose(plan.positions, [(0.1, 0, 0), (-0.1, 0, 0.5), (0.1, 0.2, 1.0)])
    assert_allclose(np.abs(plan.yaws), [0.0, np.pi / 2, np.pi])
    assert_allclose([plan.strike_times, plan.liftoff_times], [(0.5, 1.0, 1.5), (1.2, 1.7, 2.2)])


@pytest.mark.parametrize("separator", [";", "\t"])
def test_decimal_commas_of_spreadsheets(tmp_path, separator):
    (plan,) = table(tmp_path, TABLE).values()
    (other,) = table(tmp_path, TABLE.replace(",", separator).replace(".", ",")).values()
    assert "0,1" in TABLE.replace(",", separator).replace(".", ",")
    assert_allclose(other.positions, plan.positions)
    assert_allclose(other.strike_times, plan.strike_times)


def test_separators_order_units_axes_and_further_columns(tmp_path):
    (plan,) = table(tmp_path, TABLE).values()
    lines = TABLE.splitlines()
    shuffled = "\ufeff# a walk\r\n" + "\r\n".join([lines[0], "", *lines[:0:-1]]).replace(",", ";") + "\r\n"
    (other,) = table(tmp_path, shuffled, unit="cm").values()
    assert_allclose(other.positions, 0.01 * plan.positions)
    assert other.sides.tolist() == plan.sides.tolist()
    text = "\n".join(
        f"{line},{more}" for line, more in zip(lines, ("style,root_weight,plan", "old,,a", ",.5,a", ",,a"), strict=True)
    )
    again = table(tmp_path, text + "\n" + "\n".join(f"{line},,,b" for line in lines[1:]))
    assert list(again) == ["a", "b"] and again["a"].styles == ("old", "", "") and again["b"].styles == ()
    assert_allclose(again["a"].root_weights, [0.0, 0.5, 0.0])
    (turned,) = table(tmp_path, TABLE, up="Z").values()
    assert_allclose(turned.positions, plan.positions[:, [0, 2, 1]] * (1.0, 1.0, -1.0))
    assert_allclose(turned.yaws, plan.yaws)
    (tilted,) = table(
        tmp_path, "\n".join(f"{line},{n}" for line, n in zip(lines, ("nx,ny,nz", *["0,2,1"] * 3), strict=True))
    ).values()
    assert_allclose(tilted.normals, np.tile(np.array([0.0, 2.0, 1.0]) / np.sqrt(5.0), (3, 1)), atol=1e-12)
    assert_allclose(tilted.yaws[:2], plan.yaws[:2], atol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("foot,x", "side,x", r"walk.csv:1: lacks columns: foot. known are plan,foot"),
        ("liftoff", "liftoff,colour", r"walk.csv:1: has unknown columns: colour"),
        ("liftoff", "liftoff,x", r"walk.csv:1: has a column twice"),
        ("R,", "toe,", r"walk.csv:3: 'toe' is no foot"),
        ("1.0,1.7", "1.0,soon", r"walk.csv:3: 'soon' is no finite number"),
        ("1.0,1.7", "inf,1.7", r"walk.csv:3: 'inf' is no finite number"),
        ("1.0,1.7", "1.0", r"walk.csv:3: has 6 cells, the header has 7"),
        ("1.0,1.7", "1.0,0.7", r"walk.csv \(walk\): footstep 1 lifts off at 0.7 s, not after its strike"),
        ("R,", "L,", r"walk.csv \(walk\): footsteps 0 and 1 are both left"),
        (TABLE, "", r"walk.csv: is empty. a header comes first"),
        (TABLE, TABLE.splitlines()[0], r"walk.csv: has no footsteps"),
    ],
)
def test_what_is_wrong_with_a_table_is_named(tmp_path, old, new, message):
    assert old in TABLE
    with pytest.raises(PlanError, match=message):
        table(tmp_path, TABLE.replace(old, new, 1))


@hypothesis_settings(max_examples=15)
@given(plan=footstep_plans())
def test_an_stp_file_says_what_its_plan_is(plan, tmp_path_factory):
    found = stp(tmp_path_factory.mktemp("stp"), stp_of(plan))
    assert found.sides.tolist() == plan.sides.tolist()
    assert_allclose(found.positions, plan.positions, atol=1e-6)
    assert_allclose(np.cos(found.yaws - plan.yaws), 1.0, atol=1e-9)
    assert_allclose(found.strike_times, plan.strike_times, atol=2 / 4800)
    assert_allclose(found.liftoff_times, plan.liftoff_times, atol=2 / 4800)


def two_steps() -> str:
    rows = ["1 0 0", "0 1 0", "0 0 1"]
    legs = ["RLEG", "1", "step0", "2400", "2880", "1", "LLEG", "1", "step0", "0", "2880", "0"]
    return "\n".join(["VERSION", "54", "STEPS", "2", *rows, "0 3 0", *rows, "20 -3 0", "SCORE", *legs, "SCALE"])


def test_what_an_stp_file_does_not_say_is_asked_for(tmp_path):
    plan = stp(tmp_path, two_steps(), unit="0.5", ticks=2400.0)
    assert plan.sides.tolist() == [0, 1]
    assert_allclose(plan.positions, [(0, 0, -1.5), (10, 0, 1.5)])
    assert_allclose(plan.yaws, np.pi / 2)
    assert_allclose(plan.strike_times, [0.0, 1.0])
    with pytest.raises(PlanError, match=r"walk.stp: does not say in which unit its lengths are. give --unit"):
        stp(tmp_path, two_steps(), unit="")
    with pytest.raises(SceneError, match="has 2 footsteps, more than 1"):
        stp(tmp_path, two_steps(), limits=Limits(footsteps=1))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("VERSION", "STEPS", r"walk.stp:1: 'STEPS' stands where VERSION was expected"),
        ("54", "60", r"walk.stp:2: is version 60. version 54 is known"),
        ("STEPS\n2", "STEPS\n2.5", r"walk.stp:4: '2.5' is no number of footsteps"),
        ("STEPS\n2", "STEPS\n9", r"walk.stp: is cut off: 9 footsteps need 36 rows"),
        ("STEPS\n2", "STEPS\n3", r"walk.stp:13: has 1 numbers where there are 3"),
        ("0 3 0", "0 x 0", r"walk.stp:8: 'x' is no finite number"),
        ("1 0 0", "2 0 0", r"walk.stp:5: begins the matrix of footstep 0, whose axes are no rotation"),
        ("RLEG\n1", "RLEG\n2", r"walk.stp:22: 'step0' is no finite number"),
        ("2880\n1", "2880\n7", r"walk.stp:19: '7' is no index of a footstep"),
        ("2880\n1", "2880\n0", r"walk.stp:22: footstep 0 is timed twice"),
        ("LLEG\n1\nstep0\n0\n2880\n0", "LLEG\n0", r"walk.stp: footstep 0 belongs to no leg"),
        ("LLEG\n1\nstep0\n0\n2880\n0\nSCALE", "", r"walk.stp: ends where RLEG or LLEG|LLEG or RLEG"),
    ],
)
def test_what_is_wrong_with_an_stp_file_is_named(tmp_path, old, new, message):
    assert old in two_steps()
    with pytest.raises(PlanError, match=message):
        stp(tmp_path, two_steps().replace(old, new, 1))


WALK = [(0.0, 0.5, 0, 0.0, -0.1, 0.0), (0.5, 1.0, 1, 0.7, 0.1, 0.2), (1.0, 1.4, 0, 1.4, -0.1, 0.0)]


@pytest.mark.parametrize("kind", [3, 4, 5])
def test_a_recording_has_the_footsteps_of_its_agents(tmp_path, kind):
    stops = [*WALK, (1.4, 1.9, 0, 1.4, -0.1, 0.0), (1.9, 2.3, 1, 2.0, 0.1, 0.0)]
    (tmp_path / "a.foot").write_bytes(recording_of([WALK, stops, WALK[:1]], kind=kind))
    plans, (problem,) = import_foot_recording(tmp_path / "a.foot")
    assert list(plans) == ["agent_0", "agent_1"] and "(agent 2): has 1 footstep" in problem.message
    plan = plans["agent_0"]
    assert plan.sides.tolist() == [0, 1, 0]
    assert_allclose(plan.positions, [(0, 0, -0.1), (0.7, 0, 0.1), (1.4, 0, -0.1)], atol=1e-6)
    assert_allclose(plan.yaws, np.pi / 2 - np.array([0.0, 0.2, 0.0]), atol=1e-6)
    assert_allclose(plan.strike_times, [0.0, 0.5, 1.0])
    assert_allclose(plan.liftoff_times, [0.6, 1.1, 1.48], atol=1e-6)
    standing = plans["agent_1"]
    assert standing.sides.tolist() == [0, 1, 0, 1]
    assert_allclose([standing.strike_times[2], standing.liftoff_times[2]], [1.0, 1.9 + 0.2 * 0.9], atol=1e-6)


def test_what_is_wrong_with_a_recording_is_named(tmp_path):
    whole = recording_of([WALK])
    file = tmp_path / "a.rec"
    for data, message in (
        (whole[:10], r"a.rec: ends at byte 10, 1 records from byte 0 on need 20"),
        (whole[:-1], r"a.rec: ends at byte \d+, 3 records"),
        (b"\2" + whole[1:], r"a.rec: has format 2. recordings of footsteps have 3, 4 or 5"),
        (recording_of([WALK[:1]]), r"a.rec: no agent has a plan: .*has 1 footstep"),
        (recording_of([[WALK[0], WALK[2]]]), r"footsteps 0 and 1 are both left"),
        (recording_of([[(np.nan, 1.0, 0, 0.0, 0.0, 0.0)]]), r"has footsteps that are no numbers"),
    ):
        file.write_bytes(data)
        with pytest.raises(PlanError, match=message):
            import_foot_recording(file)
    with pytest.raises(SceneError, match="has 2 agents, more than 1"):
        file.write_bytes(recording_of([WALK, WALK]))
        import_foot_recording(file, limits=Limits(agents=1))
