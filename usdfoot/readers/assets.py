"""Where a character comes from: the layer and prim to reference so that all its instances share one prototype."""

from __future__ import annotations

from collections.abc import Iterable

from pxr import Kind, Sdf, Usd, UsdGeom, UsdSkel

__all__ = ["asset_of", "character_prim_of"]

_HARMLESS_PROPERTIES = ("xformOp", "usdfoot:", "visibility", "extent", "skel:animationSource")
"""Properties on the character prim that a written agent replaces or does not need."""


def asset_of(prim: Usd.Prim) -> tuple[str, str]:
    """Layer identifier and prim path that give the same character when referenced.

    That is the asset itself where the scene only places it; the scene's own prim where the scene changes the asset.
    """
    stage = prim.GetStage()
    arc = None if _is_changed(prim) else _single_arc(prim)
    if arc is None:
        root = stage.GetRootLayer()
        return root.realPath or root.identifier, str(prim.GetPath())
    layer, path = arc.GetTargetLayer(), arc.GetTargetPrimPath()
    if layer in stage.GetLayerStack(includeSessionLayers=False):
        inner = stage.GetPrimAtPath(path)
        if inner:
            return asset_of(inner)
    return layer.realPath or layer.identifier, str(path)


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
        if _local_arcs(prim) or is_component:
            return prim
    roots = [prim for prim in ancestors if prim.IsA(UsdSkel.Root)]
    if roots:
        return roots[0]
    if UsdSkel.Root.Find(skeleton):
        return ancestors[-1]
    return ancestors[1] if len(ancestors) > 1 and UsdGeom.Xformable(ancestors[1]) else skeleton


def _local_arcs(prim: Usd.Prim) -> list[Usd.CompositionArc]:
    """References and payloads the scene itself authors on the prim."""
    if prim.IsInstanceProxy():
        return []
    query = Usd.PrimCompositionQuery(prim)
    kinds = query.Filter()
    kinds.arcTypeFilter = Usd.PrimCompositionQuery.ArcTypeFilter.ReferenceOrPayload
    kinds.dependencyTypeFilter = Usd.PrimCompositionQuery.DependencyTypeFilter.Direct
    query.filter = kinds
    layers = prim.GetStage().GetLayerStack(includeSessionLayers=False)
    return [
        arc
        for arc in query.GetCompositionArcs()
        if arc.GetIntroducingLayer() in layers and arc.GetIntroducingPrimPath() == prim.GetPath()
    ]


def _single_arc(prim: Usd.Prim) -> Usd.CompositionArc | None:
    arcs = _local_arcs(prim)
    return arcs[0] if len(arcs) == 1 else None


def _is_changed(prim: Usd.Prim) -> bool:
    """Whether the scene's own layers say more about the prim than where it stands and what it does."""
    layers = prim.GetStage().GetLayerStack(includeSessionLayers=False)
    return any(_changes(spec) for spec in prim.GetPrimStack() if spec.layer in layers and spec.path == prim.GetPath())


def _changes(spec: Sdf.PrimSpec) -> bool:
    own = [prop.name for prop in spec.properties if not prop.name.startswith(_HARMLESS_PROPERTIES)]
    # These views are truthy even when they are empty.
    return any(len(part) > 0 for part in (own, spec.nameChildren, spec.variantSelections, spec.variantSets))
