"""Walkers: who walks which path, with what proportions."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from pxr import Sdf, Usd

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

    def doubt(self) -> Problem | None:
        """A warning where the walker is slower than asked for."""
        if not self.asked_speed:
            return None
        path = self.path
        asked, taken = path.step_length / self.asked_speed, path.step_length / path.speed
        message = (
            f"{self.name}: is to go {self.asked_speed:.2f} m/s by steps of {path.step_length:.2f} m in {asked:.2f} s; "
            f"its clips cannot be hurried so much, they take {taken:.2f} s, for {path.speed:.2f} m/s. lower "
            "usdfoot:path:speed, lengthen usdfoot:path:stepLength, leave one of them out or add clips of quicker steps"
        )
        return Problem(severity="warning", where=self.name, message=message)


def read_walkers(
    stage: Usd.Stage,
    prims: StagePrims,
    units: StageUnits,
    *,
    sources: Sequence[AgentSource],
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
        free_paths: Also give one walker to each curve that no agent follows.
        habits: Finds how they step; None = as the clips do that each says move it.
    """
    if not free_paths and all(source.path is None for source in sources):
        return (), {}
    casting = Casting.to_look(stage, prims, units, foreign=[source.plan for source in sources])
    walkers, errors = [], {}
    finder = habits or HabitsReader()
    turns: Counter[Sdf.Path] = Counter()
    curves: dict[Sdf.Path, tuple[WalkingPath | PlanError, ...] | UsdfootError] = {}
    for source in sources:
        if source.path is None:
            continue
        where = source.path.GetPath()
        try:
            found = _curves(source.path, units, curves)
            path = found[turns[where] % len(found)]
            turns[where] += 1
            if isinstance(path, UsdfootError):
                raise path
            character = casting.character_of(source)
            steps_like = finder.read(casting, source)
            body = replace(proportions_of(character.skeleton, character.biped), habits=steps_like)
            slowed = finder.unhurried(path, casting, source, body=body)
            walkers.append(
                Walker(
                    name=source.name,
                    agent=str(source.prim.GetPath()),
                    path=slowed,
                    proportions=body,
                    asked_speed=0.0 if slowed is path else path.speed,
                )
            )
        except UsdfootError as error:
            errors[source.name] = error
    if free_paths:
        names = {source.name for source in sources}
        body = only_proportions(prims, units, foreign=casting.foreign)
        for prim in find_paths(stage):
            if prim.GetPath() in curves:
                continue
            try:
                found = _curves(prim, units, curves)
            except UsdfootError as error:
                errors[str(prim.GetPath())] = error
                continue
            for path in found:
                if isinstance(path, UsdfootError):
                    errors[path.where] = path
                    continue
                name = unique_name(prim.GetName(), names)
                walkers.append(Walker(name=name, agent="", path=path, proportions=body))
    return tuple(walkers), errors


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
    return proportions_of(character.skeleton, character.biped)


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
