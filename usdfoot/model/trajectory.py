"""RootTrajectory: where a root shall be when, and which way it shall face."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.limits import FARTHEST
from usdfoot.model.plan import FootstepPlan

__all__ = ["FASTEST", "RootTrajectory", "find_breaks", "root_distances", "sample_trajectories", "sample_trajectory"]

FASTEST = 40.0
"""Nobody on foot is faster; what is has been put elsewhere [m/s]."""
LONGEST_GAP = 10.0
"""Someone not seen for longer than this is another one when seen again [s]."""


@dataclass(frozen=True, kw_only=True)
class RootTrajectory:
    """Samples of a root in the canonical world, straight between them ([B] 4.2).

    Raises:
        PlanError: If there are fewer than two samples, arrays differ in length, hold values that are not finite, times
            do not increase, or it jumps: is faster than FASTEST.
    """

    name: str
    """Prim path, for messages."""
    times: FloatArray
    """[s], increasing, shape (K,)."""
    positions: FloatArray
    """On the ground [m], shape (K, 3)."""
    yaws: FloatArray | None = None
    """Headings [rad], continuous, shape (K,); None = it faces where it goes."""
    rest_yaw: float = 0.0
    """Heading of one that has none and goes nowhere [rad]."""

    def __post_init__(self) -> None:
        lengths = {"times": len(self.times), "positions": len(self.positions)}
        if self.yaws is not None:
            lengths["headings"] = len(self.yaws)
        if len(set(lengths.values())) != 1:
            listing = ", ".join(f"{key} {value}" for key, value in lengths.items())
            raise PlanError(self.name, f"arrays differ in length ({listing})", "give one entry a sample in each")
        if len(self.times) < 2:
            raise PlanError(self.name, f"has {len(self.times)} sample(s)", "a trajectory needs at least two")
        for label, values in (("time", self.times), ("position", self.positions), ("heading", self.yaws)):
            if values is None:
                continue
            bad = np.flatnonzero(~np.isfinite(values.reshape(len(values), -1)).all(axis=1))
            if bad.size:
                raise PlanError(self.name, f"{label} of sample {bad[0]} is not a finite number", "author numbers")
        far = np.flatnonzero((np.abs(self.positions) > FARTHEST).any(axis=1))
        if far.size:
            what = f"sample {far[0]} is {np.abs(self.positions[far[0]]).max():.3g} m from the origin"
            raise PlanError(self.name, what, f"author positions within {FARTHEST:g} m, or correct metersPerUnit")
        if np.any(np.diff(self.times) <= 0.0):
            raise PlanError(self.name, "times do not increase", "order the samples by time")
        steps = np.linalg.norm(np.diff(self.positions, axis=0), axis=1)
        far = np.flatnonzero(steps > FASTEST * np.diff(self.times))
        if far.size:
            first, last = self.times[far[0]], self.times[far[0] + 1]
            what = f"jumps by {steps[far[0]]:.3g} m from {first:.4g} to {last:.4g} s"
            raise PlanError(self.name, what, "cut it there, or correct the unit or the rate")

    @property
    def start(self) -> float:
        """First time [s]."""
        return float(self.times[0])

    @property
    def end(self) -> float:
        """Last time [s]."""
        return float(self.times[-1])


def find_breaks(times: FloatArray, places: FloatArray) -> tuple[BoolArray, BoolArray]:
    """Between which samples someone jumps, and between which nothing is seen for too long, each of shape (K - 1,).

    Args:
        times: [s], shape (K,).
        places: [m], shape (K, D).
    """
    spans = np.abs(np.diff(times))
    return np.linalg.norm(np.diff(places, axis=0), axis=1) > FASTEST * spans, spans > LONGEST_GAP


def sample_trajectory(trajectory: RootTrajectory, times: FloatArray) -> FloatArray:
    """Positions at times (T,) [s], straight between samples and held outside them, shape (T, 3)."""
    return np.stack([np.interp(times, trajectory.times, column) for column in trajectory.positions.T], axis=1)


def sample_trajectories(
    trajectories: Sequence[RootTrajectory], numbers: IntArray, times: FloatArray, *, values: FloatArray
) -> FloatArray:
    """Values at times of many trajectories, straight between samples and held outside them, for all at once.

    Args:
        trajectories: A of them.
        numbers: Which trajectory is asked, shape (...).
        times: [s], shape (...).
        values: One a sample, those of all trajectories one after the other, shape (sum of K, C).

    Returns:
        Shape (..., C).
    """
    own = np.concatenate([trajectory.times for trajectory in trajectories])
    counts = np.array([len(trajectory.times) for trajectory in trajectories])
    first = np.cumsum(counts) - counts
    low, high = first[numbers], (first + counts - 2)[numbers]
    begin, span = float(own.min()), float(np.ptp(own)) + 1.0  # those of each trajectory after those of the one before
    line = own - begin + span * np.repeat(np.arange(len(counts)), counts)
    asked = np.clip(times - begin, 0.0, span) + span * numbers
    found = np.clip(np.searchsorted(line, asked, side="right") - 1, low, high)
    found = np.where((found > low) & (own[found] > times), found - 1, found)  # what sums round must not depend
    low = np.where((found < high) & (own[found + 1] <= times), found + 1, found)  # on how many trajectories there are
    share = np.clip((times - own[low]) / (own[low + 1] - own[low]), 0.0, 1.0)
    return np.asarray(values[low] + share[..., None] * (values[low + 1] - values[low]))


def root_distances(trajectory: RootTrajectory, plan: FootstepPlan) -> FloatArray:
    """From the middle of each two consecutive footsteps to the trajectory at the later strike [m], shape (N - 1,)."""
    middles = 0.5 * (plan.positions[1:] + plan.positions[:-1])
    missed = middles - sample_trajectory(trajectory, plan.strike_times[1:])
    return np.asarray(np.linalg.norm(missed[:, [0, 2]], axis=1))
