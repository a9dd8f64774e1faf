"""Movers: everyone on a stage who moves along a trajectory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from pxr import Usd, UsdGeom, UsdSkel

from usdfoot.bridge.names import unique_name
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.model.report import Problem
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
) -> tuple[tuple[Mover, ...], tuple[Problem, ...]]:
    """Everyone who moves, and what is wrong with some trajectories.

    Args:
        stage: Open stage.
        units: Its units.
        sources: Agents; those with a trajectory are movers. If there are none, all points with ids are that move, and
            if there are none either, all Xforms and SkelRoots that are animated themselves and not below another such.
        pattern: Glob on the paths of prims to take instead of all that.

    Raises:
        SceneError: If no prim matches the pattern.
    """
    reader = TrajectoryReader(units=units)
    problems: list[Problem] = []
    movers: list[Mover] = []
    followers = [source for source in sources if source.trajectory is not None] if not pattern else []
    for source in followers:
        try:
            trajectory = reader.read(source.trajectory, source.number)
            movers.append(Mover(name=source.name, agent=str(source.prim.GetPath()), trajectory=trajectory))
        except UsdfootError as error:
            problems.append(_problem(error))
    if followers:
        return tuple(movers), tuple(problems)
    taken: set[str] = set()
    for prim in _moving_prims(stage, pattern):
        try:
            found = reader.read_all(prim)
        except UsdfootError as error:
            problems.append(_problem(error))
            continue
        for number, part in found:
            if isinstance(part, UsdfootError):
                problems.append(_problem(part))
                continue
            if part.name in taken:
                problems.append(_cut(part))
            taken.add(part.name)
            name = prim.GetName() + ("" if number is None else f"_{number}".replace("-", "_"))
            movers.append(Mover(name=unique_name(name, taken), agent="", trajectory=part))
    return tuple(movers), tuple(problems)


def _problem(error: UsdfootError) -> Problem:
    return Problem(severity="error", where=error.where, message=str(error))


def _cut(trajectory: RootTrajectory) -> Problem:
    """The warning for a trajectory that is not the first of its id."""
    what = f"jumps, or was gone for long, before {trajectory.start:.4g} s; it is someone else from there on"
    return Problem(severity="warning", where=trajectory.name, message=f"{trajectory.name}: {what}")


def _moving_prims(stage: Usd.Stage, pattern: str) -> list[Usd.Prim]:
    """Prims that may hold trajectories."""
    prims = list(Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies()))
    if pattern:
        chosen = [prim for prim in prims if fnmatchcase(str(prim.GetPath()), pattern)]
        if not chosen:
            raise SceneError(f"prims {pattern}", "match nothing on the stage", "give a glob of their paths")
        return [prim for prim in chosen if prim.IsA(UsdGeom.Xformable)]
    clouds = [prim for prim in prims if _is_cloud(prim)]
    named = [prim for prim in clouds if prim.GetAttribute(UsdGeom.Tokens.ids).HasAuthoredValue()]
    if named:
        return named
    found: list[Usd.Prim] = []
    for prim in prims:
        if found and prim.GetPath().HasPrefix(found[-1].GetPath()):
            continue
        may_walk = prim.IsA(UsdGeom.Xform) or prim.IsA(UsdSkel.Root)
        if may_walk and UsdGeom.Xformable(prim).TransformMightBeTimeVarying():
            found.append(prim)
    return found or clouds


def _is_cloud(prim: Usd.Prim) -> bool:
    """Whether a prim holds points that move."""
    for kind, name in ((UsdGeom.Points, UsdGeom.Tokens.points), (UsdGeom.PointInstancer, UsdGeom.Tokens.positions)):
        if prim.IsA(kind) and not is_plan(prim):
            return prim.GetAttribute(name).GetNumTimeSamples() > 1
    return False
