"""Where a character comes from: the layer and prim to reference so that all its instances share one prototype."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from pxr import Kind, Sdf, Usd, UsdGeom, UsdSkel

__all__ = ["asset_of", "character_prim_of", "look_of"]

_HARMLESS_PROPERTIES = ("xformOp", "usdfoot:", "visibility", "extent", "skel:animationSource")
"""Properties on the character prim that a written agent replaces or does not need."""
_BROUGHT = ("usdfoot:", "visibility")
"""Those that an agent has from a prim of the scene that it references."""


def asset_of(prim: Usd.Prim) -> tuple[str, str]:
    """Layer identifier and prim path that give the same character when referenced.

    That is the asset itself where the scene only places it; the scene's own prim where the scene changes the asset.
    """
    return _followed(prim, _changes)


def look_of(prim: Usd.Prim) -> tuple[object, ...]:
    """What prims have in common that one of them can stand for, because they hold the same character.

    That is the asset, where the scene only places it and selects variants, with these and what else referencing the
    prim would bring along.
    """
    asset = _followed(prim, lambda spec: _changes(spec, selections=False))
    if asset == asset_of(prim):
        return asset
    sets = prim.GetVariantSets()
    brought = [
        (attribute.GetName(), str(attribute.Get()))
        for attribute in prim.GetAuthoredAttributes()
        if attribute.GetName().startswith(_BROUGHT)
    ]
    return (*asset, tuple(sorted(sets.GetAllVariantSelections().items())), tuple(brought))


def _followed(prim: Usd.Prim, changes: Callable[[Sdf.PrimSpec], bool]) -> tuple[str, str]:
    """Layer identifier and path of the asset below all that does not change it."""
    root = prim.GetStage().GetRootLayer()
    layer, path = root, prim.GetPath()
    arcs = _direct_arcs(prim)
    for i, arc in enumerate(arcs):
        starts = [(other.GetIntroducingLayer(), other.GetIntroducingPrimPath()) for other in arcs]
        follows = i == 0 or arc.GetIntroducingPrimPath() == path
        if not follows or starts.count(starts[i]) > 1 or _is_changed_above(prim, arc, changes):
            break
        layer, path = arc.GetTargetLayer(), arc.GetTargetPrimPath()
        if layer != arc.GetIntroducingLayer():
            break
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


def _is_changed_above(prim: Usd.Prim, arc: Usd.CompositionArc, changes: Callable[[Sdf.PrimSpec], bool]) -> bool:
    """Whether layers stronger than an arc's target say more than where the prim stands and what it does."""
    session = prim.GetStage().GetSessionLayer()
    targets = arc.GetTargetNode().layerStack.layers
    for spec in prim.GetPrimStack():
        if spec.layer in targets and spec.path == arc.GetTargetPrimPath():
            return False
        if spec.layer != session and changes(spec):
            return True
    return False


def _changes(spec: Sdf.PrimSpec, *, selections: bool = True) -> bool:
    """Whether a spec says more of a prim than a written agent does anew; `selections` of variants count."""
    own = [prop.name for prop in spec.properties if not prop.name.startswith(_HARMLESS_PROPERTIES)]
    # These views are truthy even when they are empty.
    parts = (own, spec.nameChildren, spec.variantSets, spec.variantSelections if selections else ())
    return any(len(part) > 0 for part in parts)
