"""Footsteps recorded by SteerSuite: binary files of its footstep, data-driven and shadow agents.

A header (format, numbers of agents and obstacles, where their tables are), boxes, and for every agent a table of
footsteps: which foot is the pivot, where, and from when to when. The world is in metres with +Y up; angles phi are from
+X to +Z. The character's weight is on one foot at a time; people's contacts overlap, so each lasts a fifth of its time
longer, as in the footsteps SteerSuite writes for 3ds Max.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from usdfoot.errors import PlanError, UsdfootError
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.limits import DEFAULT_LIMITS, Limits, check_limit
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem

__all__ = ["import_foot_recording"]

HEADER = np.dtype([("format", "<u4"), ("agents", "<u4"), ("obstacles", "<u4"), ("table", "<u4"), ("boxes", "<u4")])
TABLE = np.dtype([("count", "<u4"), ("offset", "<u4")])
STEP: Mapping[str, tuple[str, int]] = {
    "start": ("<f4", 0), "end": ("<f4", 4), "parabola_phi": ("<f4", 16), "inner_phi": ("<f4", 20),
    "outer_phi": ("<f4", 24), "foot": ("u1", 28), "x": ("<f4", 76), "z": ("<f4", 80),
}  # fmt: skip
"""Type and offset of what is read of a footstep, the same in all formats."""
SIZES = {3: 140, 4: 144, 5: 176}
"""Bytes of a footstep by format: of footstep, data-driven and shadow agents."""
OVERLAP = 0.2
"""Part of a footstep's time that it lasts into the next."""
SAME_PLACE = 0.01
"""Footsteps of one foot that follow each other within this are one [m]."""


def import_foot_recording(
    file: str | os.PathLike[str], *, limits: Limits = DEFAULT_LIMITS
) -> tuple[dict[str, FootstepPlan], tuple[Problem, ...]]:
    """Plans of all agents of a recording by name, in the canonical world, and agents that were left out.

    Raises:
        PlanError: If the file is no such recording, cut off, or no agent has a plan.
        SceneError: If it has more agents or footsteps than the limits allow.
    """
    path = Path(file)
    try:
        data = path.read_bytes()
    except OSError as error:
        raise PlanError(path, f"cannot be read ({error.strerror})", "name a recording of SteerSuite") from error
    header = _records(path, data, HEADER, 0, 1)[0]
    size = SIZES.get(int(header["format"]))
    if size is None:
        what = f"has format {header['format']}"
        raise PlanError(path, what, "recordings of footsteps have 3, 4 or 5; one of positions (.rec) has no footsteps")
    check_limit(path, "agents", int(header["agents"]), limit=limits.agents)
    kind = np.dtype(
        {
            "names": list(STEP),
            "formats": [each for each, _ in STEP.values()],
            "offsets": [offset for _, offset in STEP.values()],
            "itemsize": size,
        }
    )
    plans, problems = {}, []
    for index, row in enumerate(_records(path, data, TABLE, int(header["table"]), int(header["agents"]))):
        check_limit(path, "footsteps", int(row["count"]), limit=limits.footsteps)
        steps = _records(path, data, kind, int(row["offset"]), int(row["count"]))
        try:
            plans[f"agent_{index}"] = _plan(f"{path} (agent {index})", steps)
        except UsdfootError as error:
            problems.append(Problem(severity="error", where=error.where, message=str(error)))
    if not plans:
        raise PlanError(path, "no agent has a plan", names=[problem.message for problem in problems])
    return plans, tuple(problems)


def _records(path: Path, data: bytes, kind: np.dtype, offset: int, count: int) -> np.ndarray:
    """So many records from an offset on."""
    if offset + count * kind.itemsize > len(data):
        what = f"ends at byte {len(data)}, {count} records from byte {offset} on need {offset + count * kind.itemsize}"
        raise PlanError(path, what, "the file is cut off or no recording of footsteps")
    return np.frombuffer(data, kind, count, offset)


def _plan(name: str, steps: np.ndarray) -> FootstepPlan:
    if not len(steps):
        raise PlanError(name, "has no footsteps", "it never moved")
    numbers = np.stack([steps[field].astype(float) for field in STEP if field != "foot"])
    if not np.isfinite(numbers).all() or steps["foot"].max() > 1:
        raise PlanError(name, "has footsteps that are no numbers", "the recording is damaged")
    first, last = _contacts(steps)
    starts, ends = steps["start"][first].astype(float), steps["end"][last].astype(float)
    liftoffs = ends + OVERLAP * (ends - starts)
    liftoffs[:-2] = np.minimum(liftoffs[:-2], 0.5 * (ends[:-2] + starts[2:]))
    places = np.stack([steps["x"][first], np.zeros(len(first)), steps["z"][first]], axis=1).astype(float)
    return FootstepPlan(
        name=name,
        sides=steps["foot"][first].astype(int),
        positions=places,
        orientations=quaternion.yaw_quaternion(0.5 * np.pi - _angles(steps[first])),
        strike_times=starts,
        liftoff_times=liftoffs,
        root_weights=np.zeros(len(first)),
    )


def _contacts(steps: np.ndarray) -> tuple[IntArray, IntArray]:
    """First and last record of each contact: somebody who stops goes on with the same foot where it is."""
    places = np.stack([steps["x"], steps["z"]], axis=1)
    same = (np.diff(steps["foot"].astype(int)) == 0) & (np.linalg.norm(np.diff(places, axis=0), axis=1) < SAME_PLACE)
    edges = np.flatnonzero(~same)
    return np.concatenate([[0], edges + 1]), np.concatenate([edges, [len(steps) - 1]])


def _angles(steps: np.ndarray) -> FloatArray:
    """Where the feet point [rad]: along the recorded parabola, as far as the foot may turn there."""
    inner = steps["inner_phi"].astype(float)
    half = 0.5 * planar.wrap_angle(steps["outer_phi"] - inner)
    middle = inner + half
    return middle + np.clip(planar.wrap_angle(steps["parabola_phi"] - middle), -np.abs(half), np.abs(half))
