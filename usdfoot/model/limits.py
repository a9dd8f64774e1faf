"""Limits: how much of a file is read before it is refused, so that no file can exhaust the machine."""

from __future__ import annotations

from dataclasses import dataclass

from usdfoot.errors import SceneError, UsdfootError

__all__ = [
    "BODILY",
    "DEFAULT_LIMITS",
    "FARTHEST",
    "LATEST",
    "SPANS",
    "WINDOWS",
    "Limits",
    "check_limit",
    "check_range",
]

FARTHEST = 1e9
"""Nobody walks farther from the origin [m]; squares of what lies much farther are beyond single precision."""
LATEST = 1e10
"""Nobody walks later than this after, or before, time 0 [s], which may be that of a computer's clock."""

BODILY = (1e-3, 1e3)
"""Bodies and what they step on are no smaller and no larger than this [m], and no slower and no faster [m/s]."""
SPANS = (0.0, LATEST)
"""Nothing takes longer than this [s]."""
WINDOWS = (0.0, 3600.0)
"""What is smoothed is so over no more than this [s]."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Far above what shots need; whoever needs more says so.

    Raises:
        UsdfootError: If a limit is not above 0.
    """

    agents: int = 100_000
    """Agents of a scene."""
    joints: int = 2_000
    """Joints of a skeleton."""
    frames: int = 100_000
    """Frames of the crowd, and samples of a clip."""
    triangles: int = 50_000_000
    """Triangles of the terrain."""
    footsteps: int = 100_000
    """Footsteps of a plan."""
    prims: int = 5_000_000
    """Prims of a scene, those of instances counted as often as they are."""

    def __post_init__(self) -> None:
        for name in ("agents", "footsteps", "joints", "frames", "triangles", "prims"):
            if getattr(self, name) < 1:
                raise UsdfootError(name, f"limit is {getattr(self, name)}", "give 1 or more")


DEFAULT_LIMITS = Limits()


def check_limit(where: object, what: str, count: float, *, limit: int) -> None:
    """Raises SceneError if there is more of something than the limit allows.

    Args:
        where: Prim or file.
        what: agents | footsteps | joints | frames | triangles | prims.
        count: How many there are.
        limit: How many there may be.
    """
    if count > limit:
        raise SceneError(where, f"has {count:.0f} {what}, more than {limit}", f"raise the limit with --max-{what}")


def check_range(name: str, value: float, bounds: tuple[float, float], *, unit: str, or_zero: bool = False) -> None:
    """Raises UsdfootError if an option is outside of two bounds.

    Args:
        name: Of the option.
        value: That was given.
        bounds: Least and most that it may be.
        unit: Of all of them, for the message.
        or_zero: Whether 0, which stands for no value, is right too.
    """
    least, most = bounds
    if not (least <= value <= most or (or_zero and value == 0.0)):
        raise UsdfootError(name, f"is {value:g} {unit}", f"must be {least:g} to {most:g} {unit}")
