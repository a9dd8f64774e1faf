"""Bindings: materials that a scene binds to agents' own prims, and go along to the written agents."""

from __future__ import annotations

from collections.abc import Iterable

from pxr import Sdf, Usd, UsdShade

from usdfoot.bridge.own_attributes import BINDING, OwnBinding
from usdfoot.bridge.tokens import Prim

__all__ = ["BindingReader", "is_binding"]

_PURPOSES = (BINDING, f"{BINDING}:preview", f"{BINDING}:full")
_STRENGTH = "bindMaterialAs"


def is_binding(name: str) -> bool:
    """Whether a property binds a material to a prim and what is below it; collections of prims are not meant."""
    return name in _PURPOSES


class BindingReader:
    """Reads bindings, and looks at each material only once."""

    def __init__(self) -> None:
        self._sources: dict[Sdf.Path, tuple[str, str] | None] = {}

    def read(self, prim: Usd.Prim, names: Iterable[str], *, character: Usd.Prim) -> dict[str, OwnBinding]:
        """Those of the properties that bind materials which there are, by name.

        Args:
            prim: An agent's, or its character's.
            names: Of properties.
            character: The prim that holds the character.
        """
        bound = sorted(filter(is_binding, names))
        if not bound or not prim.HasAPI(UsdShade.MaterialBindingAPI):  # USD has none count without
            return {}
        found = {name: self._read(prim, name, character) for name in bound}
        return {name: binding for name, binding in found.items() if binding}

    def _read(self, prim: Usd.Prim, name: str, character: Usd.Prim) -> OwnBinding | None:
        relationship = prim.GetRelationship(name)
        targets = relationship.GetForwardedTargets()
        if len(targets) != 1:
            return None
        (path,) = targets
        strength = str(relationship.GetMetadata(_STRENGTH) or "")
        if path.HasPrefix(character.GetPath()):
            inside = str(path.MakeRelativePath(character.GetPath()))
            is_there = bool(UsdShade.Material(prim.GetStage().GetPrimAtPath(path)))
            return OwnBinding(material=inside, strength=strength) if is_there else None
        if path not in self._sources:
            self._sources[path] = _source_of(prim.GetStage().GetPrimAtPath(path))
        source = self._sources[path]
        return OwnBinding(material=f"{Prim.MATERIALS}{path}", source=source, strength=strength) if source else None


def _source_of(material: Usd.Prim) -> tuple[str, str] | None:
    """Layer and prim path to reference for a material: where it is said whole, else in the scene; None = it is none."""
    if not UsdShade.Material(material):
        return None
    stage = material.GetStage()
    layer, path = stage.GetRootLayer(), material.GetPath()
    session = stage.GetSessionLayer()
    own = [spec for spec in material.GetPrimStack() if spec.layer != session]
    parts = [spec for prim in Usd.PrimRange(material, Usd.TraverseInstanceProxies()) for spec in prim.GetPrimStack()]
    if (
        len(own) == 1
        and {spec.layer for spec in parts} == {own[0].layer}
        and not own[0].path.ContainsPrimVariantSelection()
    ):
        layer, path = own[0].layer, own[0].path
    return layer.realPath or layer.identifier, str(path)
