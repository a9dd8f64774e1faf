"""FootstepPlan: which foot stands where, when."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import SIDES
from usdfoot.model.limits import FARTHEST

__all__ = ["FootstepPlan", "PlanDraft"]


@dataclass(frozen=True, kw_only=True)
class FootstepPlan:
    """Footsteps in order of strike, in the canonical world.

    Raises:
        PlanError: If arrays differ in length, hold values that are not finite, are out of order, a contact has no
            duration, contacts of one foot overlap, or one foot steps twice in a row.
    """

    name: str
    """Prim path of the plan, for messages."""
    sides: IntArray
    """0 = left, 1 = right, shape (N,)."""
    positions: FloatArray
    """Point of the ground under the ball of the planted foot [m], shape (N, 3)."""
    orientations: FloatArray
    """Turns +Z into the foot's forward and +Y into the ground's normal, unit xyzw, shape (N, 4)."""
    strike_times: FloatArray
    """First contact [s], shape (N,), not decreasing."""
    liftoff_times: FloatArray
    """Ball leaves the ground [s], shape (N,)."""
    root_weights: FloatArray
    """[B]'s lambda4 of each step, 0 exact footsteps .. 1 exact root velocity, shape (N,)."""
    styles: tuple[str, ...] = ()
    """Style of each step, N of them, "" = the library's own; none at all if no step names one."""

    def __post_init__(self) -> None:
        count = len(self.sides)
        lengths = {
            "protoIndices": count,
            "positions": len(self.positions),
            "orientations": len(self.orientations),
            "strikeTimes": len(self.strike_times),
            "liftoffTimes": len(self.liftoff_times),
            "rootWeights": len(self.root_weights),
            **({"styles": len(self.styles)} if self.styles else {}),
        }
        if len(set(lengths.values())) != 1:
            listing = ", ".join(f"{key} {value}" for key, value in lengths.items())
            raise PlanError(self.name, f"arrays differ in length ({listing})", "author one entry a footstep in each")
        if count < 2:
            raise PlanError(self.name, f"has {count} footstep(s)", "a plan needs at least two")
        self._check_values()
        self._check_times()

    def _check_values(self) -> None:
        stray = ((self.sides < 0) | (self.sides > 1)).nonzero()[0]
        if stray.size:
            side = self.sides[stray[0]]
            raise PlanError(self.name, f"footstep {stray[0]} has protoIndex {side}", "0 = left, 1 = right")
        arrays = {
            "positions": self.positions,
            "orientations": self.orientations,
            "strikeTimes": self.strike_times,
            "liftoffTimes": self.liftoff_times,
            "rootWeights": self.root_weights,
        }
        if not np.isfinite(np.concatenate([values.ravel() for values in arrays.values()])).all():
            self._name_infinite(arrays)
        far = np.flatnonzero((np.abs(self.positions) > FARTHEST).any(axis=1))
        if far.size:
            what = f"footstep {far[0]} is {np.abs(self.positions[far[0]]).max():.3g} m from the origin"
            raise PlanError(self.name, what, f"author positions within {FARTHEST:g} m, or correct metersPerUnit")
        beyond = ((self.root_weights < 0.0) | (self.root_weights > 1.0)).nonzero()[0]
        if beyond.size:
            weight = self.root_weights[beyond[0]]
            raise PlanError(self.name, f"rootWeights of footstep {beyond[0]} is {weight:.4g}", "0 to 1 is possible")
        lengths = np.sqrt(np.einsum("ij,ij->i", self.orientations, self.orientations))
        if (np.abs(lengths - 1.0) > 1e-3).any():
            raise PlanError(self.name, "orientations are not unit quaternions", "normalise them")

    def _name_infinite(self, arrays: dict[str, FloatArray]) -> None:
        """Raises PlanError for the first value that is not finite."""
        for label, values in arrays.items():
            bad = np.flatnonzero(~np.isfinite(values.reshape(len(values), -1)).all(axis=1))
            if bad.size:
                raise PlanError(self.name, f"{label} of footstep {bad[0]} is not a finite number", "author numbers")

    def _check_times(self) -> None:
        strikes = self.strike_times
        empty = (self.liftoff_times <= strikes).nonzero()[0]
        if empty.size:
            i = empty[0]
            raise PlanError(
                self.name,
                f"footstep {i} lifts off at {self.liftoff_times[i]:.4g} s, not after its strike at {strikes[i]:.4g} s",
                "liftoffTimes must come after strikeTimes",
            )
        late = (strikes[1:] < strikes[:-1]).nonzero()[0]
        if late.size:
            i = late[0]
            raise PlanError(self.name, f"footstep {i + 1} strikes before footstep {i}", "order by strike time")
        same = (self.sides[1:] == self.sides[:-1]).nonzero()[0]
        if same.size:
            side = SIDES[int(self.sides[same[0]])]
            raise PlanError(
                self.name, f"footsteps {same[0]} and {same[0] + 1} are both {side}", "left and right must alternate"
            )
        overlap = (strikes[2:] <= self.liftoff_times[:-2]).nonzero()[0]
        if overlap.size:
            i = overlap[0]
            raise PlanError(
                self.name,
                f"footstep {i + 2} strikes at {strikes[i + 2]:.4g} s before the same foot has left "
                f"footstep {i} at {self.liftoff_times[i]:.4g} s",
                "contacts of one foot must not overlap",
            )
        together = (strikes[2:] <= strikes[1:-1]).nonzero()[0]
        if together.size:
            i = together[0] + 1
            raise PlanError(self.name, f"footsteps {i} and {i + 1} strike together", "only the first two may")

    def __len__(self) -> int:
        return len(self.sides)

    @property
    def yaws(self) -> FloatArray:
        """Direction of each foot as yaw [rad], shape (N,)."""
        forward = quaternion.rotate(self.orientations, np.array([0.0, 0.0, 1.0]))
        return planar.yaw_of(forward[:, [0, 2]])

    @property
    def normals(self) -> FloatArray:
        """Ground normals the prints were laid on, shape (N, 3)."""
        return quaternion.rotate(self.orientations, np.array([0.0, 1.0, 0.0]))

    def later(self, delay: float) -> FootstepPlan:
        """The plan, all times this much later [s]."""
        return replace(self, strike_times=self.strike_times + delay, liftoff_times=self.liftoff_times + delay)

    @property
    def start(self) -> float:
        """First strike [s]."""
        return float(self.strike_times[0])

    @property
    def end(self) -> float:
        """Last liftoff [s]."""
        return float(self.liftoff_times.max())

    @property
    def starts_standing(self) -> bool:
        """Whether the first two footsteps strike together."""
        return bool(self.strike_times[0] == self.strike_times[1])

    @property
    def ends_standing(self) -> bool:
        """Whether the last two footsteps lift off together."""
        return bool(self.liftoff_times[-1] == self.liftoff_times[-2])


@dataclass(frozen=True, kw_only=True)
class PlanDraft:
    """What becomes a `FootstepPlan` if it is in order; fields as there."""

    name: str
    sides: IntArray
    positions: FloatArray
    orientations: FloatArray
    strike_times: FloatArray
    liftoff_times: FloatArray
    root_weights: FloatArray
    styles: tuple[str, ...] = ()

    def checked(self) -> FootstepPlan:
        """The plan.

        Raises:
            PlanError: If it is inconsistent.
        """
        return FootstepPlan(**vars(self))
