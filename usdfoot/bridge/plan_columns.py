"""Columns of plans as CSV: what `usdfoot import` reads and `usdfoot export` writes.

A row is a footstep. Lengths are in metres, +Y up, angles in degrees, times in seconds.
"""

from typing import Final

__all__ = ["PlanColumn"]


class PlanColumn:
    """Names in the header."""

    PLAN: Final = "plan"
    """Name of the plan; one for all rows if it is missing."""
    FOOT: Final = "foot"
    """left | right, or l | r."""
    POSITION: Final = ("x", "y", "z")
    """Point of the ground under the ball of the planted foot."""
    YAW: Final = "yaw"
    """Where the foot points, about the upward axis: 0 is +Z, 90 is +X (with +Z up: 0 is -Y, 90 is +X)."""
    NORMAL: Final = ("nx", "ny", "nz")
    """Normal of the ground; upward if they are missing."""
    STRIKE: Final = "strike"
    LIFTOFF: Final = "liftoff"
    STYLE: Final = "style"
    """Style of the step that ends here; none if it is missing or empty."""
    ROOT_WEIGHT: Final = "root_weight"
    """0 exact footstep .. 1 exact root velocity; 0 if it is missing or empty."""
    NEEDED: Final = (FOOT, *POSITION, YAW, STRIKE, LIFTOFF)
    ALL: Final = (PLAN, *NEEDED, *NORMAL, STYLE, ROOT_WEIGHT)
