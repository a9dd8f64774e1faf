"""Options of following a trajectory, with their units and defaults."""

from __future__ import annotations

from dataclasses import dataclass

from usdfoot.errors import UsdfootError
from usdfoot.model.limits import WINDOWS, check_range

__all__ = ["FollowOptions"]


@dataclass(frozen=True, kw_only=True)
class FollowOptions:
    """How agents without footsteps walk their trajectories.

    Raises:
        UsdfootError: If a value is out of its range.
    """

    smoothing_time: float = 0.25
    """Standard deviation of the Gaussian window in which the trajectory is fitted by straight lines [s]; 0 = take it as
    it is."""
    still_distance: float = 0.03
    """A body that stands lets the trajectory be this far from it when it comes to rest [m]."""
    leave_distance: float = 0.08
    """A body that stands steps before the trajectory is farther from it than this [m]."""
    still_turn: float = 0.08
    """A body that stands lets its heading differ by this when it comes to rest [rad]."""
    leave_turn: float = 0.35
    """A body that stands steps before its heading differs by more than this [rad]."""
    outward_turn: float = 0.8
    """Most a foot may be turned out against the other [rad]."""
    inward_turn: float = 0.35
    """Most a foot may be turned in against the other [rad]."""
    hurry: float = 1.5
    """Largest factor by which steps are quickened, or drawn out, where the clips know no such speed."""
    overreach: float = 0.25
    """How far beyond the clips' landings a footstep may lie [m]."""
    foot_spacing: float = 0.08
    """Least distance across between feet that do not cross in the clips [m]."""
    lost_distance: float = 1.0
    """An agent this far from its trajectory has lost it and is skipped [m]."""

    def __post_init__(self) -> None:
        check_range("smoothing_time", self.smoothing_time, WINDOWS, unit="s")
        for name in ("leave_distance", "leave_turn", "outward_turn", "inward_turn", "lost_distance"):
            if not getattr(self, name) > 0.0:
                raise UsdfootError(name, f"is {getattr(self, name)}", "must be above 0")
        if not self.hurry >= 1.0:
            raise UsdfootError("hurry", f"is {self.hurry}", "must be 1 or more")
