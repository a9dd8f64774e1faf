"""Footstep plans along selected curves."""

from __future__ import annotations

from dataclasses import replace

from pxr import Sdf, Usd, UsdGeom

from usdfoot.bridge.names import unique_name
from usdfoot.bridge.tokens import Path as Token
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.readers.authored import authored
from usdfoot.readers.moving_obstacles import MovingObstacles
from usdfoot.readers.obstacles import read_obstacles
from usdfoot.readers.path_plans import plan_paths
from usdfoot.readers.paths import read_paths
from usdfoot.readers.stage import collect_prims, read_stage_info
from usdfoot.readers.terrain import read_terrain
from usdfoot.readers.walkers import Walker, only_proportions
from usdfoot.usdview.selection import Selection
from usdfoot.writers.footsteps import author_plan, print_models
from usdfoot.writers.plans import PLANS_SCOPE

__all__ = ["plan_along_selected"]


def plan_along_selected(stage: Usd.Stage, selection: Selection, time: Usd.TimeCode) -> tuple[Sdf.Path, ...]:
    """Plan footsteps along the selected curves, as `usdfoot plan path` does, and author them at the edit target.

    Args:
        stage: Any open stage.
        selection: BasisCurves or HermiteCurves.
        time: When the walk begins where the curve does not say.

    Returns:
        Paths of the plans, below /Plans.

    Raises:
        SceneError: If no curve is selected, or the edit target is a layer that is retimed.
        PlanError: If no plan can be made along one of them.
    """
    curves = [prim for path in selection.paths if _is_curve(prim := stage.GetPrimAtPath(path))]
    if not curves:
        raise SceneError("selection", "holds no curve", "select BasisCurves or HermiteCurves")
    target = stage.GetEditTarget()
    if target.GetMapFunction().timeOffset != Sdf.LayerOffset():
        raise SceneError(target.GetLayer().identifier, "is retimed in the stage", "choose another edit target")
    prims, units = collect_prims(stage), read_stage_info(stage).units
    terrain, _ = read_terrain(stage, prims, units)
    body = only_proportions(prims, units)
    scope = stage.GetPrimAtPath(PLANS_SCOPE)
    taken = {child.GetName() for child in scope.GetAllChildren()} if scope else set()
    walkers = []
    for prim in curves:
        for path in read_paths(prim, units):
            if isinstance(path, UsdfootError):
                raise path
            if authored(prim, Token.START_TIME) is None and not time.IsDefault():
                path = replace(path, start_time=float(units.codes_to_times(time.GetValue())))
            name = unique_name(prim.GetName(), taken)
            walkers.append(Walker(name=name, agent="", path=path, proportions=body))
    obstacles, _ = read_obstacles(stage, prims, units)
    found = plan_paths(walkers, terrain, obstacles=obstacles, moving=MovingObstacles(prims, units))
    if found.errors:
        raise next(iter(found.errors.values()))
    prints = print_models(body.foot_length, units)
    paths = []
    for name, plan in found.plans.items():
        paths.append(Sdf.Path(PLANS_SCOPE).AppendChild(name))
        author_plan(target.GetLayer(), str(paths[-1]), plan, prints=prints, units=units)
    return tuple(paths)


def _is_curve(prim: Usd.Prim) -> bool:
    return bool(prim) and (prim.IsA(UsdGeom.BasisCurves) or prim.IsA(UsdGeom.HermiteCurves))
