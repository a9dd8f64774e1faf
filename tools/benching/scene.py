"""A scene to measure with: people in a row that walk straight plans."""

from __future__ import annotations

from pathlib import Path

from pxr import Sdf, Usd, UsdGeom, Vt

from benching.rigs import straight_plan

__all__ = ["write_scene"]

PLAN_TIMES = {"strike": "strike_times", "liftoff": "liftoff_times"}


def write_scene(path: Path, stages: Path, agents: int, frames: int) -> None:
    """Writes the scene.

    Args:
        path: File to write.
        stages: Folder of human.usdc and clips.usdc.
        agents: People.
        frames: Samples that each plan is long, at 30 a second.
    """
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(30.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    stage.DefinePrim("/World/Library/Motion").GetReferences().AddReference(str(stages / "clips.usdc"))
    stage.DefinePrim("/World/Library/Character").GetReferences().AddReference(str(stages / "human.usdc"))
    for number in range(agents):
        _write_plan(stage, number, frames / 30.0)
        agent = UsdGeom.Xform.Define(stage, f"/World/Agent_{number}").GetPrim()
        agent.AddAppliedSchema("UsdfootAgentAPI")
        for name, target in (
            ("plan", f"/World/Plans/Walk_{number}"),
            ("character", "/World/Library/Character"),
            ("clips", "/World/Library/Motion/Clips"),
        ):
            agent.CreateRelationship(f"usdfoot:agent:{name}", custom=False).SetTargets([target])
    stage.Save()


def _write_plan(stage: Usd.Stage, number: int, duration: float) -> None:
    plan = straight_plan(number, duration)
    instancer = UsdGeom.PointInstancer.Define(stage, plan.name)
    prints = [UsdGeom.Cube.Define(stage, f"{plan.name}/Prints/{name}").GetPath() for name in ("Left", "Right")]
    instancer.CreatePrototypesRel().SetTargets(prints)
    instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy(plan.sides.astype("int32")))
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(plan.positions.astype("float32")))
    instancer.CreateOrientationsAttr(Vt.QuathArray.FromNumpy(plan.orientations.astype("float16")))
    prim = instancer.GetPrim()
    prim.AddAppliedSchema("UsdfootPlanAPI")
    for event, field in PLAN_TIMES.items():
        codes = Sdf.TimeCodeArray([float(code) for code in 30.0 * getattr(plan, field)])
        kind = Sdf.ValueTypeNames.TimeCodeArray
        prim.CreateAttribute(f"usdfoot:plan:{event}Times", kind, False, Sdf.VariabilityUniform).Set(codes)
