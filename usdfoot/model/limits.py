"""Limits: how much of a file is read before it is refused, so that no file can exhaust the machine."""

from __future__ import annotations

from dataclasses import dataclass

from usdfoot.errors import SceneError, UsdfootError

__all__ = ["DEFAULT_LIMITS", "FARTHEST", "LATEST", "Limits", "check_limit"]

FARTHEST = 1e9
"""Nobody walks farther from the origin [m]; squares of what lies much farther are beyond single precision."""
LATEST = 1e10
"""Nobody walks later than this after, or before, time 0 [s], which may be that of a computer's clock."""


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
