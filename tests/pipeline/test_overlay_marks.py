"""What is drawn on footsteps, for plans whose every number is known."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from tests.writers.crowds import results_of
from usdfoot.analysis.phases import DOUBLE, LEFT_STANCE, RIGHT_STANCE
from usdfoot.maths import quaternion
from usdfoot.model.overlay import ShownAgent
from usdfoot.model.plan import FootstepPlan
from usdfoot.pipeline.overlay_com import PHASE_COLORS, draw_com
from usdfoot.pipeline.overlay_marks import (
    TALLEST,
    mark_contacts,
    mark_errors,
    mark_footsteps,
    mark_timing,
    tabulate_steps,
)

RATE = 30.0


def walker(name="Walker", *, shift=0.0, statuses=("ok", "ok", "ok", "ikLimited"), heading=0.0):
    """Four steps of 0.5 s, 0.6 s on the ground each, straight ahead at a heading."""
    turn = quaternion.yaw_quaternion(np.array(heading))
    places = np.array([[0.1, 0.0, 0.0], [-0.1, 0.0, 0.6], [0.1, 0.0, 1.2], [-0.1, 0.0, 1.8]])
    strikes = shift + 0.5 * np.arange(4)
    times = np.arange(shift, shift + 2.2, 1.0 / RATE)
    com = np.stack([np.zeros_like(times), np.ones_like(times), 1.2 * (times - shift)], axis=1)
    return ShownAgent(
        name=name,
        plan=FootstepPlan(
            name=name,
            sides=np.array([0, 1, 0, 1]),
            positions=quaternion.rotate(turn, places),
            orientations=np.tile(turn, (4, 1)),
            strike_times=strikes,
            liftoff_times=strikes + 0.6,
            root_weights=np.zeros(4),
        ),
        foot_length=0.14,
        results=replace(
            results_of(4),
            status=statuses,
            blend_error=np.array([0.0, 0.001, 0.002, 0.5]),
            placement_error=np.array([np.nan, 0.0, 0.0, 0.3]),
        ),
        com_times=times,
        com_positions=quaternion.rotate(turn, com),
    )


def test_prints_lie_on_their_footsteps_in_the_colour_of_their_status():
    marks = mark_footsteps(tabulate_steps([walker()]))
    assert [marks.shapes[kind].name for kind in marks.kinds[0]] == ["Left", "Right", "Left", "IkLimitedRight"]
    assert len({marks.shapes[kind].color for kind in marks.kinds[0]}) == 3
    assert_allclose(marks.positions[0, :, [0, 2]].T, walker().plan.positions[:, [0, 2]], atol=1e-12)
    assert_array_equal(marks.footsteps, [0, 1, 2, 3])


def test_columns_are_as_high_as_the_errors_and_end_somewhere():
    blend, placement = mark_errors(tabulate_steps([walker()]), scale=100.0)
    heights = blend.scales[0, :, 1]
    assert_allclose(heights[1:], [0.1, 0.2, TALLEST], atol=1e-12)
    assert 0.0 < heights[0] < 0.01
    assert_allclose(blend.positions[0], walker().plan.positions, atol=1e-12)
    assert [blend.shapes[kind].name for kind in blend.kinds[0]] == ["Column"] * 3 + ["Beyond"]
    assert_array_equal(placement.footsteps, [1, 2, 3])  # nothing recorded, nothing drawn


def test_contacts_show_the_feet_that_stand_at_every_frame():
    agents = [walker(), walker("Other", shift=0.3)]
    times = np.arange(0.0, 2.6, 1.0 / RATE)
    marks = mark_contacts(tabulate_steps(agents), times)
    for number, agent in enumerate(agents):
        plan = agent.plan
        for side in (0, 1):
            column = 2 * number + side
            down = (times[:, None] >= plan.strike_times - 1e-6) & (times[:, None] <= plan.liftoff_times + 1e-6)
            down &= plan.sides == side
            assert_array_equal(~marks.hidden[:, column], down.any(axis=1))
            shown = np.flatnonzero(down.any(axis=1))
            expected = plan.positions[down[shown].argmax(axis=1)]
            assert_allclose(marks.positions[shown, column][:, [0, 2]], expected[:, [0, 2]], atol=1e-12)
            assert (
                marks.agents[column] == number and marks.shapes[marks.kinds[0, column]].name == ("Left", "Right")[side]
            )


def test_a_contact_never_slides_to_the_next_while_it_is_seen():
    times = np.arange(0.0, 2.6, 0.45)  # frames so coarse that swings fall between two of them
    marks = mark_contacts(tabulate_steps([walker()]), times)
    moved = (marks.positions[1:] != marks.positions[:-1]).any(axis=-1)
    assert moved.any()
    assert marks.hidden[:-1][moved].all()


@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_daggers_measure_stance_and_step_time_on_the_outer_side(heading):
    steps = tabulate_steps([walker(heading=heading)])
    marks = mark_timing(steps, scale=0.5)
    bars, crossbars = (marks.kinds[0] == kind for kind in (0, 1))
    assert_allclose(marks.scales[0, bars, 0], 0.5 * 0.6)
    assert_array_equal(marks.footsteps[crossbars], [0, 1, 2])  # nothing follows the last
    begins = marks.positions[0, bars]
    assert_allclose(np.linalg.norm(marks.positions[0, crossbars] - begins[:3], axis=1), 0.5 * 0.5)
    undone = quaternion.inverse(quaternion.yaw_quaternion(np.array(heading)))
    beside = quaternion.rotate(undone, begins - walker(heading=heading).plan.positions)[:, 0]
    assert (np.sign(beside) == [1, -1, 1, -1]).all()  # left is +X
    out = quaternion.rotate(undone, marks.positions[0, crossbars] - begins[:3])[:, 0]
    assert (np.sign(out) == [1, -1, 1]).all()


def test_the_com_is_coloured_by_the_feet_that_stand():
    agent = walker()
    lines = draw_com([agent, walker("Other", shift=0.3)])
    assert lines.counts.sum() == len(lines.points) == len(lines.colors)
    own = slice(0, lines.counts[0])
    times = lines.points[own, 2] / 1.2
    assert times[0] == pytest.approx(0.0) and times[-1] == pytest.approx(2.1, abs=1.0 / RATE)
    inside = {LEFT_STANCE: (0.2, 0.4), DOUBLE: (0.52, 0.58), RIGHT_STANCE: (0.7, 0.9)}
    for phase, (begin, end) in inside.items():
        picked = (times > begin) & (times < end)
        assert picked.any()
        assert_array_equal(lines.colors[own][picked], np.tile(PHASE_COLORS[phase], (picked.sum(), 1)))
    changes = np.flatnonzero((lines.colors[own][1:] != lines.colors[own][:-1]).any(axis=1))
    assert_allclose(lines.points[own][changes], lines.points[own][changes + 1], atol=1e-12)  # sharp
    assert_allclose(
        times[changes], np.sort(np.concatenate([agent.plan.strike_times[1:], agent.plan.liftoff_times[:3]]))
    )
