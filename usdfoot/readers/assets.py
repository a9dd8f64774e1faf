"""Where a character comes from: the layer and prim to reference so that all its instances share one prototype."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import takewhile
from typing import NamedTuple

from pxr import Kind, Sdf, Usd, UsdGeom, UsdSkel

from usdfoot.bridge.own_attributes import OwnAttributes
from usdfoot.readers.own_attributes import HARMLESS, is_own, read_own

__all__ = ["asset_of", "character_prim_of", "look_of", "own_attributes_over"]

_BROUGHT = ("usdfoot:", "visibility")
"""Properties that an agent has from a prim of the scene that it references."""


class _Asset(NamedTuple):
    """An asset, and what the scene says of it."""

    layer: Sdf.Layer
    path: Sdf.Path
    above: tuple[Sdf.PrimSpec, ...] = ()
    """Stronger specs of the prim, which do not change it."""

    @property
    def place(self) -> tuple[str, str]:
        """Layer identifier and prim path."""
        return self.layer.realPath or self.layer.identifier, str(self.path)


def asset_of(prim: Usd.Prim) -> tuple[str, str]:
    """Layer identifier and prim path that give the same character when referenced.

    That is the asset itself where the scene only places and describes it; the scene's own prim where the scene changes
    the asset.
    """
    return _followed(prim).place


def look_of(prim: Usd.Prim) -> tuple[object, ...]:
    """What prims have in common that one of them can stand for, because they hold the same character.

    That is the asset, where the scene only places it and selects variants, with these and what else referencing the
    prim would bring along: of attributes of its own that there are such, as every agent has its own values over them.
    """
    asset = _followed(prim, selections=False)
    if asset.place == asset_of(prim):
        return asset.place
    sets = prim.GetVariantSets()
    brought = [
        (attribute.GetName(), str(attribute.Get()))
        for attribute in prim.GetAuthoredAttributes()
        if attribute.GetName().startswith(_BROUGHT)
    ]
    own = [
        (name, value.type_name, value.interpolation, value.element_size, _connections(prim, name))
        for name, value in _own_over(prim, asset).items()
    ]
    return (*asset.place, tuple(sorted(sets.GetAllVariantSelections().items())), tuple(brought), tuple(own))


def own_attributes_over(prim: Usd.Prim) -> OwnAttributes:
    """Attributes that describe a prim, by name, of what a scene says over the asset it holds."""
    if all(name.startswith(HARMLESS) for name in prim.GetAuthoredPropertyNames()):  # as mostly
        return {}
    return _own_over(prim, _followed(prim, selections=False))


def _own_over(prim: Usd.Prim, asset: _Asset) -> OwnAttributes:
    names = {attribute.name for spec in asset.above for attribute in spec.attributes}
    return read_own(prim, names) if names else {}


def _connections(prim: Usd.Prim, name: str) -> tuple[str, ...]:
    return tuple(map(str, prim.GetAttribute(name).GetConnections()))


def _followed(prim: Usd.Prim, *, selections: bool = True) -> _Asset:
    """The asset below all that does not change it; `selections` of variants do, or do not."""
    root = prim.GetStage().GetRootLayer()
    asset = _Asset(root, prim.GetPath())
    arcs = _direct_arcs(prim)
    starts = [(arc.GetIntroducingLayer(), arc.GetIntroducingPrimPath()) for arc in arcs]
    for i, arc in enumerate(arcs):
        follows = i == 0 or arc.GetIntroducingPrimPath() == asset.path
        above = _specs_above(prim, arc)
        if not follows or starts.count(starts[i]) > 1 or any(_changes(prim, spec, selections) for spec in above):
            break
        asset = _Asset(arc.GetTargetLayer(), arc.GetTargetPrimPath(), above)
        if asset.layer != arc.GetIntroducingLayer():
            break
    return asset


def character_prim_of(skeleton: Usd.Prim, foreign: Iterable[Usd.Prim] = ()) -> Usd.Prim:
    """The prim to reference for a Skeleton that no agent prim holds.

    The nearest prim above with a reference or payload, or of kind component; else the SkelRoot; else, as exporters
    without SkelRoot leave it, the prim above the Skeleton. Some exporters make the root of everything the SkelRoot: a
    prim that also holds what is no part of the character is passed over for the highest below it that does not.

    Args:
        skeleton: Skeleton of the character.
        foreign: Prims that are no part of a character: plans and terrain.
    """
    others = [prim.GetPath() for prim in foreign]
    ancestors = [skeleton]
    while not (parent := ancestors[-1].GetParent()).IsPseudoRoot():
        if any(path.HasPrefix(parent.GetPath()) for path in others):
            break
        ancestors.append(parent)
    for prim in ancestors:
        is_component = Kind.Registry.IsA(Usd.ModelAPI(prim).GetKind(), Kind.Tokens.component)
        if _has_local_arc(prim) or is_component:
            return prim
    referenced = [prim for prim in ancestors if _direct_arcs(prim)]
    if referenced:
        return referenced[-1]
    roots = [prim for prim in ancestors if prim.IsA(UsdSkel.Root)]
    if roots:
        return roots[0]
    if UsdSkel.Root.Find(skeleton):
        return ancestors[-1]
    return ancestors[1] if len(ancestors) > 1 and UsdGeom.Xformable(ancestors[1]) else skeleton


def _direct_arcs(prim: Usd.Prim) -> list[Usd.CompositionArc]:
    """References and payloads on the prim itself, strongest first, those of referenced scenes too."""
    query = Usd.PrimCompositionQuery(prim)
    kinds = query.filter
    kinds.arcTypeFilter = Usd.PrimCompositionQuery.ArcTypeFilter.ReferenceOrPayload
    kinds.dependencyTypeFilter = Usd.PrimCompositionQuery.DependencyTypeFilter.Direct
    query.filter = kinds
    return list(query.GetCompositionArcs())


def _has_local_arc(prim: Usd.Prim) -> bool:
    """Whether the scene itself, not something it references, authors a reference or payload on the prim."""
    layers = prim.GetStage().GetLayerStack(includeSessionLayers=False)
    return any(
        arc.GetIntroducingLayer() in layers and arc.GetIntroducingPrimPath() == prim.GetPath()
        for arc in _direct_arcs(prim)
    )


def _specs_above(prim: Usd.Prim, arc: Usd.CompositionArc) -> tuple[Sdf.PrimSpec, ...]:
    """Specs of a prim in layers stronger than an arc's target, without those of the session."""
    session = prim.GetStage().GetSessionLayer()
    layers, path = arc.GetTargetNode().layerStack.layers, arc.GetTargetPrimPath()
    stronger = takewhile(lambda spec: spec.layer not in layers or spec.path != path, prim.GetPrimStack())
    return tuple(spec for spec in stronger if spec.layer != session)


def _changes(prim: Usd.Prim, spec: Sdf.PrimSpec, selections: bool) -> bool:
    """Whether a spec says more of a prim than a written agent does anew; `selections` of variants count."""
    # These views are truthy even when they are empty.
    parts = spec.nameChildren, spec.variantSets, spec.variantSelections if selections else ()
    names = [prop.name for prop in spec.properties if not prop.name.startswith(HARMLESS)]
    return any(len(part) > 0 for part in parts) or not all(is_own(prim, name) for name in names)
