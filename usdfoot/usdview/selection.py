"""What is selected in a viewer, and which agents and footsteps that means."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from pxr import Sdf, Usd

from usdfoot.bridge.tokens import Agent, Overlay, Plan, Prim
from usdfoot.errors import SceneError
from usdfoot.maths.types import FloatArray
from usdfoot.readers.authored import authored, targets

__all__ = ["Footstep", "Selection", "all_agents", "selected_agents", "selected_footstep"]


@dataclass(frozen=True, kw_only=True)
class Selection:
    """What is selected in a viewer."""

    paths: tuple[Sdf.Path, ...] = ()
    """Prims."""
    instances: Mapping[Sdf.Path, frozenset[int]] = field(default_factory=dict)
    """Instances of PointInstancers among them, where not all of one are selected."""
    point: FloatArray | None = None
    """Where the prim was picked, in the stage's world [stage units], shape (3,); None = nowhere."""


@dataclass(frozen=True, kw_only=True)
class Footstep:
    """One footstep of an agent's plan."""

    agent: str
    """Name of the agent."""
    plan: Sdf.Path
    number: int


def all_agents(stage: Usd.Stage) -> tuple[str, ...]:
    """Names of the agents of a crowd's stage.

    Raises:
        SceneError: If there are none.
    """
    scope = stage.GetPrimAtPath(Prim.AGENTS)
    names = tuple(prim.GetName() for prim in scope.GetChildren()) if scope else ()
    if not names:
        where = stage.GetRootLayer().identifier
        raise SceneError(where, f"has no agents below {Prim.AGENTS}", "open a crowd.usd written by usdfoot animate")
    return names


def selected_agents(stage: Usd.Stage, selection: Selection) -> tuple[str, ...]:
    """Names of the agents whose prims, plans, animations or overlays are selected, in the stage's order.

    Raises:
        SceneError: If the stage has no agents.
    """
    names = all_agents(stage)
    plans = {plan: name for name in names for plan in _plans(stage, name)}
    found: set[str] = set()
    for path in selection.paths:
        for scope in (Prim.AGENTS, Prim.PLANS, Prim.ANIMS):
            if path.HasPrefix(scope) and path != scope:
                below = next(part for part in path.GetPrefixes() if part.GetParentPath() == scope)
                found.add(plans.get(below, below.name))
        if path.HasPrefix(Overlay.ROOT):
            found.update(name for name, _ in _overlay_owners(stage, path, selection))
    return tuple(name for name in names if name in found)


def selected_footstep(stage: Usd.Stage, selection: Selection, time: Usd.TimeCode) -> Footstep:
    """The one footstep selected; where only an agent is, the one that has come down last at `time`.

    Raises:
        SceneError: If several footsteps or agents are selected, or no agent out of several.
    """
    picked = _picked_footsteps(stage, selection)
    if len(picked) > 1:
        raise SceneError("selection", f"holds {len(picked)} footsteps", "select one")
    if picked:
        agent, number = picked.pop()
        return Footstep(agent=agent, plan=_plan_of(stage, agent), number=number)
    chosen = selected_agents(stage, selection) or all_agents(stage)
    if len(chosen) > 1:
        raise SceneError("selection", f"means {len(chosen)} agents", "select one agent, or a footstep of its plan")
    plan = _plan_of(stage, chosen[0])
    strikes = authored(stage.GetPrimAtPath(plan), Plan.STRIKE_TIMES) or ()
    codes = np.array([float(code) for code in strikes])
    now = stage.GetStartTimeCode() if time.IsDefault() else time.GetValue()
    number = max(int(np.searchsorted(codes, now, side="right")) - 1, 0)
    return Footstep(agent=chosen[0], plan=plan, number=number)


def _picked_footsteps(stage: Usd.Stage, selection: Selection) -> set[tuple[str, int]]:
    """Agents and numbers of the footsteps selected as instances."""
    owners = {plan: name for name in all_agents(stage) for plan in _plans(stage, name)}
    picked: set[tuple[str, int]] = set()
    for path, numbers in selection.instances.items():
        if path in owners:
            picked.update((owners[path], number) for number in numbers)
        elif path.HasPrefix(Overlay.ROOT):
            picked.update((name, number) for name, number in _overlay_owners(stage, path, selection) if number >= 0)
    return picked


def _overlay_owners(stage: Usd.Stage, path: Sdf.Path, selection: Selection) -> set[tuple[str, int]]:
    """Names of the agents, and footsteps, that the selected instances of an overlay belong to."""
    prim = stage.GetPrimAtPath(path)
    while prim and not prim.GetAttribute(Overlay.OWNERS):
        prim = prim.GetParent()
    if not prim or not prim.GetPath().HasPrefix(Overlay.ROOT):
        return set()
    names, owners = (authored(prim, name) or () for name in (Overlay.AGENTS, Overlay.OWNERS))
    footsteps = authored(prim, Overlay.FOOTSTEPS) or [-1] * len(owners)
    rows = selection.instances.get(path, range(len(owners)))
    return {(str(names[owners[row]]), int(footsteps[row])) for row in rows if row < len(owners)}


def _plan_of(stage: Usd.Stage, name: str) -> Sdf.Path:
    """Raises SceneError if the agent has no plan."""
    plans = _plans(stage, name)
    if not plans:
        raise SceneError(f"{Prim.AGENTS}/{name}", "has no plan", f"{Agent.PLAN} must name one")
    return plans[0]


def _plans(stage: Usd.Stage, name: str) -> list[Sdf.Path]:
    return targets(stage.GetPrimAtPath(f"{Prim.AGENTS}/{name}"), Agent.PLAN)
