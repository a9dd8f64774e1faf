"""Walkers: who walks which path, with what proportions."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdfoot.bridge.names import unique_name
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import PlanError, UsdfootError
from usdfoot.model.ground import Ground
from usdfoot.model.path import WalkingPath
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.planning.path import PathOptions, plan_each
from usdfoot.planning.proportions import Proportions, proportions_of
from usdfoot.planning.world import Obstacle
from usdfoot.readers.agents import AgentSource
from usdfoot.readers.candidates import only_character
from usdfoot.readers.casting import Casting
from usdfoot.readers.characters import read_character
from usdfoot.readers.habits import HabitsReader
from usdfoot.readers.paths import find_paths, read_paths
from usdfoot.readers.stage import StagePrims
from usdfoot.readers.transform_codes import changes_place, changes_value
from usdfoot.retarget.rig import legs_as_rigged

__all__ = ["Walker", "only_proportions", "plan_walkers", "read_walkers"]

_logger = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Walker:
    """One that walks a path."""

    name: str
    """Of the agent, or of the curve nobody follows; unique."""
    agent: str
    """Path of the agent prim; empty = none."""
    path: WalkingPath
    proportions: Proportions
    asked_speed: float = 0.0
    """What the path asks for where that would hurry the clips too much [m/s]; 0 = the path's own speed is as asked."""
    asked_width: float = 0.0
    """The same of its step width, where IK may not pull the clips' steps to it [m]."""
    fastest_step: float = float("inf")
    """Speed of the fastest step of the clips that move the walker [m/s]."""
    is_animated: bool = False
    """Whether the curve is, of which only the start is walked."""
    spare_curves: int = 0
    """Curves of the path's prim that nobody walks; told of its first walker."""
    known_styles: tuple[str, ...] = ()
    """Of the clips that move the walker; empty = none do."""

    def doubts(self) -> tuple[Problem, ...]:
        """Warnings of speeds and widths that clips do not have or get to, and of curves animated or left over."""
        found = []
        path = self.path
        if self.asked_speed and path.step_length:
            asked, taken = path.step_length / self.asked_speed, path.step_length / path.speed
            found.append(
                f"{self.name}: is to go {self.asked_speed:.2f} m/s by steps of {path.step_length:.2f} m in {asked:.2f} "
                f"s; its clips cannot be hurried so much, they take {taken:.2f} s, for {path.speed:.2f} m/s. lower "
                "usdfoot:path:speed, lengthen usdfoot:path:stepLength, leave one of them out or add clips of quicker "
                "steps"
            )
        elif self.asked_speed:
            times = self.asked_speed / self.fastest_step
            found.append(
                f"{self.name}: is to go {self.asked_speed:.2f} m/s, {times:.1f} times as fast as its clips, which go "
                f"up to {self.fastest_step:.2f} m/s: so hurried, they would jerk, and {path.speed:.2f} m/s were taken. "
                "lower usdfoot:path:speed or add faster clips"
            )
        if self.asked_width:
            found.append(
                f"{self.name}: is to take steps {self.asked_width:.3f} m wide, farther from those of its clips than IK "
                f"may pull; {path.step_width:.3f} m were taken. raise usdfoot:path:stepWidth or usdfoot:agent:ikReach, "
                "or add clips of narrower steps"
            )
        if self.is_animated:
            found.append(
                f"{self.name}: {path.name} is animated, it is walked as it is at the stage's start. remove its time "
                "samples, or let usdfoot:agent:trajectory point at a prim that moves along"
            )
        if self.spare_curves:
            found.append(
                f"{self.name}: {path.name} has more curves than agents follow it, {self.spare_curves} of them nobody "
                "walks. let more agents follow it, or draw fewer curves"
            )
        return tuple(Problem(severity="warning", where=self.name, message=message) for message in found)

    def style_doubt(self) -> Problem | None:
        """A warning where the path's style is of no clip: animating it would fail."""
        style = self.path.style
        if not style or not self.known_styles or style in self.known_styles:
            return None
        known = ", ".join(self.known_styles)
        what = f"its style is {style!r}, which no clip of {self.name} has. the styles of these are {known}"
        return Problem(severity="warning", where=self.path.name, message=f"{self.path.name}: {what}")


def read_walkers(
    stage: Usd.Stage,
    prims: StagePrims,
    units: StageUnits,
    *,
    sources: Sequence[AgentSource],
    everyone: Sequence[AgentSource] | None = None,
    free_paths: bool = False,
    habits: HabitsReader | None = None,
) -> tuple[tuple[Walker, ...], dict[str, UsdfootError]]:
    """Everyone who walks a path, and by name why some cannot.

    Agents that follow the same prim take its curves in turn. Those who are moved by clips step as these do, and no
    quicker than these can be hurried.

    Args:
        stage: Open stage.
        prims: Its prims.
        units: Its units.
        sources: Agents; those without a path are left out.
        everyone: Whose turns count, so that nobody walks elsewhere where others are left out; None = the agents'.
        free_paths: Also give one walker to each curve that no agent follows.
        habits: Finds how they step; None = as the clips do that each says move it.
    """
    if not free_paths and all(source.path is None for source in sources):
        return (), {}
    casting = Casting.to_look(stage, prims, units, foreign=[source.plan for source in sources])
    walkers, errors, names = [], {}, {source.name for source in sources}
    finder = habits or HabitsReader()
    turns, followers = _turns(sources if everyone is None else everyone)
    curves: dict[Sdf.Path, tuple[WalkingPath | PlanError, ...] | UsdfootError] = {}
    moving: dict[Sdf.Path, bool] = {}
    for source in sources:
        if source.path is None:
            continue
        where = source.path.GetPath()
        try:
            found = _curves(source.path, units, curves)
            turn = turns.get(source.name, 0)
            path = found[turn % len(found)]
            if isinstance(path, UsdfootError):
                raise path
            character = casting.character_of(source)
            steps_like = finder.read(casting, source)
            body = replace(proportions_of(character.skeleton, character.biped, character.bind_pose), habits=steps_like)
            wide = finder.in_reach(path, casting, source)
            slowed = finder.unhurried(wide, casting, source, body=body)
            walkers.append(
                Walker(
                    name=source.name,
                    agent=str(source.prim.GetPath()),
                    path=slowed,
                    proportions=body,
                    asked_speed=0.0 if slowed is wide else path.speed,
                    asked_width=0.0 if wide is path else path.step_width,
                    fastest_step=finder.fastest(casting, source),
                    is_animated=_is_animated(source.path, moving),
                    spare_curves=0 if turn else max(0, len(found) - followers[where]),
                    known_styles=finder.styles(casting, source) if path.style else (),
                )
            )
        except UsdfootError as error:
            errors[source.name] = error
    if free_paths:
        body = only_proportions(prims, units, foreign=casting.foreign)
        lonely = [prim for prim in find_paths(stage) if prim.GetPath() not in curves]
        for prim in lonely:
            try:
                found = _curves(prim, units, curves)
            except UsdfootError as error:
                errors[str(prim.GetPath())] = error
                continue
            errors |= {path.where: path for path in found if isinstance(path, UsdfootError)}
            moves = _is_animated(prim, moving)
            for path in found:
                if not isinstance(path, UsdfootError):
                    name = unique_name(prim.GetName(), names)
                    walkers.append(Walker(name=name, agent="", path=path, proportions=body, is_animated=moves))
    return tuple(walkers), errors


def _turns(sources: Sequence[AgentSource]) -> tuple[dict[str, int], Counter[Sdf.Path]]:
    """How many agents before each follow the same prim, by name, and how many follow it in all."""
    followers: Counter[Sdf.Path] = Counter()
    turns = {}
    for source in sources:
        if source.path is not None:
            turns[source.name] = followers[source.path.GetPath()]
            followers[source.path.GetPath()] += 1
    return turns, followers


def plan_walkers(
    walkers: Sequence[Walker],
    terrain: Terrain,
    *,
    obstacles: Sequence[Obstacle] = (),
    options: PathOptions | None = None,
) -> dict[str, FootstepPlan | UsdfootError]:
    """Plans of walkers on a terrain, round its obstacles, by name, or why there is none."""
    lowest = min((float(walker.path.points[:, 1].min()) for walker in walkers), default=0.0)
    plans = plan_each(
        [walker.path for walker in walkers],
        Ground(terrain, fallback_height=lowest),
        proportions=[walker.proportions for walker in walkers],
        options=options,
        obstacles=obstacles,
    )
    return {
        walker.name: replace(plan, styles=(walker.path.style,) * len(plan))
        if walker.path.style and isinstance(plan, FootstepPlan)
        else plan
        for walker, plan in zip(walkers, plans, strict=True)
    }


def only_proportions(prims: StagePrims, units: StageUnits, *, foreign: Sequence[Usd.Prim] = ()) -> Proportions:
    """Those of the stage's only character; a person's where there is none or several.

    Args:
        prims: Of the stage.
        units: Of the stage.
        foreign: Prims that are no part of a character.
    """
    try:
        character = read_character(only_character(prims, foreign), units, np.zeros(1))
    except UsdfootError as error:
        _logger.info("those whom no character is given are planned as a person of 1.75 m: %s", error)
        return Proportions()
    skeleton = legs_as_rigged(character.skeleton, character.biped, character.bind_pose)
    return proportions_of(skeleton, character.biped, character.bind_pose)


def _curves(
    prim: Usd.Prim, units: StageUnits, known: dict[Sdf.Path, tuple[WalkingPath | PlanError, ...] | UsdfootError]
) -> tuple[WalkingPath | PlanError, ...]:
    """Curves of a prim, read once."""
    path = prim.GetPath()
    if path not in known:
        try:
            known[path] = read_paths(prim, units)
        except UsdfootError as error:
            known[path] = error
    found = known[path]
    if isinstance(found, UsdfootError):
        raise found
    return found


def _is_animated(prim: Usd.Prim, known: dict[Sdf.Path, bool]) -> bool:
    """Whether a curve is, looked for once."""
    path = prim.GetPath()
    if path not in known:
        known[path] = changes_place(prim) or changes_value(UsdGeom.Curves(prim).GetPointsAttr())
    return known[path]
