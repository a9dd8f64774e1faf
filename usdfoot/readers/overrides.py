"""Overrides: what artists changed in a crowd's overrides.usda, honoured when the crowd is made again."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, Vt

from usdfoot.bridge.tokens import Agent, File, Op, Plan, Prim
from usdfoot.bridge.units import StageUnits
from usdfoot.bridge.usd_errors import usd_reason
from usdfoot.errors import PlanError, SceneError
from usdfoot.maths.types import FloatArray
from usdfoot.model.displacement import STILL, Displacement
from usdfoot.model.limits import DEFAULT_LIMITS
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.readers.agents import AgentSource
from usdfoot.readers.authored import targets
from usdfoot.readers.plans import read_plan
from usdfoot.readers.skeleton import matrices_of
from usdfoot.readers.stage import start_code

__all__ = ["OverriddenPlan", "Overrides", "author_move", "new_layer", "read_overrides"]


@dataclass(frozen=True, kw_only=True)
class OverriddenPlan:
    """A plan as artists changed it."""

    plan: FootstepPlan
    problems: tuple[Problem, ...]
    """Warnings about it."""
    frame: FloatArray
    """From the written plan prim to the world by the artists' transforms (row vectors, stage units), shape (4, 4)."""


@dataclass(frozen=True, kw_only=True)
class Overrides:
    """The artists' layer of a crowd."""

    stage: Usd.Stage | None
    """overrides.usda and the layers below it alone; None = there is none yet, or nothing in it."""
    footsteps: Path | None
    """The crowd's layer of executed plans; None = there is none yet."""
    units: StageUnits
    """Of the scene, which are the crowd's."""
    most_footsteps: int = DEFAULT_LIMITS.footsteps
    """How many a plan may have."""

    @property
    def layer(self) -> Sdf.Layer | None:
        """overrides.usda; None = there is none yet, or nothing in it."""
        return self.stage.GetRootLayer() if self.stage else None

    def is_muted(self, name: str) -> bool:
        """Whether an agent is inactive, and so not to be made."""
        prim = self.stage.GetPrimAtPath(f"{Prim.AGENTS}/{name}") if self.stage else None
        return not (prim is None or not prim or prim.IsActive())

    def over(self, sources: Sequence[AgentSource]) -> tuple[AgentSource, ...]:
        """Agents with what the artists say of each, without those that they muted."""
        if self.stage is None:
            return tuple(sources)
        return tuple(
            replace(source, override=self.stage.GetPrimAtPath(f"{Prim.AGENTS}/{source.name}") or None)
            for source in sources
            if not self.is_muted(source.name)
        )

    def plan(self, name: str, plan_of: Callable[[str], FootstepPlan | None]) -> OverriddenPlan | None:
        """An agent's plan with what the artists changed of it; None if they changed nothing.

        Args:
            name: Of the agent.
            plan_of: The plans of the scene by agent name, of agents that follow trajectories or paths those they last
                walked; None for a name that no agent has.

        Raises:
            PlanError: If what they made of it is no plan, or no plan is where they point.
            SceneError: If it has too many footsteps.
        """
        if self.stage is None:
            return None
        own, layer = f"{Prim.PLANS}/{name}", self.stage.GetRootLayer()
        path = self.plan_path(name)
        if path == own and not self.stage.GetPrimAtPath(own):
            return None
        base = plan_of(Sdf.Path(path).name) if path.startswith(f"{Prim.PLANS}/") else None
        scene = new_layer(self.units)
        if base is not None:
            _author_plan(scene, path, base, self.units, over=self.stage.GetPrimAtPath(path))
        whole = new_layer(self.units)
        whole.subLayerPaths = [layer.identifier, scene.identifier]
        stage = Usd.Stage.Open(whole, sessionLayer=None)
        prim = stage.GetPrimAtPath(path)
        if not prim or not prim.IsDefined():
            where = f"{layer.GetDisplayName()} {Prim.AGENTS}/{name}"
            raise PlanError(where, f"{Agent.PLAN} points at no plan", "point it at a PointInstancer", [path])
        plan, problems = read_plan(prim, self.units, most=self.most_footsteps)
        frame = matrices_of(prim, np.array([start_code(stage).GetValue()]))[0] if path == own else np.eye(4)
        return OverriddenPlan(plan=plan, problems=problems, frame=frame)

    def plan_path(self, name: str) -> str:
        """Path of the plan that an agent walks, its own if the artists do not say."""
        return (_target(self.stage, name) if self.stage else None) or f"{Prim.PLANS}/{name}"

    def executed_plan(self, name: str) -> FootstepPlan | None:
        """The plan that an agent last walked, as in its prim's own space; None if it was never made."""
        if self.footsteps is None:
            return None
        stage = Usd.Stage.Open(str(self.footsteps))
        stage.Reload()
        prim = stage.GetPrimAtPath(f"{Prim.PLANS}/{name}")
        if prim:
            stage.SetEditTarget(stage.GetSessionLayer())
            UsdGeom.Xformable(prim).SetXformOpOrder([])  # where it stands with an agent that was moved
        plan = read_plan(prim, self.units, most=self.most_footsteps)[0] if prim else None
        return replace(plan, orientations=plan.orientations + 0.0) if plan else None  # no -0.0: one hash, once rounded


def read_overrides(
    folder: Path | None, units: StageUnits, *, most_footsteps: int = DEFAULT_LIMITS.footsteps
) -> Overrides:
    """What artists changed in a crowd, as it is on disk now.

    Args:
        folder: Of the crowd; None or without overrides.usda = nothing was changed.
        units: Of the scene.
        most_footsteps: How many a plan may have.

    Raises:
        SceneError: If overrides.usda cannot be read.
    """
    path = folder / File.OVERRIDES if folder else None
    if path is None or not path.is_file():
        return Overrides(stage=None, footsteps=None, units=units, most_footsteps=most_footsteps)
    try:
        layer = Sdf.Layer.FindOrOpen(str(path))
        layer.Reload()
        stage = Usd.Stage.Open(layer, sessionLayer=None) if layer.rootPrims or layer.subLayerPaths else None
    except Tf.ErrorException as error:
        raise SceneError(path, f"cannot be read: {usd_reason(error)}", "correct it, or move it away") from error
    footsteps = path.with_name(File.FOOTSTEPS)
    executed = footsteps if footsteps.is_file() else None
    return Overrides(stage=stage, footsteps=executed, units=units, most_footsteps=most_footsteps)


def _target(stage: Usd.Stage, name: str) -> str | None:
    """The plan that the overrides give an agent."""
    prim = stage.GetPrimAtPath(f"{Prim.AGENTS}/{name}")
    found = targets(prim, Agent.PLAN) if prim else []
    return str(found[0]) if found else None


def new_layer(units: StageUnits) -> Sdf.Layer:
    """A layer in memory with a stage's units."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.pseudoRoot.SetInfo("metersPerUnit", units.meters_per_unit)
    layer.pseudoRoot.SetInfo("upAxis", units.up_axis)
    layer.timeCodesPerSecond = units.time_codes_per_second
    return layer


def author_move(plan: UsdGeom.Xformable, move: Displacement, units: StageUnits) -> None:
    """The transform that usdfoot authors on the plan of an agent that artists moved."""
    translation = units.points_to_stage(move.translation).tolist()
    plan.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble, Op.MOVED).Set(Gf.Vec3d(*translation))
    kind = UsdGeom.XformOp.TypeRotateZ if units.up_axis == "Z" else UsdGeom.XformOp.TypeRotateY
    plan.AddXformOp(kind, UsdGeom.XformOp.PrecisionDouble, Op.MOVED).Set(math.degrees(move.yaw))


def _author_plan(layer: Sdf.Layer, path: str, plan: FootstepPlan, units: StageUnits, *, over: Usd.Prim) -> None:
    """A plan of the scene as the crowd has it; the orientations are exact unless what is over it has its own."""
    stage = Usd.Stage.Open(layer, sessionLayer=None)
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    instancer.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy(plan.sides.astype(np.int32)))
    positions = np.ascontiguousarray(units.points_to_stage(plan.positions), dtype=np.float32)
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(positions))
    rotations = np.ascontiguousarray(units.rotations_to_stage(plan.orientations), dtype=np.float32)
    if over and over.GetAttribute("orientations"):
        half = Vt.QuathArray.FromNumpy(rotations.astype(np.float16))
        instancer.CreateOrientationsAttr(half)
    else:
        instancer.CreateOrientationsfAttr(Vt.QuatfArray.FromNumpy(rotations))
    author_move(instancer, STILL, units)
    prim = instancer.GetPrim()
    kinds = Sdf.ValueTypeNames
    for name, times in ((Plan.STRIKE_TIMES, plan.strike_times), (Plan.LIFTOFF_TIMES, plan.liftoff_times)):
        codes = Sdf.TimeCodeArray([Sdf.TimeCode(code) for code in units.times_to_codes(times).tolist()])
        prim.CreateAttribute(name, kinds.TimeCodeArray, False, Sdf.VariabilityUniform).Set(codes)
    if plan.root_weights.any():  # else whoever adds or deletes footsteps need not think of them
        weights = Vt.FloatArray.FromNumpy(plan.root_weights.astype(np.float32))
        prim.CreateAttribute(Plan.ROOT_WEIGHTS, kinds.FloatArray, False, Sdf.VariabilityUniform).Set(weights)
