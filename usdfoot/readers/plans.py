"""Footstep plans: PointInstancers of prints with times."""

from __future__ import annotations

import logging
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from pxr import Usd, UsdGeom

from usdfoot.analysis.joint_words import side_of
from usdfoot.bridge.schema import has_api
from usdfoot.bridge.tokens import Plan as Token
from usdfoot.bridge.tokens import Schema
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import PlanError
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.plan import FootstepPlan, PlanDraft
from usdfoot.model.report import Problem
from usdfoot.readers.skeleton import StartTransforms
from usdfoot.readers.stage import authored_values, is_authored, targets
from usdfoot.readers.transform_codes import changes_place, changes_value

__all__ = [
    "PlanSource",
    "ask_plan",
    "is_plan",
    "path_orientations",
    "plan_of",
    "read_draft",
    "read_plan",
    "read_prints",
]

_logger = logging.getLogger(__name__)

_PRINTS = (
    str(UsdGeom.Tokens.protoIndices),
    str(UsdGeom.Tokens.positions),
    str(UsdGeom.Tokens.orientations),
    str(UsdGeom.Tokens.orientationsf),
    str(UsdGeom.Tokens.invisibleIds),
    Token.ROOT_WEIGHTS,
    Token.STYLES,
)
_TIMES = (Token.STRIKE_TIMES, Token.LIFTOFF_TIMES)
_UPRIGHT = 0.5
"""Prints whose normals rise less than this, on average, are read with the wrong axes: nobody stands on 60 degrees."""
_UNTURNED = np.eye(3)
_UNTIMED = "author one entry a footstep, or let usdfoot plan timing find the times"
SAME_TIME = 1e-4
"""Two first strikes or two last liftoffs nearer than this are at one time: a stand [s]."""
_IN_PLACE = 0.1
"""Shorter than this [m] the way past a footstep does not tell where it faces."""


@dataclass(frozen=True, kw_only=True)
class PlanSource:
    """All that USD says of a plan. To ask about many plans before any is computed takes a third less than by turns."""

    prim: Usd.Prim
    said: Mapping[str, Any]
    """Values authored for attributes, by name."""
    matrix: FloatArray
    """Local-to-world matrix (row vectors), shape (4, 4)."""
    ignored: tuple[Problem, ...]
    """Warnings of what does not count."""
    has_root: bool
    """Whether a root trajectory is given with it."""


def is_plan(prim: Usd.Prim) -> bool:
    """Whether a prim is a footstep plan: it has UsdfootPlanAPI, or is a PointInstancer with a plan's times."""
    if has_api(prim, Schema.PLAN):
        return True
    has_times = any(is_authored(prim, name) for name in _TIMES)
    return prim.IsA(UsdGeom.PointInstancer) and has_times


def read_plan(
    prim: Usd.Prim, units: StageUnits, transforms: StartTransforms | None = None
) -> tuple[FootstepPlan, tuple[Problem, ...]]:
    """The plan in the canonical world, and warnings about it.

    Args:
        prim: PointInstancer, with or without UsdfootPlanAPI.
        units: Of the stage.
        transforms: Of the stage, for whoever reads many plans.

    Raises:
        PlanError: If the prim is no PointInstancer, lacks an array, or the plan is inconsistent.
    """
    return plan_of(ask_plan(prim, transforms), units)


def ask_plan(
    prim: Usd.Prim, transforms: StartTransforms | None = None, names: Collection[str] = (*_PRINTS, *_TIMES)
) -> PlanSource:
    """What is said of a plan, by attributes of these names.

    Raises:
        PlanError: If the prim is no PointInstancer.
    """
    if not prim.IsA(UsdGeom.PointInstancer):
        kind = prim.GetTypeName() or "an untyped prim"
        raise PlanError(prim.GetPath(), f"is {kind}", "a footstep plan is a PointInstancer with UsdfootPlanAPI")
    said, transforms = authored_values(prim, names), transforms or StartTransforms(prim.GetStage())
    ignored = _ignored(prim, said.get(UsdGeom.Tokens.invisibleIds), transforms)
    return PlanSource(
        prim=prim,
        said=said,
        matrix=transforms.matrix_of(prim),
        ignored=ignored,
        has_root=bool(targets(prim, Token.ROOT_TRAJECTORY)),
    )


def plan_of(source: PlanSource, units: StageUnits) -> tuple[FootstepPlan, tuple[Problem, ...]]:
    """As `read_plan`, from what has been asked.

    Raises:
        PlanError: If an array is missing or the plan is inconsistent.
    """
    draft, problems = _draft_of(source, units)
    return draft.checked(), problems


def read_draft(
    prim: Usd.Prim, units: StageUnits, transforms: StartTransforms | None = None
) -> tuple[PlanDraft, tuple[Problem, ...]]:
    """As `read_plan`, but whether the arrays are a plan is not checked.

    Raises:
        PlanError: If the prim is no PointInstancer or lacks an array.
    """
    return _draft_of(ask_plan(prim, transforms), units)


def _draft_of(source: PlanSource, units: StageUnits) -> tuple[PlanDraft, tuple[Problem, ...]]:
    """The plan with its times, unchecked."""
    draft, problems = _prints_of(source, units)
    strikes, liftoffs = (units.codes_to_times(_array(source, name, (), float, _UNTIMED)) for name in _TIMES)
    draft = replace(draft, strike_times=_together(strikes, 0, 1), liftoff_times=_together(liftoffs, -2, -1))
    return draft, problems


def _together(times: FloatArray, one: int, other: int) -> FloatArray:
    """Times (N,) with the `other` equal to the `one` where they are so near that rounding alone tells them apart."""
    if len(times) < 2 or not abs(times[other] - times[one]) <= SAME_TIME:
        return times
    times = times.copy()
    times[other] = times[one]
    return times


def read_prints(
    prim: Usd.Prim, units: StageUnits, transforms: StartTransforms | None = None
) -> tuple[PlanDraft, tuple[Problem, ...]]:
    """As `read_draft`, but without times, which are all zero.

    Raises:
        PlanError: If the prim is no PointInstancer or lacks an array of prints.
    """
    return _prints_of(ask_plan(prim, transforms, _PRINTS), units)


def _prints_of(source: PlanSource, units: StageUnits) -> tuple[PlanDraft, tuple[Problem, ...]]:
    """The plan without its times, unchecked."""
    said, matrix = source.said, source.matrix
    sides = _array(source, UsdGeom.Tokens.protoIndices, (), int)
    local = _array(source, UsdGeom.Tokens.positions, (3,), float)
    positions = units.points_to_canonical(local @ matrix[:3, :3] + matrix[3, :3])
    orientations, problems = _orientations(source, units, sides, positions)
    weights = said.get(Token.ROOT_WEIGHTS)
    draft = PlanDraft(
        name=str(source.prim.GetPath()),
        sides=sides,
        positions=positions,
        orientations=orientations,
        strike_times=np.zeros(len(sides)),
        liftoff_times=np.zeros(len(sides)),
        root_weights=np.array(weights, dtype=float) if weights else np.zeros(len(sides)),
        styles=tuple(str(style) for style in said.get(Token.STYLES) or ()),
    )
    return draft, (*problems, *source.ignored)


def path_orientations(sides: IntArray, positions: FloatArray) -> FloatArray:
    """Level orientations that face along the path, for plans without any, xyzw, shape (N, 4).

    Each footstep faces from the one before to the one after it; where these two lie together, at right angles to the
    line from the right to the left foot.

    Args:
        sides: 0 = left, 1 = right, shape (N,).
        positions: Canonical [m], shape (N, 3).
    """
    count = len(positions)
    middle = np.clip(np.arange(count), 1, max(1, count - 2))
    along = positions[np.minimum(middle + 1, count - 1)] - positions[np.maximum(middle - 1, 0)]
    nearest = np.maximum(np.arange(count) - 1, 0)
    other = np.where(np.arange(count) > 0, nearest, min(1, count - 1))
    to_left = (positions - positions[other]) * np.where(sides == 0, 1.0, -1.0)[:, None]
    across = np.cross(to_left, [0.0, 1.0, 0.0])
    in_place = np.hypot(along[:, 0], along[:, 2]) < _IN_PLACE
    if count < 3:
        in_place[:] = True
    forward = np.where(in_place[:, None], across, along)
    return quaternion.yaw_quaternion(np.arctan2(forward[:, 0], forward[:, 2]))


def _array(
    source: PlanSource, name: str, shape: tuple[int, ...], kind: type, remedy: str = "author one entry a footstep"
) -> np.ndarray:
    """An array of what is said of the plan, shape (N, *shape)."""
    value = source.said.get(name)
    if value is None:
        raise PlanError(source.prim.GetPath(), f"has no {name}", remedy)
    array: np.ndarray = np.array(value, dtype=kind)
    return array if array.size else np.zeros((0, *shape), dtype=kind)


def _orientations(
    source: PlanSource, units: StageUnits, sides: IntArray, positions: FloatArray
) -> tuple[FloatArray, tuple[Problem, ...]]:
    """Canonical orientations of the prints; without any they face along the path, with a warning."""
    prim, said = source.prim, source.said
    value = next((v for name in ("orientationsf", "orientations") if (v := said.get(name))), None)
    if value is not None:
        turned = _to_world(prim, units, source.matrix, np.array(value, dtype=float))
        _check_upright(prim, turned)
        return turned, ()
    if len(sides) != len(positions) or len(sides) < 2:
        return np.tile([0.0, 0.0, 0.0, 1.0], (len(positions), 1)), ()
    message = (
        f"{prim.GetPath()}: has no orientations, the footsteps face along their path. author orientations where the "
        "character steps sideways or backward"
    )
    problem = Problem(severity="warning", where=str(prim.GetPath()), message=message)
    return path_orientations(sides, positions), (problem,)


def _check_upright(prim: Usd.Prim, orientations: FloatArray) -> None:
    """Raises PlanError if nothing could stand on a print, canonical orientations (N, 4)."""
    heights = 1.0 - 2.0 * (orientations[:, 0] ** 2 + orientations[:, 2] ** 2)  # of the normals
    down = np.flatnonzero(heights <= 0.0)
    if down.size:
        angle = np.degrees(np.arccos(np.clip(heights[down[0]], -1.0, 1.0)))
        what = f"footstep {down[0]} stands on edge or upside down, its normal is {angle:.0f} degrees off the vertical"
        raise PlanError(prim.GetPath(), what, "author orientations that turn its up axis to the normal")


def _ignored(prim: Usd.Prim, hidden: Any, transforms: StartTransforms) -> tuple[Problem, ...]:
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
    where = prim.GetPath() if found else ""
    return tuple(Problem(severity="warning", where=str(where), message=f"{where}: {text}") for text in found)


def _to_world(prim: Usd.Prim, units: StageUnits, matrix: FloatArray, orientations: FloatArray) -> FloatArray:
    """Orientations with the plan's own transform applied, in the canonical world.

    Whether +Z or -Y of a print is its forward depends on the stage's up axis. A plan from a stage with the other up
    axis that a transform stands up here lies on its side when read so; then its own stage's axes are meant.
    """
    lengths = np.sqrt(np.einsum("ij,ij->i", orientations, orientations))
    usable = (lengths > 1e-3) & (lengths < np.inf)
    if not usable.all():
        raise PlanError(
            prim.GetPath(),
            f"orientation of footstep {np.flatnonzero(~usable)[0]} is zero or not finite",
            "author unit quaternions",
        )
    own = orientations / lengths[:, None]
    if np.array_equal(matrix[:3, :3], _UNTURNED):
        unturned = units.rotations_to_canonical(own)
        if (1.0 - 2.0 * (unturned[:, 0] ** 2 + unturned[:, 2] ** 2)).mean() >= _UPRIGHT:
            return np.where(unturned[:, 3:] < 0.0, -unturned, unturned)
    volume = np.linalg.det(matrix[:3, :3]) if np.isfinite(matrix).all() else np.nan
    if not volume or np.isnan(volume):
        raise PlanError(prim.GetPath(), "has a transform that is not finite or flattens it", "scale by numbers above 0")
    if volume < 0.0:
        raise PlanError(prim.GetPath(), "is mirrored by its transform", "left would be right; bake the mirror into it")
    other = replace(units, up_axis="Y" if units.up_axis == "Z" else "Z")
    forward, normal = _print_axes(units, matrix, own, units)
    if normal[:, 1].mean() < _UPRIGHT:
        forward_other, normal_other = _print_axes(units, matrix, own, other)
        if normal_other[:, 1].mean() > _UPRIGHT:
            _logger.info("%s: its prints stand as in a stage with %s up", prim.GetPath(), other.up_axis)
            forward, normal = forward_other, normal_other
    axes = np.stack([np.cross(normal, forward), normal, forward], axis=-1)  # columns are X, Y, Z
    return quaternion.from_matrix(axes)


def _print_axes(
    units: StageUnits, matrix: FloatArray, own: FloatArray, axes: StageUnits
) -> tuple[FloatArray, FloatArray]:
    """Forward and normal of prints in the canonical world, unit and at right angles, shape (N, 3) each.

    Forward goes with the surface the prints lie on and the normal stays at right angles to it, so that transforms
    with different scales work too.

    Args:
        units: Of the stage.
        matrix: Plan to world (row vectors), shape (4, 4).
        own: Orientations as authored, unit xyzw, shape (N, 4).
        axes: Units whose up axis tells which axes of a print are forward and normal.
    """
    forward_own, normal_own = axes.directions_to_stage(np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]))
    linear = matrix[:3, :3]
    forward = units.directions_to_canonical(quaternion.rotate(own, forward_own) @ linear)
    normal = units.directions_to_canonical(quaternion.rotate(own, normal_own) @ np.linalg.inv(linear).T)
    normal = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    forward = forward - np.sum(forward * normal, axis=-1, keepdims=True) * normal
    return forward / np.linalg.norm(forward, axis=-1, keepdims=True), normal
