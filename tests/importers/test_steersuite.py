"""SteerSuite test cases: what they say becomes walkers, goals and obstacles; what is wrong is named with its line."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from usdfoot.errors import SceneError
from usdfoot.importers.steersuite import import_steersuite
from usdfoot.planning.world import World, clearances

HEADER = (
    "<header><version>1.0</version><name>n</name><worldBounds><xmin>-20</xmin><xmax>20</xmax><ymin>0</ymin>"
    "<ymax>0</ymax><zmin>-10</zmin><zmax>10</zmax></worldBounds></header>\n"
)
BOX = "<xmin>{}</xmin><xmax>{}</xmax><ymin>0</ymin><ymax>1</ymax><zmin>{}</zmin><zmax>{}</zmax>"
START = (
    "<initialConditions><radius>0.4</radius>{}<direction><x>1</x><y>0</y><z>0</z></direction><speed>0</speed>"
    "</initialConditions>"
)
AT = "<position><x>1</x><y>0</y><z>2</z></position>"
SEEK = "<seekStaticTarget><targetLocation>{}</targetLocation><desiredSpeed>1.1</desiredSpeed></seekStaticTarget>"
PLACE = "<x>{}</x><y>0</y><z>{}</z>"


def case(tmp_path, *parts: str, head: str = HEADER):
    file = tmp_path / "case.xml"
    body = "\n".join(parts)
    file.write_text(
        f'<SteerBenchTestCase xmlns="http://www.magix.ucla.edu/steerbench">\n{head}{body}\n</SteerBenchTestCase>'
    )
    return file


def read(file, seed: int = 0):
    return import_steersuite(file, generator=np.random.default_rng(seed))


def agent(goals: str, start: str = AT) -> str:
    return f"<agent><name>A</name>{START.format(start)}<goalSequence>{goals}</goalSequence></agent>"


def test_an_agent_its_goals_in_order_and_obstacles(tmp_path):
    goals = SEEK.format(PLACE.format(5, 6)) + SEEK.format(PLACE.format(-7, 8))
    corners = [PLACE.format(*corner) for corner in ((0, 0), (1, 0), (0, 1))]
    file = case(
        tmp_path,
        f"<obstacle>{BOX.format(1, 2, 3, 4)}</obstacle>",
        f"<circleObstacle><radius>2</radius><position>{PLACE.format(9, 1)}</position></circleObstacle>",
        f"<polygonObstacle>{''.join(f'<vertex>{corner}</vertex>' for corner in corners)}</polygonObstacle>",
        agent(goals),
    )
    scenario, problems = read(file)
    (walker,) = scenario.seekers
    assert problems == () and walker.name == "A" and walker.radius == 0.4 and walker.speed == 1.1
    assert_allclose(walker.start, [1.0, 0.0, 2.0])
    assert_allclose(walker.goals, [(5.0, 0.0, 6.0), (-7.0, 0.0, 8.0)])
    assert walker.yaw == pytest.approx(0.5 * np.pi), "+X"
    box, circle, triangle = scenario.obstacles
    assert_allclose([box.outline.min(axis=0), box.outline.max(axis=0)], [(1.0, 3.0), (2.0, 4.0)])
    assert_allclose(np.linalg.norm(circle.outline - [9.0, 1.0], axis=1), 2.0)
    assert_allclose(triangle.outline, [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
    assert_allclose([scenario.bounds.min(axis=0), scenario.bounds.max(axis=0)], [(-20.0, -10.0), (20.0, 10.0)])


def test_a_wall_with_a_doorway_is_two_boxes(tmp_path):
    wall = (
        "<orientedWallObstacle><thetaY>0</thetaY><size><x>8</x><y>1</y><z>0.5</z></size><position><x>1</x><y>0</y><z>2</z>"
        "</position><doorway><value>1</value><doorRadius>0.5</doorRadius></doorway></orientedWallObstacle>"
    )
    scenario, _ = read(case(tmp_path, wall, agent(SEEK.format(PLACE.format(5, 6)))))
    spans = [(o.outline[:, 0].min(), o.outline[:, 0].max()) for o in scenario.obstacles]
    assert_allclose(spans, [(-3.0, 1.5), (2.5, 5.0)])


def test_regions_are_filled_clear_of_everything_by_the_seed(tmp_path):
    region = f"<regionBounds>{BOX.format(-8, 8, -8, 8)}</regionBounds>"
    here = START.format("").replace("<x>1</x><y>0</y><z>0</z>", "<random>true</random>")
    file = case(
        tmp_path,
        f"<obstacleRegion><numObstacles>5</numObstacles>{region}<obstacleSize>1</obstacleSize><obstacleHeight>1</obstacleHeight></obstacleRegion>",
        f"<agentRegion><numAgents>30</numAgents>{region}{here}<goalSequence>{SEEK.format('<random>true</random>')}</goalSequence></agentRegion>",
    )
    scenario, _ = read(file)
    starts = np.array([walker.start[[0, 2]] for walker in scenario.seekers])
    goals = np.array([walker.goals[0][[0, 2]] for walker in scenario.seekers])
    world = World(obstacles=scenario.obstacles)
    assert len(scenario.obstacles) == 5 and len(starts) == 30 and np.abs(starts).max() <= 8.0
    assert clearances(world, np.vstack([starts, goals])).min() >= 0.4
    assert (np.linalg.norm(starts[:, None] - starts, axis=2) + 9.0 * np.eye(30)).min() >= 0.8
    again, other = read(file)[0], read(file, 1)[0]
    assert_allclose([walker.start for walker in again.seekers], [walker.start for walker in scenario.seekers], rtol=0)
    assert np.any(np.abs(other.seekers[0].start - scenario.seekers[0].start) > 1e-3)


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("<obstacle><xmin>1</xmin></obstacle>", r"case\.xml, line 3, <obstacle>: has no <zmin>"),
        (f"<obstacle>{BOX.format('a', 2, 3, 4)}</obstacle>", r"line 3, <xmin>: holds 'a'\. a number is needed"),
        ("<wall/>", r"line 3, <wall>: is not part of a SteerSuite test case"),
        ("<agent>\n<name>A</name></agent>", r"line 3, <agent>: has no <initialConditions>"),
        (agent("", AT).replace(">0.4<", ">-1<"), r"<radius>: is -1\. it must be more than 0"),
        ("<agent>", r"line 4: is not well-formed XML \(mismatched tag\)"),
        (
            f"<agentRegion><numAgents>99</numAgents><regionBounds>{BOX.format(0, 2, 0, 2)}</regionBounds>"
            f"{START.format('')}<goalSequence/></agentRegion>",
            r"<regionBounds>: has no room for another agent of radius 0\.4 m",
        ),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path, body, message):
    with pytest.raises(SceneError, match=message):
        read(case(tmp_path, body))


def test_a_dtd_is_refused_before_it_expands(tmp_path):
    file = tmp_path / "bomb.xml"
    file.write_text('<!DOCTYPE a [<!ENTITY b "bb"><!ENTITY c "&b;&b;">]>\n<a>&c;</a>')
    with pytest.raises(SceneError, match=r"bomb\.xml, line 1: declares a DTD"):
        read(file)
    with pytest.raises(SceneError, match="cannot be read"):
        read(tmp_path / "missing.xml")
    other = tmp_path / "other.xml"
    other.write_text("<svg/>")
    with pytest.raises(SceneError, match="is no SteerSuite test case"):
        read(other)


def test_goals_that_are_no_places_are_left_out_with_a_warning(tmp_path):
    scenario, problems = read(
        case(tmp_path, agent("<fleeDynamicTarget><targetName>B</targetName></fleeDynamicTarget>"))
    )
    assert_allclose(scenario.seekers[0].goals, [(1.0, 0.0, 2.0)])
    assert [problem.severity for problem in problems] == ["warning"]
    assert "line 3, <fleeDynamicTarget>: is no place to go to" in problems[0].message


COUNTS = {
    "circle-20": (20, 0), "crossing-1": (2, 0), "curves": (1, 6), "doorway-two-way": (2, 4),
    "hallway-two-way": (200, 2), "maze": (1, 21), "oncoming-groups": (12, 0), "plain-unobstructed": (1, 0),
    "plane_egress": (105, 48),
}  # fmt: skip


@pytest.mark.parametrize("name", COUNTS)
def test_real_cases_are_read(shared_data, name):
    scenario, _ = read(shared_data / "steersuite" / f"{name}.xml")
    assert (len(scenario.seekers), len(scenario.obstacles)) == COUNTS[name]
