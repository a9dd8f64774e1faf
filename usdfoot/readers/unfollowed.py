"""Unfollowed: what artists say in overrides.usda and no run follows, told so that nobody waits for it."""

from __future__ import annotations

from collections.abc import Collection

from pxr import Sdf, Usd, UsdGeom, UsdSkel

from usdfoot.bridge.tokens import Agent, File, Op, Prim, turn_op
from usdfoot.model.report import Problem
from usdfoot.readers.agent_ops import has_ops
from usdfoot.readers.attributes import array_at
from usdfoot.readers.overrides import Overrides

__all__ = ["find_unfollowed"]

_OF_THE_SCENE = (Agent.PATH, Agent.TRAJECTORY)
"""Relationships to prims of the scene that more is read of than artists can say here."""
_ORDER = str(UsdGeom.Tokens.xformOpOrder)
_OWN = (Op.TRANSLATE, turn_op("Y"), turn_op("Z"), Op.ORIENT_STANCE, Op.SCALE_STANCE)
"""Ops that are listed without the artists."""
_BELOW = Usd.PrimAllPrimsPredicate


def find_unfollowed(overrides: Overrides, names: Collection[str]) -> tuple[Problem, ...]:
    """A warning for each thing that artists say and no run follows.

    Args:
        overrides: Of the artists.
        names: Of all agents of the scene.
    """
    stage = overrides.stage
    if stage is None:
        return ()
    scopes = [stage.GetPrimAtPath(path) for path in (Prim.AGENTS, Prim.PLANS)]
    agents, plans = (scope.GetAllChildren() if scope else () for scope in scopes)
    overs = [prim for prim in (*agents, *plans) if prim.GetSpecifier() == Sdf.SpecifierOver]
    return (
        *_of_the_crowd(stage.GetPrimAtPath(Prim.CROWD)),
        *(problem for prim in agents for problem in _of_an_agent(prim)),
        *(
            _told(prim, "no agent of the scene has this name. correct it, or take it away")
            for prim in overs
            if prim.GetName() not in names
        ),
    )


def _of_the_crowd(prim: Usd.Prim) -> list[Problem]:
    if not prim or not has_ops(prim):
        return []
    return [_told(prim, "contacts and terrain do not go with its transform. move the prim that references the crowd")]


def _of_an_agent(prim: Usd.Prim) -> list[Problem]:
    """What is said of one agent."""
    said = prim.GetAuthoredPropertyNames()
    reasons = [f"{name} is not followed here. author it in the scene" for name in _OF_THE_SCENE if name in said]
    order = array_at(prim.GetAttribute(_ORDER))
    for name in said:
        if name.startswith("xformOp:") and name not in _OWN and not {name, f"!invert!{name}"} & set(order):
            reasons.append(f"{name} is not in {_ORDER} and moves nothing. list it there")
    if any(below.IsA(UsdSkel.Skeleton) for below in Usd.PrimRange(prim, _BELOW)):
        reasons.append(f"holds a Skeleton that is not animated. point {Agent.CHARACTER} at another character instead")
    return [_told(prim, reason) for reason in reasons]


def _told(prim: Usd.Prim, reason: str) -> Problem:
    where = f"{File.OVERRIDES} {prim.GetPath()}"
    return Problem(severity="warning", where=where, message=f"{where}: {reason}")
