"""Plan sources: what USD says of footstep plans, before anything of it is computed."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from pxr import Usd, UsdGeom

from usdfoot.analysis.joint_words import side_of
from usdfoot.bridge.tokens import Plan as Token
from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
from usdfoot.model.limits import DEFAULT_LIMITS, check_limit
from usdfoot.model.report import Problem
from usdfoot.readers.skeleton import StartTransforms
from usdfoot.readers.stage import authored_or_primvar, authored_values, targets
from usdfoot.readers.transform_codes import changes_place, changes_value

__all__ = ["PRINTS", "TIMES", "PlanSource", "ask_plan"]

PRINTS = (
    str(UsdGeom.Tokens.protoIndices),
    str(UsdGeom.Tokens.positions),
    str(UsdGeom.Tokens.orientations),
    str(UsdGeom.Tokens.orientationsf),
    str(UsdGeom.Tokens.invisibleIds),
    Token.ROOT_WEIGHTS,
    Token.STYLES,
)
"""Attributes of a plan's prints."""
TIMES = (Token.STRIKE_TIMES, Token.LIFTOFF_TIMES)
"""Attributes that say when these are walked on."""

_OWN = (*TIMES, Token.ROOT_WEIGHTS, Token.STYLES)


@dataclass(frozen=True, kw_only=True)
class PlanSource:
    """All that USD says of a plan. To ask about many plans before any is computed takes a third less than by turns."""

    path: str
    """Of the prim."""
    said: Mapping[str, Any]
    """Values authored for attributes, by name."""
    matrix: FloatArray
    """Local-to-world matrix (row vectors), shape (4, 4)."""
    ignored: tuple[Problem, ...]
    """Warnings of what does not count."""
    has_root: bool
    """Whether a root trajectory is given with it."""


def ask_plan(
    prim: Usd.Prim,
    transforms: StartTransforms | None = None,
    names: Collection[str] = (*PRINTS, *TIMES),
    *,
    most: int = DEFAULT_LIMITS.footsteps,
) -> PlanSource:
    """What is said of a plan, by attributes of these names.

    Args:
        prim: PointInstancer.
        transforms: Of the stage, for whoever asks about many plans.
        names: Of attributes.
        most: How many footsteps it may have.

    Raises:
        PlanError: If the prim is no PointInstancer.
        SceneError: If it has too many footsteps.
    """
    if not prim.IsA(UsdGeom.PointInstancer):
        kind = prim.GetTypeName() or "an untyped prim"
        raise PlanError(prim.GetPath(), f"is {kind}", "a footstep plan is a PointInstancer with UsdfootPlanAPI")
    said, transforms = _said(prim, names), transforms or StartTransforms(prim.GetStage())
    path = str(prim.GetPath())
    check_limit(path, "footsteps", max(len(said.get(name) or ()) for name in (*PRINTS[:2], *TIMES)), limit=most)
    return PlanSource(
        path=path,
        said=said,
        matrix=transforms.matrix_of(prim),
        ignored=_ignored(prim, path, said.get(UsdGeom.Tokens.invisibleIds), transforms),
        has_root=bool(targets(prim, Token.ROOT_TRAJECTORY)),
    )


def _said(prim: Usd.Prim, names: Collection[str]) -> dict[str, Any]:
    """Values authored for attributes, by name; those of plans may be primvars, as Houdini writes them."""
    said = authored_values(prim, names)
    values = {name: authored_or_primvar(prim, name) for name in _OWN if name in names and name not in said}
    return said | {name: value for name, value in values.items() if value is not None}


def _ignored(prim: Usd.Prim, path: str, hidden: Any, transforms: StartTransforms) -> tuple[Problem, ...]:
    """Warnings of what viewers show otherwise: feet go by index, hidden prints stay and are counted, and none moves."""
    found = []
    edits = prim.GetMetadata(UsdGeom.Tokens.inactiveIds)
    for state, count in (
        ("inactive", len(edits.ApplyOperations([])) if edits else 0),
        ("invisible", len(hidden) if hidden else 0),
    ):
        if count:
            found.append(
                f"{count} of its prints are {state}, but stay footsteps. delete their entries from every array"
            )
    prints = [path.name for path in targets(prim, UsdGeom.Tokens.prototypes)[:2]]
    if len(prints) == 2 and side_of(prints[0]) == 1 and side_of(prints[1]) == 0:
        named = ", ".join(prints)
        found.append(f"its prototypes are {named}, but index 0 is a left foot. list the left print first")
    if changes_value(prim.GetAttribute(UsdGeom.Tokens.positions)):
        found.append("its positions are animated, the first sample is read. author one value, not time samples")
    if transforms.is_moving(prim) and changes_place(prim):
        found.append("its transform is animated, its prints are read at the stage's start. remove the animation")
    return tuple(Problem(severity="warning", where=path, message=f"{path}: {text}") for text in found)
