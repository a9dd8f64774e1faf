"""Prints: where the footprints of plans lie in the world, and which way they face.

Of many plans at once, whose prints are rows of one array: a plan has about fifteen, of which numpy would be told one by
one. What comes out of one plan does not depend on the others.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace
from itertools import accumulate, pairwise

import numpy as np

from usdfoot.bridge.units import StageUnits
from usdfoot.errors import PlanError
from usdfoot.maths import quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray

__all__ = ["cut_rows", "path_orientations", "place_prints", "turn_prints"]

_logger = logging.getLogger(__name__)

_UPRIGHT = 0.5
"""Prints whose normals rise less than this, on average, are read with the wrong axes: nobody stands on 60 degrees."""
_IN_PLACE = 0.1
"""Shorter than this [m] the way past a footstep does not tell where it faces."""


def place_prints(local: Sequence[np.ndarray], matrices: Sequence[FloatArray], units: StageUnits) -> list[FloatArray]:
    """Positions in the canonical world [m], shape (N, 3) for each plan.

    Args:
        local: In the spaces of P plans, stage units, numbers of any type, shape (N, 3) each.
        matrices: From the plans to the world (row vectors), shape (4, 4) each.
        units: Of the stage.
    """
    if not local:
        return []
    rows = np.concatenate(local).astype(float)
    to_world = np.repeat(np.stack(matrices), [len(own) for own in local], axis=0)
    turned = sum((rows[:, axis, None] * to_world[:, axis, :3] for axis in (1, 2)), rows[:, :1] * to_world[:, 0, :3])
    return cut_rows(units.points_to_canonical(turned + to_world[:, 3, :3]), local)


def turn_prints(
    paths: Sequence[str], authored: Sequence[np.ndarray], matrices: Sequence[FloatArray], *, units: StageUnits
) -> list[FloatArray | PlanError]:
    """Orientations in the canonical world, xyzw, shape (N, 4) for each plan, or why there are none.

    Whether +Z or -Y of a print is its forward depends on the stage's up axis. A plan from a stage with the other up
    axis that a transform stands up here lies on its side when read so; then its own stage's axes are meant.

    Args:
        paths: Of P plans, for messages.
        authored: Quaternions xyzw, numbers of any type, N of at least one, shape (N, 4) each.
        matrices: From the plans to the world (row vectors), shape (4, 4) each.
        units: Of the stage.
    """
    if not authored:
        return []
    rows = np.concatenate(authored).astype(float)
    lengths = np.sqrt(np.einsum("ij,ij->i", rows, rows))
    usable = (lengths > 1e-3) & (lengths < np.inf)
    own = rows / np.where(usable, lengths, 1.0)[:, None]
    unturned = units.rotations_to_canonical(own)
    unturned = np.where(unturned[:, 3:] < 0.0, -unturned, unturned)
    firsts = list(accumulate((len(each) for each in authored[:-1]), initial=0))
    rises = _rises(unturned)
    upright = np.add.reduceat(rises, firsts) / [len(each) for each in authored] >= _UPRIGHT
    upright &= (np.stack(matrices)[:, :3, :3] == np.eye(3)).all(axis=(1, 2))
    fine = upright & (np.minimum.reduceat(rises, firsts) > 0.0) & np.logical_and.reduceat(usable, firsts)
    found: list[FloatArray | PlanError] = []
    cut = zip(cut_rows(unturned, authored), cut_rows(own, authored), cut_rows(usable, authored), strict=True)
    for index, (ready, units_own, is_usable) in enumerate(cut):
        try:
            if not fine[index]:
                _check_usable(paths[index], is_usable)
                if not upright[index]:
                    ready = _turned(paths[index], units, matrices[index], units_own)
                _check_upright(paths[index], ready)
            found.append(ready)
        except PlanError as error:
            found.append(error)
    return found


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


def cut_rows(rows: np.ndarray, plans: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The rows of each plan, as many as it has prints."""
    return [rows[first:end] for first, end in pairwise(accumulate(map(len, plans), initial=0))]


def _rises(orientations: FloatArray) -> FloatArray:
    """How far the normals of prints rise, 1 = straight up, of canonical orientations (N, 4)."""
    return 1.0 - 2.0 * (orientations[:, 0] ** 2 + orientations[:, 2] ** 2)


def _check_usable(path: str, usable: BoolArray) -> None:
    """Raises PlanError if an orientation (N,) is none."""
    if not usable.all():
        what = f"orientation of footstep {np.flatnonzero(~usable)[0]} is zero or not finite"
        raise PlanError(path, what, "author unit quaternions")


def _check_upright(path: str, orientations: FloatArray) -> None:
    """Raises PlanError if nothing could stand on a print, canonical orientations (N, 4)."""
    rises = _rises(orientations)
    down = np.flatnonzero(rises <= 0.0)
    if down.size:
        angle = np.degrees(np.arccos(np.clip(rises[down[0]], -1.0, 1.0)))
        what = f"footstep {down[0]} stands on edge or upside down, its normal is {angle:.0f} degrees off the vertical"
        raise PlanError(path, what, "author orientations that turn its up axis to the normal")


def _turned(path: str, units: StageUnits, matrix: FloatArray, own: FloatArray) -> FloatArray:
    """Unit orientations (N, 4) with the plan's own transform applied, in the canonical world.

    Raises:
        PlanError: If the transform leaves no prints.
    """
    volume = np.linalg.det(matrix[:3, :3]) if np.isfinite(matrix).all() else np.nan
    if not volume or np.isnan(volume):
        raise PlanError(path, "has a transform that is not finite or flattens it", "scale by numbers above 0")
    if volume < 0.0:
        raise PlanError(path, "is mirrored by its transform", "left would be right; bake the mirror into it")
    other = replace(units, up_axis="Y" if units.up_axis == "Z" else "Z")
    forward, normal = _print_axes(units, matrix, own, units)
    if normal[:, 1].mean() < _UPRIGHT:
        forward_other, normal_other = _print_axes(units, matrix, own, other)
        if normal_other[:, 1].mean() > _UPRIGHT:
            _logger.info("%s: its prints stand as in a stage with %s up", path, other.up_axis)
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
