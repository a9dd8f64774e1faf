"""Root trajectories: animated Xforms, and Points whose ids are agents."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from pxr import Usd, UsdGeom

from usdfoot.bridge.tokens import Agent as Token
from usdfoot.bridge.tokens import Plan
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import PlanError
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.trajectory import RootTrajectory, find_breaks, root_distances
from usdfoot.readers.attributes import array_at
from usdfoot.readers.authored import targets
from usdfoot.readers.skeleton import matrices_of
from usdfoot.readers.transform_codes import is_animated, transform_codes

__all__ = ["TrajectoryReader"]

_SAME_TIME = 1e-6
"""[s]"""
_JUST_AFTER = 1e-6
"""How long after a sample ids are asked for [time codes]: layer offsets round, and a moment before it they are the last
sample's."""
_FARTHEST_ROOT = 1.0
"""A root trajectory farther than this from the middle of the feet belongs to other footsteps [m]."""
_LEAST_TURN = np.radians(1.0)
"""A transform that turns less than this over all its samples does not say where the root faces [rad]."""


@dataclass(frozen=True, kw_only=True)
class _Cloud:
    """All samples of a Points prim, by id and time."""

    ids: IntArray
    """Not decreasing, shape (N,)."""
    times: FloatArray
    """[s], increasing within an id, shape (N,)."""
    positions: FloatArray
    """World [m], shape (N, 3)."""
    yaws: FloatArray | None
    """Of a PointInstancer with orientations [rad], shape (N,)."""
    shown: BoolArray
    """Whether a PointInstancer shows it then, shape (N,)."""


@dataclass(kw_only=True)
class TrajectoryReader:
    """Reads trajectories, each Points prim only once however many agents it holds."""

    units: StageUnits
    _clouds: dict[str, _Cloud | PlanError] = field(default_factory=dict)

    def read(self, prim: Usd.Prim, number: int | None) -> RootTrajectory:
        """The trajectory a prim holds, in the canonical world.

        The rotation of an Xform is the heading if it is animated: an op of its own that turns has time samples, or a
        matrix turns over time. Otherwise the root faces where it goes.

        Args:
            prim: Xformable with time samples, on itself or above; Points or PointInstancer with ids.
            number: The agent's id among points, None if it has none. Instances without ids have their index.

        Raises:
            PlanError: If the prim is neither, has no samples or ids, or lacks the id.
        """
        if prim.IsA(UsdGeom.Points) or prim.IsA(UsdGeom.PointInstancer):
            return self._point(prim, number)
        if not prim.IsA(UsdGeom.Xformable):
            kind = prim.GetTypeName() or "an untyped prim"
            raise PlanError(prim.GetPath(), f"is {kind}", "a trajectory is an Xformable with time samples, or Points")
        codes = transform_codes(prim)
        if len(codes) < 2:
            raise PlanError(
                prim.GetPath(),
                f"has {len(codes)} time sample(s) of its transform",
                "a trajectory is animated; author time samples of xformOp:translate",
            )
        matrices = matrices_of(prim, codes)
        yaws = _yaws(self.units, matrices[:, :3, :3])
        turns = yaws is not None and (_rotation_is_sampled(prim) or np.ptp(yaws) > _LEAST_TURN)
        return RootTrajectory(
            name=str(prim.GetPath()),
            times=self.units.codes_to_times(codes),
            positions=self.units.points_to_canonical(matrices[:, 3, :3]),
            yaws=yaws if turns else None,
            rest_yaw=float(yaws[0]) if yaws is not None else 0.0,
        )

    def read_for_plan(self, prim: Usd.Prim, plan: FootstepPlan, number: int | None) -> RootTrajectory | None:
        """The root trajectory given with a plan ([B] 4.2), None if there is none.

        Args:
            prim: The plan's prim.
            plan: As read.
            number: The agent's id among points, None if it has none.

        Raises:
            PlanError: If it cannot be read, does not last as long as the plan, or leads elsewhere.
        """
        found = targets(prim, Plan.ROOT_TRAJECTORY)
        if not found:
            return None
        target = prim.GetStage().GetPrimAtPath(found[0])
        if not target:
            raise PlanError(plan.name, f"{Plan.ROOT_TRAJECTORY} points at what does not exist", "correct it", found)
        trajectory = self.read(target, number)
        if trajectory.start > plan.start + _SAME_TIME or trajectory.end < plan.end - _SAME_TIME:
            raise PlanError(
                trajectory.name,
                f"lasts from {trajectory.start:.4g} to {trajectory.end:.4g} s",
                f"the footsteps of {plan.name} need it from {plan.start:.4g} to {plan.end:.4g} s",
            )
        distances = root_distances(trajectory, plan)
        if distances.max() > _FARTHEST_ROOT:
            worst = int(np.argmax(distances)) + 1
            raise PlanError(
                trajectory.name,
                f"is {distances.max():.2g} m away from the feet at footstep {worst} of {plan.name}",
                f"a root stays within {_FARTHEST_ROOT} m of the middle of its feet",
            )
        return trajectory

    def read_all(self, prim: Usd.Prim) -> tuple[tuple[int | None, RootTrajectory | PlanError], ...]:
        """All trajectories a prim holds, each with its id among points, or why one of them cannot be read.

        Points that a PointInstancer hides or has deactivated are not there; a point that jumps, or is gone for long, is
        another one from then on, and one seen only once none.

        Raises:
            PlanError: If the prim holds none.
        """
        if not (prim.IsA(UsdGeom.Points) or prim.IsA(UsdGeom.PointInstancer)):
            return ((None, self.read(prim, None)),)
        cloud = self._cloud(prim)
        rows = np.flatnonzero(cloud.shown)
        jumps, gaps = find_breaks(cloud.times[rows], cloud.positions[rows])
        gaps &= np.diff(np.unique(cloud.times, return_inverse=True)[1][rows]) > 1  # others have samples in between
        cuts = np.flatnonzero((np.diff(cloud.ids[rows]) != 0) | jumps | gaps) + 1
        parts = [part for part in np.split(rows, cuts) if len(part) > 1]
        return tuple((int(cloud.ids[part[0]]), _part_of(cloud, part, str(prim.GetPath()))) for part in parts)

    def _point(self, prim: Usd.Prim, number: int | None) -> RootTrajectory:
        if number is None:
            raise PlanError(prim.GetPath(), "holds many trajectories", f"author int64 {Token.ID} on the agent")
        cloud = self._cloud(prim)
        first, stop = np.searchsorted(cloud.ids, [number, number + 1])
        if first == stop:
            known = np.unique(cloud.ids)
            raise PlanError(prim.GetPath(), f"has no id {number} at any time", "its ids are those listed", known)
        rows = np.arange(first, stop)[cloud.shown[first:stop]]
        if len(rows) == 0:
            raise PlanError(prim.GetPath(), f"hides id {number} at all times", "show it while it walks")
        return _trajectory_of(cloud, rows, str(prim.GetPath()))

    def _cloud(self, prim: Usd.Prim) -> _Cloud:
        key = str(prim.GetPath())
        if key not in self._clouds:
            try:
                self._clouds[key] = _read_cloud(prim, self.units)
            except PlanError as error:
                self._clouds[key] = error
        cloud = self._clouds[key]
        if isinstance(cloud, PlanError):
            raise cloud
        return cloud


def _trajectory_of(cloud: _Cloud, rows: IntArray, where: str) -> RootTrajectory:
    """Raises PlanError as RootTrajectory does."""
    return RootTrajectory(
        name=f"{where} id {cloud.ids[rows[0]]}",
        times=cloud.times[rows],
        positions=cloud.positions[rows],
        yaws=None if cloud.yaws is None else np.unwrap(cloud.yaws[rows]),
    )


def _part_of(cloud: _Cloud, rows: IntArray, where: str) -> RootTrajectory | PlanError:
    try:
        return _trajectory_of(cloud, rows, where)
    except PlanError as error:
        return error


def _rotation_is_sampled(prim: Usd.Prim) -> bool:
    """Whether a rotation op of the prim, but no matrix, is animated."""
    moves = (UsdGeom.XformOp.TypeTranslate, UsdGeom.XformOp.TypeScale, UsdGeom.XformOp.TypeTransform)
    ops = UsdGeom.Xformable(prim).GetOrderedXformOps()
    return any(op.GetOpType() not in moves and is_animated(op) for op in ops)


def _yaws(units: StageUnits, linear: FloatArray) -> FloatArray | None:
    """Continuous headings of forward axes under matrices (K, 3, 3) (row vectors); None where one points up or down."""
    forward = units.directions_to_canonical(units.directions_to_stage(np.array([0.0, 0.0, 1.0])) @ linear)
    level = forward[..., [0, 2]]
    if np.any(np.linalg.norm(level, axis=-1) <= 1e-3 * np.linalg.norm(forward, axis=-1)):
        return None
    return np.asarray(np.unwrap(planar.yaw_of(level)))


def _read_cloud(prim: Usd.Prim, units: StageUnits) -> _Cloud:
    """Raises PlanError if points or ids are missing or do not match."""
    is_instancer = prim.IsA(UsdGeom.PointInstancer)
    name = UsdGeom.Tokens.positions if is_instancer else UsdGeom.Tokens.points
    points, ids = prim.GetAttribute(name), prim.GetAttribute(UsdGeom.Tokens.ids)
    has_ids = bool(ids and ids.HasAuthoredValue())
    if not has_ids and not is_instancer:
        raise PlanError(prim.GetPath(), "has no ids", "author ids, one a point, so that points can be told apart")
    codes = np.array(sorted({*points.GetTimeSamples(), *transform_codes(prim)}), dtype=float)
    if len(codes) < 2:
        raise PlanError(prim.GetPath(), f"has {len(codes)} time sample(s) of {name}", "a trajectory is animated")
    indices = None if has_ids else _indices(prim, points)
    orientations = _orientation_attribute(prim) if is_instancer else None
    parts: list[tuple[np.ndarray, ...]] = []
    for code, matrix in zip(codes, matrices_of(prim, codes), strict=True):
        known = array_at(ids, float(code) + _JUST_AFTER, error=PlanError) if indices is None else indices
        numbers = np.array(known, dtype=np.int64)
        places = _values_at(points, float(code), len(numbers)).reshape(-1, 3)
        if len(places) != len(numbers):
            what = f"has {len(places)} {name} but {len(numbers)} ids at time code {code:g}"
            raise PlanError(prim.GetPath(), what, "author one id a point")
        if len(np.unique(numbers)) != len(numbers):
            raise PlanError(prim.GetPath(), f"has an id twice at time code {code:g}", "each point has its own")
        yaws = _instance_yaws(units, orientations, float(code), matrix, len(numbers))
        shown = _shown(prim, float(code), len(numbers))
        parts.append((numbers, np.full(len(numbers), code), places @ matrix[:3, :3] + matrix[3, :3], yaws, shown))
    numbers, stamps, places, headings, shown = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    order = np.lexsort((stamps, numbers))
    return _Cloud(
        ids=numbers[order],
        times=units.codes_to_times(stamps[order]),
        positions=units.points_to_canonical(places[order]),
        yaws=headings[order] if orientations is not None else None,
        shown=shown[order],
    )


def _indices(prim: Usd.Prim, positions: Usd.Attribute) -> range:
    """Which instances a PointInstancer without ids has: USD takes their indices for ids.

    Raises:
        PlanError: If there are more at some times than at others: indices then tell nobody apart.
    """
    codes = positions.GetTimeSamples() or (Usd.TimeCode.Default(),)
    counts = sorted({len(array_at(positions, code, error=PlanError)) for code in codes})
    if len(counts) > 1:
        what = f"has no ids, and {counts[-1]} positions at one time, {counts[0]} at another"
        raise PlanError(prim.GetPath(), what, "author ids, one a point, so that points can be told apart")
    return range(counts[0])


def _shown(prim: Usd.Prim, code: float, count: int) -> BoolArray:
    """Which points a PointInstancer shows at a time code: not those that are inactive or invisible; shape (N,)."""
    instancer = UsdGeom.PointInstancer(prim)
    mask = instancer.ComputeMaskAtTime(code + _JUST_AFTER) if instancer else ()
    return np.array(mask, dtype=bool) if len(mask) == count else np.ones(count, dtype=bool)


def _values_at(attribute: Usd.Attribute, code: float, count: int) -> FloatArray:
    """The array at a time code; if it has not `count` elements there, as the sample before may, that just after."""
    values = array_at(attribute, code, error=PlanError)
    if len(values) != count:
        values = array_at(attribute, code + _JUST_AFTER, error=PlanError)
    return np.array(values, dtype=float)


def _orientation_attribute(prim: Usd.Prim) -> Usd.Attribute | None:
    for name in ("orientationsf", "orientations"):
        attribute = prim.GetAttribute(name)
        if attribute and attribute.HasAuthoredValue():
            return attribute
    return None


def _instance_yaws(
    units: StageUnits, orientations: Usd.Attribute | None, code: float, matrix: FloatArray, count: int
) -> FloatArray:
    """Headings of instances at a time code [rad], 0 without orientations, shape (N,)."""
    if orientations is None:
        return np.zeros(count)
    values = _values_at(orientations, code, count)
    if len(values) != count:
        what = f"has {count} positions but {len(values)} orientations at time code {code:g}"
        raise PlanError(orientations.GetPrim().GetPath(), what, "author one orientation a point")
    forward = units.directions_to_stage(np.array([0.0, 0.0, 1.0]))
    turned = quaternion.rotate(values, np.broadcast_to(forward, (count, 3)))
    return np.asarray(planar.yaw_of(units.directions_to_canonical(turned @ matrix[:3, :3])[:, [0, 2]]))
