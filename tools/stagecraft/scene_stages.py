"""The scenes: people, clips and terrain by reference, footstep plans, agents."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from stagecraft.course import obstacle_course
from stagecraft.crowd import crowd_plans
from stagecraft.plan_prim import Plan, author_plan, last_code
from stagecraft.rotation import FloatArray
from stagecraft.stage_file import CODES_PER_SECOND, extent_of, new_stage, relate, uniform, vectors
from stagecraft.stones import stepping_stones
from stagecraft.terrain_stages import author_block
from stagecraft.terrains import hills
from stagecraft.trajectories import Way, tracked_ways, xform_ways


def write_scenes(folder: Path) -> None:
    """Write the obstacle course, the stepping stones, the crowd and the trajectories into `folder`."""
    _write_course(folder / "obstacle_course.usda")
    _write_stones(folder / "stepping_stones.usda")
    _write_crowd(folder / "crowd.usda")
    _write_trajectories(folder / "trajectories.usda")


def _write_course(path: Path) -> None:
    course = obstacle_course()
    stage = new_scene(path, [course.plan], "an obstacle course after Beacco et al. 2015, Figure 1")
    middle = course.ground.points.mean(axis=0)
    _terrain(stage, "Flat", "terrain_flat.usda", middle)
    _terrain(stage, "Slope", "terrain_slope.usda", course.slope_at, yaw=90.0)
    _terrain(stage, "Stairs", "terrain_stairs.usda", course.stairs_at)
    UsdGeom.Scope.Define(stage, "/World/Obstacles")
    for number, (centre, size) in enumerate(course.blocks):
        author_block(stage, f"/World/Obstacles/Block_{number}", centre, size, margin=0.05)
    _agent_is_character(stage, "Walker", course.plan)
    stage.Save()


def _write_stones(path: Path) -> None:
    plan = stepping_stones().plan
    stage = new_scene(path, [plan], "stepping stones after Beacco et al. 2015, Figure 7")
    _terrain(stage, "Stones", "terrain_stones.usda", np.zeros(3))
    put_character(stage)
    _separate_agent(stage, "Walker", plan)
    stage.Save()


def _write_crowd(path: Path) -> None:
    plans = crowd_plans([hills()])
    stage = new_scene(path, plans, "twelve people on hilly ground")
    _terrain(stage, "Hills", "terrain_hills.usda", np.zeros(3))
    put_character(stage)
    for plan in plans:
        _separate_agent(stage, plan.name, plan)
    stage.Save()


def _write_trajectories(path: Path) -> None:
    stage = new_scene(path, [], "six people who follow trajectories over hilly ground")
    _terrain(stage, "Hills", "terrain_hills.usda", np.zeros(3))
    put_character(stage)
    UsdGeom.Scope.Define(stage, "/World/Trajectories")
    for way in xform_ways(hills()):
        _author_xform(stage, f"/World/Trajectories/{way.name}", way)
        _follower(stage, way.name, f"/World/Trajectories/{way.name}")
    tracked = tracked_ways(hills())
    _author_points(stage, "/World/Trajectories/Tracked", tracked)
    for way in tracked:
        agent = _follower(stage, way.name, "/World/Trajectories/Tracked")
        uniform(agent, "usdfoot:agent:id", Sdf.ValueTypeNames.Int64, way.number)
    stage.SetEndTimeCode(CODES_PER_SECOND * max(float(way.times[-1]) for way in tracked))
    stage.Save()


def _author_xform(stage: Usd.Stage, path: str, way: Way) -> None:
    """A way as time samples of an Xform, with its headings if it has any."""
    xform = UsdGeom.Xform.Define(stage, path)
    move = xform.AddTranslateOp()
    turn = xform.AddRotateYOp() if way.yaws is not None else None
    for number, time in enumerate(way.times.tolist()):
        code = round(time * CODES_PER_SECOND, 6)
        move.Set(Gf.Vec3d(*np.round(way.places[number], 6).tolist()), code)
        if turn and way.yaws is not None:
            turn.Set(round(float(np.degrees(way.yaws[number])), 4), code)


def _author_points(stage: Usd.Stage, path: str, ways: Sequence[Way]) -> None:
    """Ways as points with ids, in each sample those who are there, in changing order."""
    points = UsdGeom.Points.Define(stage, path)
    times = np.unique(np.round(np.concatenate([way.times for way in ways]), 6))
    for sample, time in enumerate(times.tolist()):
        there = [(way, number) for way in ways for number in np.flatnonzero(np.abs(way.times - time) < 1e-6)]
        there = there[sample % len(there) :] + there[: sample % len(there)]
        code = round(time * CODES_PER_SECOND, 6)
        places = np.array([way.places[number] for way, number in there])
        points.GetPointsAttr().Set(vectors(places), code)
        points.GetIdsAttr().Set([way.number for way, _ in there], code)
        points.GetExtentAttr().Set(extent_of(places), code)


def _follower(stage: Usd.Stage, name: str, trajectory: str) -> Usd.Prim:
    """An agent prim that follows a trajectory with the character in the library."""
    prim = UsdGeom.Xform.Define(stage, f"/World/{name}").GetPrim()
    prim.AddAppliedSchema("UsdfootAgentAPI")
    relate(prim, "usdfoot:agent:trajectory", [trajectory])
    relate(prim, "usdfoot:agent:clips", ["/World/Library/Motion/Clips"])
    relate(prim, "usdfoot:agent:character", ["/World/Library/Character"])
    return prim


def new_scene(path: Path, plans: Sequence[Plan], made_by: str) -> Usd.Stage:
    """A stage with its plans and the library of clips."""
    stage = new_stage(path, "World", "Xform", made_by)
    UsdGeom.Scope.Define(stage, "/World/Terrain")
    UsdGeom.Scope.Define(stage, "/World/Plans")
    for plan in plans:
        author_plan(stage, f"/World/Plans/{plan.name}", plan)
    library = UsdGeom.Scope.Define(stage, "/World/Library")
    library.CreateVisibilityAttr(UsdGeom.Tokens.invisible)
    UsdGeom.Xform.Define(stage, "/World/Library/Motion").GetPrim().GetReferences().AddReference("./clips.usdc")
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(float(np.ceil(max([last_code(plan) for plan in plans], default=0.0))))
    return stage


def _terrain(stage: Usd.Stage, name: str, asset: str, offset: FloatArray, *, yaw: float = 0.0) -> None:
    """A terrain file by reference, turned by `yaw` [degrees] and moved by `offset` [m]."""
    xform = UsdGeom.Xform.Define(stage, f"/World/Terrain/{name}")
    xform.GetPrim().GetReferences().AddReference(f"./{asset}")
    xform.AddTranslateOp().Set(Gf.Vec3d(*np.asarray(offset, dtype=float).tolist()))
    if yaw:
        xform.AddRotateYOp().Set(yaw)


def put_character(stage: Usd.Stage) -> None:
    """Reference the person as the library's character."""
    stage.DefinePrim("/World/Library/Character").GetReferences().AddReference("./human.usdc")


def _agent_is_character(stage: Usd.Stage, name: str, plan: Plan) -> None:
    """An agent that is the character itself."""
    prim = stage.DefinePrim(f"/World/{name}")
    prim.GetReferences().AddReference("./human.usdc")
    _apply_agent(prim, plan)


def _separate_agent(stage: Usd.Stage, name: str, plan: Plan) -> None:
    """An agent prim that points at the character in the library."""
    prim = UsdGeom.Xform.Define(stage, f"/World/{name}").GetPrim()
    _apply_agent(prim, plan)
    relate(prim, "usdfoot:agent:character", ["/World/Library/Character"])


def _apply_agent(prim: Usd.Prim, plan: Plan) -> None:
    prim.AddAppliedSchema("UsdfootAgentAPI")
    relate(prim, "usdfoot:agent:plan", [f"/World/Plans/{plan.name}"])
    relate(prim, "usdfoot:agent:clips", ["/World/Library/Motion/Clips"])
