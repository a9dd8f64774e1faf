"""Where a character comes from: the layer and prim to reference so that all its instances share one prototype."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import takewhile
from typing import NamedTuple

from pxr import Kind, Sdf, Usd, UsdGeom, UsdSkel

from usdfoot.bridge.scene import Variants
from usdfoot.readers.bindings import is_binding
from usdfoot.readers.own_attributes import HARMLESS, is_own

__all__ = ["Asset", "asset_of", "character_prim_of", "said_over"]


class Asset(NamedTuple):
    """What to reference, and as which of its variants."""

    layer: str
    """Identifier of the layer."""
    prim: str
    """Path there."""
    variants: Variants = ()


class _Followed(NamedTuple):
    """An asset, and what the scene says of it."""

    layer: Sdf.Layer
    path: Sdf.Path
    above: tuple[Sdf.PrimSpec, ...] = ()
    """Stronger specs of the prim, which do not change it."""


def asset_of(prim: Usd.Prim) -> Asset:
    """What gives the same character when referenced.

    That is the asset itself where the scene only places and describes it and selects variants; the scene's own prim
    where the scene changes the asset.
    """
    found = _followed(prim)
    selected: dict[str, str] = {}
    for spec in found.above:
        selected = {**dict(spec.variantSelections), **selected}
    layer = found.layer.realPath or found.layer.identifier
    return Asset(layer, str(found.path), tuple(sorted(selected.items())))


def said_over(prim: Usd.Prim) -> set[str]:
    """Properties that describe a prim, of what a scene says over the asset it holds.

    Where the scene's prim is the asset these are its bindings alone, whose materials may be outside of it.
    """
    names = prim.GetAuthoredPropertyNames()
    if all(name.startswith(HARMLESS) for name in names):  # as mostly
        return set()
    above = _followed(prim).above
    return {prop.name for spec in above for prop in spec.properties} if above else {*filter(is_binding, names)}


def _followed(prim: Usd.Prim) -> _Followed:
    """The asset below all that does not change it."""
    root = prim.GetStage().GetRootLayer()
    asset = _Followed(root, prim.GetPath())
    arcs = _direct_arcs(prim)
    starts = [(arc.GetIntroducingLayer(), arc.GetIntroducingPrimPath()) for arc in arcs]
    for i, arc in enumerate(arcs):
        follows = i == 0 or arc.GetIntroducingPrimPath() == asset.path
        above = _specs_above(prim, arc)
        if not follows or starts.count(starts[i]) > 1 or any(_changes(prim, spec) for spec in above):
            break
        asset = _Followed(arc.GetTargetLayer(), arc.GetTargetPrimPath(), above)
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


def _changes(prim: Usd.Prim, spec: Sdf.PrimSpec) -> bool:
    """Whether a spec says more of a prim than which variants it has, and what a written agent does anew."""
    parts = spec.nameChildren, spec.variantSets  # views that are truthy even when they are empty
    names = [prop.name for prop in spec.properties if not prop.name.startswith(HARMLESS)]
    return any(len(part) > 0 for part in parts) or not all(is_binding(name) or is_own(prim, name) for name in names)
