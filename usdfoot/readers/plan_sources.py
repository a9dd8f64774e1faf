"""Plan sources: what USD says of footstep plans, before anything of it is computed."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from pxr import Usd, UsdGeom

from usdfoot.analysis.joint_words import side_of
from usdfoot.bridge.tokens import Plan as Token
from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
from usdfoot.model.limits import DEFAULT_LIMITS, check_limit
from usdfoot.model.report import Problem
from usdfoot.readers.authored import authored_in, authored_or_primvar, targets
from usdfoot.readers.skeleton import StartTransforms
from usdfoot.readers.transform_codes import changes_place, changes_value

__all__ = ["PRINTS", "TIMES", "PlanSource", "ask_plan"]

_POSITIONS, _HIDDEN = str(UsdGeom.Tokens.positions), str(UsdGeom.Tokens.invisibleIds)
_PLACE = str(UsdGeom.Tokens.xformOpOrder)
"""Attribute without which a prim is where the one above it is."""
_INACTIVE, _PROTOTYPES = str(UsdGeom.Tokens.inactiveIds), str(UsdGeom.Tokens.prototypes)
PRINTS = (
    str(UsdGeom.Tokens.protoIndices),
    _POSITIONS,
    str(UsdGeom.Tokens.orientations),
    str(UsdGeom.Tokens.orientationsf),
    _HIDDEN,
    Token.ROOT_WEIGHTS,
    Token.STYLES,
)
"""Attributes of a plan's prints."""
TIMES = (Token.STRIKE_TIMES, Token.LIFTOFF_TIMES)
"""Attributes that say when these are walked on."""
_ALL = frozenset((*PRINTS, *TIMES))
_EACH = (*PRINTS[:2], *TIMES)
"""Attributes that have an entry a footstep."""

_ANIMATED = "are animated, the first sample is read. author one value, not time samples"
_MOVED = "its transform is animated, its prints are read at the stage's start. remove the animation"

_PRIMVARS = {f"primvars:{name}": name for name in (*TIMES, Token.ROOT_WEIGHTS, Token.STYLES)}
"""Attributes of plans by the names they have as primvars."""


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
    """Warnings of what viewers show otherwise."""
    has_root: bool
    """Whether a root trajectory is given with it."""


def ask_plan(
    prim: Usd.Prim,
    transforms: StartTransforms | None = None,
    names: Collection[str] = _ALL,
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
    given, transforms = prim.GetAuthoredPropertyNames(), transforms or StartTransforms(prim.GetStage())
    queries = {name: Usd.AttributeQuery(prim, name) for name in given if name in names}
    said, path = _said(prim, given, names, queries), str(prim.GetPath())
    counts = [len(said[name]) for name in _EACH if name in said]
    check_limit(path, "footsteps", max(counts, default=0), limit=most)
    place = transforms.place_of(prim if _PLACE in given else prim.GetParent())
    ignored = [
        *_unseen(prim, said.get(_HIDDEN)),
        *(_swapped(prim) if _PROTOTYPES in given else ()),
        *_animated(queries),
        *((_MOVED,) if place.is_moving and changes_place(prim) else ()),
    ]
    return PlanSource(
        path=path,
        said=said,
        matrix=place.matrix,
        ignored=tuple(Problem(severity="warning", where=path, message=f"{path}: {text}") for text in ignored),
        has_root=Token.ROOT_TRAJECTORY in given and bool(targets(prim, Token.ROOT_TRAJECTORY)),
    )


def _said(
    prim: Usd.Prim, given: Collection[str], names: Collection[str], queries: Mapping[str, Usd.AttributeQuery]
) -> dict[str, Any]:
    """Values of the given attributes, by name; those of plans may be primvars, as Houdini writes them."""
    said = {name: authored_in(query, prim, name) for name, query in queries.items()}
    for name in (_PRIMVARS[primvar] for primvar in given if primvar in _PRIMVARS):
        if name in names and said.get(name) is None:
            said[name] = authored_or_primvar(prim, name)
    return {name: value for name, value in said.items() if value is not None}


def _unseen(prim: Usd.Prim, hidden: Any) -> Iterator[str]:
    """What is wrong with prints that viewers do not show: they stay, and are counted."""
    edits = prim.GetMetadata(_INACTIVE)
    for state, count in (
        ("inactive", len(edits.ApplyOperations([])) if edits else 0),
        ("invisible", len(hidden) if hidden else 0),
    ):
        if count:
            yield f"{count} of its prints are {state}, but stay footsteps. delete their entries from every array"


def _animated(queries: Mapping[str, Usd.AttributeQuery]) -> Iterator[str]:
    """What is wrong with a plan that changes over time."""
    names = [name for name, query in queries.items() if name != _HIDDEN and changes_value(query)]
    if names:
        yield f"its {', '.join(names)} {_ANIMATED}"


def _swapped(prim: Usd.Prim) -> Iterator[str]:
    """What is wrong with prototypes in another order than feet, which go by index."""
    prints = tuple(path.name for path in targets(prim, _PROTOTYPES)[:2])
    if _are_swapped(prints):
        yield f"its prototypes are {', '.join(prints)}, but index 0 is a left foot. list the left print first"


@lru_cache(maxsize=1024)
def _are_swapped(prints: tuple[str, ...]) -> bool:
    """Whether names say that the first print is a right foot's and the second a left one's."""
    return len(prints) == 2 and side_of(prints[0]) == 1 and side_of(prints[1]) == 0
