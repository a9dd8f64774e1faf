"""Movers: everyone on a stage who moves along a trajectory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from pxr import Usd, UsdGeom

from usdfoot.bridge.names import unique_name
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.model.trajectory import RootTrajectory
from usdfoot.readers.agents import AgentSource
from usdfoot.readers.plans import is_plan
from usdfoot.readers.trajectories import TrajectoryReader

__all__ = ["Mover", "read_movers"]


@dataclass(frozen=True, kw_only=True)
class Mover:
    """One that moves along a trajectory."""

    name: str
    """Unique, a prim's name."""
    agent: str
    """Path of the agent prim; empty = none."""
    trajectory: RootTrajectory


def read_movers(
    stage: Usd.Stage, units: StageUnits, *, sources: Sequence[AgentSource], pattern: str = ""
) -> tuple[tuple[Mover, ...], tuple[UsdfootError, ...]]:
    """Everyone who moves, and why some trajectories cannot be read.

    Args:
        stage: Open stage.
        units: Its units.
        sources: Agents; those with a trajectory are movers. If there are none, all points with ids are that move, and
            if there are none either, all Xforms that are animated themselves and not below another such.
        pattern: Glob on the paths of prims to take instead of all that.

    Raises:
        SceneError: If no prim matches the pattern.
    """
    reader, errors = TrajectoryReader(units=units), []
    movers: list[Mover] = []
    taken: set[str] = set()
    followers = [source for source in sources if source.trajectory is not None] if not pattern else []
    for source in followers:
        try:
            trajectory = reader.read(source.trajectory, source.number)
            movers.append(Mover(name=source.name, agent=str(source.prim.GetPath()), trajectory=trajectory))
        except UsdfootError as error:
            errors.append(error)
    if followers:
        return tuple(movers), tuple(errors)
    for prim in _moving_prims(stage, pattern):
        try:
            for number, trajectory in reader.read_all(prim):
                name = prim.GetName() + ("" if number is None else f"_{number}")
                movers.append(Mover(name=unique_name(name, taken), agent="", trajectory=trajectory))
        except UsdfootError as error:
            errors.append(error)
    return tuple(movers), tuple(errors)


def _moving_prims(stage: Usd.Stage, pattern: str) -> list[Usd.Prim]:
    """Prims that may hold trajectories."""
    prims = list(Usd.PrimRange(stage.GetPseudoRoot()))
    if pattern:
        chosen = [prim for prim in prims if fnmatchcase(str(prim.GetPath()), pattern)]
        if not chosen:
            raise SceneError(f"prims {pattern}", "match nothing on the stage", "give a glob of their paths")
        return [prim for prim in chosen if prim.IsA(UsdGeom.Xformable)]
    clouds = [prim for prim in prims if _is_cloud(prim)]
    if clouds:
        return clouds
    found: list[Usd.Prim] = []
    for prim in prims:
        if found and prim.GetPath().HasPrefix(found[-1].GetPath()):
            continue
        if prim.IsA(UsdGeom.Xform) and UsdGeom.Xformable(prim).TransformMightBeTimeVarying():
            found.append(prim)
    return found


def _is_cloud(prim: Usd.Prim) -> bool:
    """Whether a prim holds points with ids that move."""
    for kind, name in ((UsdGeom.Points, UsdGeom.Tokens.points), (UsdGeom.PointInstancer, UsdGeom.Tokens.positions)):
        if prim.IsA(kind) and not is_plan(prim):
            ids = prim.GetAttribute(UsdGeom.Tokens.ids)
            return bool(ids and ids.HasAuthoredValue()) and prim.GetAttribute(name).GetNumTimeSamples() > 1
    return False
