"""The scenes with goals: agents that want to get somewhere, and no footsteps yet."""

from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from stagecraft.goals import BENCHES, FOUNTAIN, KIOSK, PLAZA, plaza_visitors, river
from stagecraft.rotation import FloatArray
from stagecraft.scene_stages import new_scene, put_character
from stagecraft.stage_file import relate, uniform
from stagecraft.terrain_stages import author_block, author_prism, author_surface
from stagecraft.terrains import flat


def write_goal_scenes(folder: Path) -> None:
    """Write the plaza and the river into `folder`."""
    _write_plaza(folder / "plaza.usda")
    _write_river(folder / "river.usda")


def _write_plaza(path: Path) -> None:
    stage = new_scene(path, [], "people who want to cross a plaza")
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
    put_character(stage)
    for visitor in plaza_visitors():
        prim = _seeker(stage, visitor.name, np.insert(visitor.start, 1, 0.0), np.insert(visitor.goal, 1, 0.0))
        UsdGeom.Xformable(prim).AddRotateYOp().Set(visitor.yaw)
        uniform(prim, "usdfoot:agent:speed", Sdf.ValueTypeNames.Float, visitor.speed)
    stage.Save()


def _write_river(path: Path) -> None:
    crossing = river()
    stage = new_scene(path, [], "stepping stones with dead ends after van de Panne 1997, Figure 13")
    for surface in crossing.surfaces:
        author_surface(stage, "/World/Terrain", surface)
    put_character(stage)
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
