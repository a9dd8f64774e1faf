"""Hidden geometry: what is invisible or a guide, which viewers show on request at most."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pxr import Usd, UsdGeom

from usdfoot.readers.stage import start_code

__all__ = ["hidden_below", "is_hidden"]


def is_hidden(prim: Usd.Prim) -> bool:
    """Whether a prim, with all that is above it, is invisible at the stage's start, or a guide."""
    imageable = UsdGeom.Imageable(prim)
    return bool(imageable) and (
        imageable.ComputeVisibility(start_code(prim.GetStage())) == UsdGeom.Tokens.invisible
        or imageable.ComputePurpose() == UsdGeom.Tokens.guide
    )


def hidden_below(prims: Sequence[Usd.Prim], marked_of: Callable[[Usd.Prim], Usd.Prim | None]) -> list[Usd.Prim]:
    """The hidden ones of prims that are marked by a prim above that is not hidden itself.

    What is marked itself, or by a prim that is hidden with all below it, is meant although nobody sees it.

    Args:
        prims: Geometry.
        marked_of: The prim that marks another, itself or one above.
    """
    found = []
    for prim in prims:
        marked = marked_of(prim)
        if marked and marked != prim and is_hidden(prim) and not is_hidden(marked):
            found.append(prim)
    return found
