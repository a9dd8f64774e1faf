"""Agents with goals, obstacles and footholds as they are on a stage, in any units and axes."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Gf, Usd, UsdGeom, Vt

from tests.scenes import Units, new_stage
from usdfoot.bridge.tokens import Agent, Obstacle, Schema
from usdfoot.errors import SceneError
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.world import World, clearances
from usdfoot.readers.agents import list_agents_without_plans
from usdfoot.readers.goals import read_goal_agents
from usdfoot.readers.obstacles import read_obstacles
from usdfoot.readers.stage import collect_prims, read_stage_info
from usdfoot.readers.stones import read_stones
from usdfoot.readers.terrain import read_terrain

UNITS = [Units(), Units(meters=0.01, up="Z", rate=30.0)]


def put(stage: Usd.Stage, path: str, units: Units, place, yaw: float = 0.0) -> Usd.Prim:
    xform = UsdGeom.Xform.Define(stage, path)
    xform.AddTranslateOp().Set(Gf.Vec3d(*units.points(place).tolist()))
    turn = xform.AddRotateZOp() if units.up == "Z" else xform.AddRotateYOp()
    turn.Set(float(np.degrees(yaw)))
    return xform.GetPrim()


def author(prim: Usd.Prim, name: str, value: float) -> None:
    from pxr import Sdf

    prim.CreateAttribute(name, Sdf.ValueTypeNames.Float, custom=False, variability=Sdf.VariabilityUniform).Set(value)


def seekers(stage: Usd.Stage):
    prims, units = collect_prims(stage), read_stage_info(stage).units
    sources, problems = list_agents_without_plans(stage, prims, with_goals=True)
    agents, faults = read_goal_agents(stage, prims, units, sources=sources, speed=1.3, radius=0.25)
    return [agent.seeker for agent in agents], [*problems, *faults]


@pytest.mark.parametrize("units", UNITS)
def test_an_agent_stands_and_faces_as_its_prim_and_goes_to_its_goals(units):
    stage = new_stage(None, units)
    goals = [(1.0, 0.5, 4.0), (-3.0, 0.0, 2.0)]
    paths = [put(stage, f"/World/Goal_{i}", units, goal).GetPath() for i, goal in enumerate(goals)]
    prim = put(stage, "/World/A", units, (2.0, 0.5, -1.0), yaw=0.5)
    prim.AddAppliedSchema(Schema.AGENT)
    prim.CreateRelationship(Agent.GOAL, custom=False).SetTargets(paths)
    author(prim, Agent.SPEED, 0.9 / units.meters)
    (seeker,), problems = seekers(stage)
    assert problems == [] and seeker.name == "/World/A" and seeker.speed == pytest.approx(0.9)
    assert_allclose(seeker.start, (2.0, 0.5, -1.0), atol=1e-9)
    assert_allclose(seeker.goals, goals, atol=1e-9)
    assert seeker.yaw == pytest.approx(0.5)


def test_agents_without_goals_are_left_out_and_bad_ones_named():
    stage = new_stage()
    for name in ("Idle", "Lost", "Slow"):
        put(stage, f"/World/{name}", Units(), (0.0, 0.0, 0.0)).AddAppliedSchema(Schema.AGENT)
    lost, slow = (stage.GetPrimAtPath(f"/World/{name}") for name in ("Lost", "Slow"))
    lost.CreateRelationship(Agent.GOAL, custom=False).SetTargets(["/World/Nowhere"])
    slow.CreateRelationship(Agent.GOAL, custom=False).SetTargets(["/World/Idle"])
    author(slow, Agent.SPEED, -1.0)
    found, problems = seekers(stage)
    assert found == []
    assert "/World/Lost: usdfoot:agent:goal points at what does not exist: /World/Nowhere" in problems[0].message
    assert "/World/Slow: usdfoot:agent:speed is -1. author a number of at least 0" in problems[1].message


def clear(stage: Usd.Stage, *points):
    prims, units = collect_prims(stage), read_stage_info(stage).units
    obstacles, problems = read_obstacles(stage, prims, units)
    assert problems == ()
    return clearances(World(obstacles=obstacles), np.array(points, dtype=float))


@pytest.mark.parametrize("units", UNITS)
def test_outlines_of_solids_and_meshes_are_exact(units):
    stage = new_stage(None, units)
    cylinder = UsdGeom.Cylinder.Define(stage, "/World/Cylinder")
    cylinder.CreateAxisAttr(units.up)
    cylinder.CreateRadiusAttr(1.0 / units.meters)
    cylinder.CreateHeightAttr(2.0 / units.meters)
    cylinder.AddTranslateOp().Set(Gf.Vec3d(*units.points((5.0, 1.0, 0.0)).tolist()))
    corners = np.array([(0, 0), (0, 3), (1, 3), (1, 1), (2, 1), (2, 3), (3, 3), (3, 0)], dtype=float)  # a U
    points = np.concatenate([np.insert(corners, 1, height, axis=1) for height in (0.0, 1.0)])
    mesh = UsdGeom.Mesh.Define(stage, "/World/U")
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(units.points(points), dtype=np.float32)))
    mesh.CreateFaceVertexCountsAttr([8, 8])
    mesh.CreateFaceVertexIndicesAttr([*range(7, -1, -1), *range(8, 16)])
    for prim in (cylinder.GetPrim(), mesh.GetPrim()):
        prim.AddAppliedSchema(Schema.OBSTACLE)
        author(prim, Obstacle.MARGIN, 0.1 / units.meters)
    distances = clear(stage, (5.0, 3.0), (1.5, 2.5), (1.5, 0.5), (4.0, 6.0), (-1.0, 2.0))
    assert distances[0] == pytest.approx(2.0 - 0.1, abs=0.01)
    assert_allclose(distances[[1, 3, 4]], np.array([0.5, np.hypot(1.0, 3.0), 1.0]) - 0.1, atol=1e-5)
    assert distances[2] < 0.0, "in the bottom of the U"


def test_a_wall_without_thickness_and_everything_below_a_marked_prim_count():
    stage = new_stage()
    group = UsdGeom.Xform.Define(stage, "/World/Walls").GetPrim()
    group.AddAppliedSchema(Schema.OBSTACLE)
    author(group, Obstacle.MARGIN, 0.25)
    wall = UsdGeom.Mesh.Define(stage, "/World/Walls/Wall")
    wall.CreatePointsAttr([(0, 0, 0), (4, 0, 0), (4, 2, 0), (0, 2, 0)])
    wall.CreateFaceVertexCountsAttr([4])
    wall.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    assert_allclose(clear(stage, (2.0, 1.0)), 0.75, atol=1e-3)


@pytest.mark.parametrize("counts", [[4], [-2147483644, 2147483647]])
def test_an_obstacle_that_cannot_be_read_is_named(counts):
    stage = new_stage()
    mesh = UsdGeom.Mesh.Define(stage, "/World/Broken")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (1, 0, 1)])
    mesh.CreateFaceVertexCountsAttr(counts)
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2])
    mesh.GetPrim().AddAppliedSchema(Schema.OBSTACLE)
    _, problems = read_obstacles(stage, collect_prims(stage), read_stage_info(stage).units)
    assert "/World/Broken: is an obstacle whose faces do not match its points" in problems[0].message


@pytest.mark.parametrize(("shape", "name"), [("Cube", "size"), ("Sphere", "radius"), ("Capsule", "height")])
def test_an_obstacle_of_negative_size_is_named_and_the_others_stand(shape, name):
    stage = new_stage()
    for path, length in (("/World/Bad", -1.0), ("/World/Good", 1.0)):
        prim = stage.DefinePrim(path, shape)
        prim.AddAppliedSchema(Schema.OBSTACLE)
        prim.GetAttribute(name).Set(length)
    obstacles, (problem,) = read_obstacles(stage, collect_prims(stage), read_stage_info(stage).units)
    assert [obstacle.name for obstacle in obstacles] == ["/World/Good"]
    assert problem.message == f"/World/Bad: {name} is -1. author a number above 0"


@pytest.mark.parametrize("units", UNITS)
def test_points_are_footholds_where_they_are(units):
    stage = new_stage(None, units)
    places = np.array([(0.5, 0.2, 1.0), (0.4, 0.25, 1.7)])
    points = UsdGeom.Points.Define(stage, "/World/Stones")
    points.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(units.points(places), dtype=np.float32)))
    prims, stage_units = collect_prims(stage), read_stage_info(stage).units
    terrain, _ = read_terrain(stage, prims, stage_units)
    stones = read_stones(stage, stage_units, terrain, pattern="/World/St*", body=Proportions(), spacing=0.1)
    assert_allclose(stones.positions, places, atol=1e-6)
    with pytest.raises(SceneError, match="names no terrain mesh, Points or PointInstancer"):
        read_stones(stage, stage_units, terrain, pattern="/World/X", body=Proportions(), spacing=0.1)
