"""Footstep plans: PointInstancers of prints with times."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import repeat
from typing import Any, TypeVar

import numpy as np
from pxr import Usd, UsdGeom

from usdfoot.bridge.schema import has_api
from usdfoot.bridge.tokens import Plan as Token
from usdfoot.bridge.tokens import Schema
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.limits import DEFAULT_LIMITS
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.plan_checks import checked_plans
from usdfoot.model.plan_draft import PlanDraft
from usdfoot.model.report import Problem
from usdfoot.readers.authored import is_authored
from usdfoot.readers.plan_prints import cut_rows, path_orientations, place_prints, turn_prints
from usdfoot.readers.plan_sources import PRINTS, TIMES, PlanSource, ask_plan

__all__ = ["Planned", "is_plan", "plans_of", "read_draft", "read_plan", "read_prints"]

_UNTIMED = "author one entry a footstep, or let usdfoot plan timing find the times"
_SIDES, _POSITIONS = PRINTS[:2]
_ORIENTATIONS = ("orientationsf", "orientations")
"""Attributes of which the first counts that says something."""
SAME_TIME = 1e-4
"""Two first strikes or two last liftoffs nearer than this are at one time: a stand [s]."""

_Read = TypeVar("_Read", PlanDraft, FootstepPlan)

Drafted = tuple[PlanDraft, tuple[Problem, ...]]
"""What becomes a plan if it is in order, and warnings about it."""
Planned = tuple[FootstepPlan, tuple[Problem, ...]]
"""A plan, and warnings about it."""


def is_plan(prim: Usd.Prim) -> bool:
    """Whether a prim is a footstep plan: it has UsdfootPlanAPI, or is a PointInstancer with a plan's times."""
    if has_api(prim, Schema.PLAN):
        return True
    return prim.IsA(UsdGeom.PointInstancer) and any(
        is_authored(prim, f"{prefix}{name}") for prefix in ("", "primvars:") for name in TIMES
    )


def read_plan(prim: Usd.Prim, units: StageUnits, *, most: int = DEFAULT_LIMITS.footsteps) -> Planned:
    """The plan in the canonical world, and warnings about it.

    Args:
        prim: PointInstancer, with or without UsdfootPlanAPI.
        units: Of the stage.
        most: How many footsteps it may have.

    Raises:
        PlanError: If the prim is no PointInstancer, lacks an array, or the plan is inconsistent.
        SceneError: If it has too many footsteps.
    """
    return _or_raise(plans_of([ask_plan(prim, most=most)], units)[0])


def plans_of(sources: Sequence[PlanSource], units: StageUnits) -> list[Planned | PlanError]:
    """As `read_plan` of many plans, each as if it was the only one, from what has been asked."""
    drafts = _drafts_of(sources, units, is_timed=True)
    plans = iter(checked_plans([found[0] for found in drafts if not isinstance(found, PlanError)]))
    return [found if isinstance(found, PlanError) else _planned(next(plans), found[1]) for found in drafts]


def _planned(plan: FootstepPlan | PlanError, problems: tuple[Problem, ...]) -> Planned | PlanError:
    return plan if isinstance(plan, PlanError) else (plan, problems)


def read_draft(
    prim: Usd.Prim,
    units: StageUnits,
    *,
    most: int = DEFAULT_LIMITS.footsteps,
) -> Drafted:
    """As `read_plan`, but whether the arrays are a plan is not checked.

    Args:
        prim: As of `read_plan`.
        units: Of the stage.
        most: How many footsteps it may have.

    Raises:
        PlanError: If the prim is no PointInstancer or lacks an array.
        SceneError: If it has too many footsteps.
    """
    return _or_raise(_drafts_of([ask_plan(prim, most=most)], units, is_timed=True)[0])


def read_prints(
    prim: Usd.Prim,
    units: StageUnits,
    *,
    most: int = DEFAULT_LIMITS.footsteps,
) -> Drafted:
    """As `read_draft`, but without times, which are all zero.

    Raises:
        PlanError: If the prim is no PointInstancer or lacks an array of prints.
        SceneError: If it has too many footsteps.
    """
    return _or_raise(_drafts_of([ask_plan(prim, names=PRINTS, most=most)], units, is_timed=False)[0])


@dataclass(frozen=True, kw_only=True)
class _Authored:
    """Arrays of a plan as authored, each of its own length N."""

    source: PlanSource
    sides: IntArray
    """Shape (N,)."""
    local: np.ndarray
    """Positions in the plan's space [stage units], numbers of any type, shape (N, 3)."""
    orientations: np.ndarray | None
    """Xyzw, numbers of any type, shape (N, 4)."""
    times: tuple[FloatArray, FloatArray] | None
    """Strikes and liftoffs [s], shape (N,); None = nobody asked."""


def _authored_of(
    sources: Sequence[PlanSource], units: StageUnits, *, is_timed: bool
) -> dict[int, _Authored | PlanError]:
    """What is authored of plans, or which array one lacks, by their indices; those that lack one come first."""
    found: dict[int, _Authored | PlanError] = {}
    for index, source in enumerate(sources):
        missing = [name for name in (_SIDES, _POSITIONS, *(TIMES if is_timed else ())) if name not in source.said]
        if missing:
            remedy = _UNTIMED if missing[0] in TIMES else "author one entry a footstep"
            found[index] = PlanError(source.path, f"has no {missing[0]}", remedy)
    whole = {index: source for index, source in enumerate(sources) if index not in found}
    said = [source.said for source in whole.values()]
    sides = _sides([own[_SIDES] for own in said])
    strikes, liftoffs = ([own.get(name) for own in said] for name in TIMES)
    timed: Iterable[tuple[FloatArray, FloatArray] | None] = repeat(None)
    if is_timed:
        timed = zip(_times(strikes, units, is_end=False), _times(liftoffs, units, is_end=True), strict=True)
    for (index, source), own_sides, times in zip(whole.items(), sides, timed, strict=False):
        turns = [turn for name in _ORIENTATIONS if (turn := source.said.get(name)) is not None and len(turn)]
        found[index] = _Authored(
            source=source,
            sides=own_sides,
            local=np.asarray(source.said[_POSITIONS]),
            orientations=np.asarray(turns[0]) if turns else None,
            times=times,
        )
    return found


def _drafts_of(sources: Sequence[PlanSource], units: StageUnits, *, is_timed: bool) -> list[Drafted | PlanError]:
    """Plans, unchecked, or why there are none."""
    authored = _authored_of(sources, units, is_timed=is_timed)
    found: dict[int, Drafted | PlanError] = {i: error for i, error in authored.items() if isinstance(error, PlanError)}
    plans = {index: plan for index, plan in authored.items() if isinstance(plan, _Authored)}
    matrices = [plan.source.matrix for plan in plans.values()]
    positions = place_prints([plan.local for plan in plans.values()], matrices, units)
    facing = {index: plan.orientations for index, plan in plans.items() if plan.orientations is not None}
    turned = turn_prints(
        [plans[index].source.path for index in facing],
        list(facing.values()),
        [plans[index].source.matrix for index in facing],
        units=units,
    )
    orientations = dict(zip(facing, turned, strict=True))
    for (index, plan), placed in zip(plans.items(), positions, strict=True):
        own = orientations.get(index)
        found[index] = own if isinstance(own, PlanError) else _draft(plan, placed, own)
    return [found[index] for index in range(len(sources))]


def _draft(plan: _Authored, positions: FloatArray, orientations: FloatArray | None) -> Drafted:
    """A plan put together from where its prints are; without orientations they face along the path, with a warning."""
    said, path, problems = plan.source.said, plan.source.path, plan.source.ignored
    if orientations is None and (len(plan.sides) != len(positions) or len(plan.sides) < 2):
        orientations = np.tile([0.0, 0.0, 0.0, 1.0], (len(positions), 1))
    elif orientations is None:
        message = (
            f"{path}: has no orientations, the footsteps face along their path. author orientations where the "
            "character steps sideways or backward"
        )
        problems = (Problem(severity="warning", where=path, message=message), *problems)
        orientations = path_orientations(plan.sides, positions)
    weights, untimed = said.get(Token.ROOT_WEIGHTS), np.zeros(len(plan.sides))
    strikes, liftoffs = plan.times or (untimed, untimed)
    draft = PlanDraft(
        name=path,
        sides=plan.sides,
        positions=positions,
        orientations=orientations,
        strike_times=strikes,
        liftoff_times=liftoffs,
        root_weights=untimed if weights is None or not len(weights) else np.array(weights, dtype=float),
        styles=tuple(str(style) for style in said.get(Token.STYLES) or ()),
    )
    return draft, problems


def _sides(authored: Sequence[Any]) -> list[IntArray]:
    """Sides of plans, shape (N,) each."""
    arrays = [np.asarray(own) for own in authored]
    return cut_rows(np.concatenate(arrays).astype(int), arrays) if arrays else []


def _times(codes: Sequence[Any], units: StageUnits, *, is_end: bool) -> list[FloatArray]:
    """Times of plans [s], shape (N,) each, from their time codes.

    The first two of a plan, or the last two, are one where they are so near that rounding alone tells them apart.
    """
    arrays = [np.asarray(own) for own in codes]
    if not arrays:
        return []
    times, counts = units.codes_to_times(np.concatenate(arrays)), np.array([*map(len, arrays)])
    ends = counts.cumsum()
    first = (ends - 2 if is_end else ends - counts)[counts > 1]
    first = first[np.abs(times[first + 1] - times[first]) <= SAME_TIME]
    times[first + 1] = times[first]
    return cut_rows(times, arrays)


def _or_raise(found: tuple[_Read, tuple[Problem, ...]] | PlanError) -> tuple[_Read, tuple[Problem, ...]]:
    if isinstance(found, PlanError):
        raise found
    return found
