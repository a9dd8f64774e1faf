"""The scenes: people, clips and terrain by reference, footstep plans or goals, agents."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from stagecraft.course import obstacle_course
from stagecraft.crowd import crowd_plans
from stagecraft.goals import BENCHES, FOUNTAIN, KIOSK, PLAZA, plaza_visitors, river
from stagecraft.plan_prim import Plan, author_plan, last_code
from stagecraft.rotation import FloatArray
from stagecraft.stage_file import new_stage, relate, uniform
from stagecraft.stones import stepping_stones
from stagecraft.terrain_stages import author_block, author_prism, author_surface
from stagecraft.terrains import flat, hills


def write_scenes(folder: Path) -> None:
    """Write the scenes with footsteps, then those with goals, into `folder`."""
    _write_course(folder / "obstacle_course.usda")
    _write_stones(folder / "stepping_stones.usda")
    _write_crowd(folder / "crowd.usda")
    _write_plaza(folder / "plaza.usda")
    _write_river(folder / "river.usda")


def _write_course(path: Path) -> None:
    course = obstacle_course()
    stage = _scene(path, [course.plan], "an obstacle course after Beacco et al. 2015, Figure 1")
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
    stage = _scene(path, [plan], "stepping stones after Beacco et al. 2015, Figure 7")
    _terrain(stage, "Stones", "terrain_stones.usda", np.zeros(3))
    _character_in_library(stage)
    _separate_agent(stage, "Walker", plan)
    stage.Save()


def _write_crowd(path: Path) -> None:
    plans = crowd_plans([hills()])
    stage = _scene(path, plans, "twelve people on hilly ground")
    _terrain(stage, "Hills", "terrain_hills.usda", np.zeros(3))
    _character_in_library(stage)
    for plan in plans:
        _separate_agent(stage, plan.name, plan)
    stage.Save()


def _write_plaza(path: Path) -> None:
    stage = _scene(path, [], "people who want to cross a plaza")
    author_surface(stage, "/World/Terrain", flat(PLAZA, tile=2.0))
    UsdGeom.Scope.Define(stage, "/World/Obstacles")
    fountain = UsdGeom.Cylinder.Define(stage, "/World/Obstacles/Fountain")
    x, z, radius = FOUNTAIN
    fountain.AddTranslateOp().Set(Gf.Vec3d(x, 0.3, z))
    fountain.CreateAxisAttr(UsdGeom.Tokens.y)
    fountain.CreateRadiusAttr(radius)
    fountain.CreateHeightAttr(0.6)
    fountain.CreateExtentAttr([(-radius, -0.3, -radius), (radius, 0.3, radius)])
    fountain.GetPrim().AddAppliedSchema("UsdfootObstacleAPI")
    uniform(fountain.GetPrim(), "usdfoot:obstacle:margin", Sdf.ValueTypeNames.Float, 0.1)
    author_prism(stage, "/World/Obstacles/Kiosk", np.array(KIOSK), height=2.6, margin=0.1)
    for number, (x, z) in enumerate(BENCHES):
        size = np.array([2.0, 0.5, 0.5])
        author_block(stage, f"/World/Obstacles/Bench_{number}", np.array([x, 0.25, z]), size, margin=0.05)
    _character_in_library(stage)
    for visitor in plaza_visitors():
        prim = _seeker(stage, visitor.name, np.insert(visitor.start, 1, 0.0), np.insert(visitor.goal, 1, 0.0))
        UsdGeom.Xformable(prim).AddRotateYOp().Set(visitor.yaw)
        uniform(prim, "usdfoot:agent:speed", Sdf.ValueTypeNames.Float, visitor.speed)
    stage.Save()


def _write_river(path: Path) -> None:
    crossing = river()
    stage = _scene(path, [], "stepping stones with dead ends after van de Panne 1997, Figure 13")
    for surface in crossing.surfaces:
        author_surface(stage, "/World/Terrain", surface)
    _character_in_library(stage)
    _seeker(stage, "Walker", crossing.start, crossing.goal)
    stage.Save()


def _seeker(stage: Usd.Stage, name: str, start: FloatArray, goal: FloatArray) -> Usd.Prim:
    """An agent at its start that wants to get to its goal."""
    UsdGeom.Xform.Define(stage, f"/World/Goals/{name}").AddTranslateOp().Set(Gf.Vec3d(*goal.tolist()))
    xform = UsdGeom.Xform.Define(stage, f"/World/Agents/{name}")
    xform.AddTranslateOp().Set(Gf.Vec3d(*start.tolist()))
    prim = xform.GetPrim()
    prim.AddAppliedSchema("UsdfootAgentAPI")
    relate(prim, "usdfoot:agent:goal", [f"/World/Goals/{name}"])
    relate(prim, "usdfoot:agent:clips", ["/World/Library/Motion/Clips"])
    relate(prim, "usdfoot:agent:character", ["/World/Library/Character"])
    return prim


def _scene(path: Path, plans: Sequence[Plan], made_by: str) -> Usd.Stage:
    """A stage with its plans and the library of clips."""
    stage = new_stage(path, "World", "Xform", made_by)
    UsdGeom.Scope.Define(stage, "/World/Terrain")
    for scope in ("Plans",) if plans else ("Goals", "Agents"):
        UsdGeom.Scope.Define(stage, f"/World/{scope}")
    for plan in plans:
        author_plan(stage, f"/World/Plans/{plan.name}", plan)
    library = UsdGeom.Scope.Define(stage, "/World/Library")
    library.CreateVisibilityAttr(UsdGeom.Tokens.invisible)
    UsdGeom.Xform.Define(stage, "/World/Library/Motion").GetPrim().GetReferences().AddReference("./clips.usdc")
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(float(np.ceil(max((last_code(plan) for plan in plans), default=0.0))))
    return stage


def _terrain(stage: Usd.Stage, name: str, asset: str, offset: FloatArray, *, yaw: float = 0.0) -> None:
    """A terrain file by reference, turned by `yaw` [degrees] and moved by `offset` [m]."""
    xform = UsdGeom.Xform.Define(stage, f"/World/Terrain/{name}")
    xform.GetPrim().GetReferences().AddReference(f"./{asset}")
    xform.AddTranslateOp().Set(Gf.Vec3d(*np.asarray(offset, dtype=float).tolist()))
    if yaw:
        xform.AddRotateYOp().Set(yaw)


def _character_in_library(stage: Usd.Stage) -> None:
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
