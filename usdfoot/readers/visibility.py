"""Visibility: when agents are to be seen."""

from __future__ import annotations

from collections.abc import Iterable

from pxr import Sdf, Usd, UsdGeom

from usdfoot.bridge.scene import Visibility
from usdfoot.readers.agents import AgentSource
from usdfoot.readers.authored import is_authored

__all__ = ["read_visibilities"]

_NAME = str(UsdGeom.Tokens.visibility)


def read_visibilities(sources: Iterable[AgentSource]) -> dict[str, Visibility]:
    """When agents' prims, with all that is above them, are to be seen, of those that are not always, by agent name.

    Without UsdfootAgentAPI on the stage all are.
    """
    said: dict[Sdf.Path, bool] = {}
    speaking = [
        source
        for source in sources
        if source.is_authored
        and (_says_above(source.prim, said) or (_NAME in source.properties and is_authored(source.prim, _NAME)))
    ]
    found = {source.name: _visibility_of(source.prim) for source in speaking}
    return {name: visibility for name, visibility in found.items() if visibility}


def _says_above(prim: Usd.Prim, said: dict[Sdf.Path, bool]) -> bool:
    """Whether a prim above this one says when it is to be seen; `said` has it of those asked before."""
    parent = prim.GetParent()
    path = parent.GetPath()
    if path not in said:
        said[path] = bool(parent.GetParent()) and (_says_above(parent, said) or is_authored(parent, _NAME))
    return said[path]


def _visibility_of(prim: Usd.Prim) -> Visibility:
    """When a prim, with all that is above it, is to be seen."""
    prims = [prim.GetStage().GetPrimAtPath(path) for path in prim.GetPath().GetPrefixes()]
    imageables = [UsdGeom.Imageable(above) for above in prims if above.IsA(UsdGeom.Imageable)]
    if not imageables:
        return ()
    codes = sorted({code for seen in imageables for code in seen.GetVisibilityAttr().GetTimeSamples()})
    if codes:
        return tuple((code, str(imageables[-1].ComputeVisibility(code))) for code in codes)
    seen = str(imageables[-1].ComputeVisibility())
    return ((None, seen),) if seen == UsdGeom.Tokens.invisible else ()
