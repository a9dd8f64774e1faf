"""Which SkelAnimations an agent may use, and the skeleton each was made on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from pxr import Sdf, Usd, UsdSkel

from usdfoot.bridge.tokens import Clip as Token
from usdfoot.errors import SkeletonError
from usdfoot.readers.authored import targets
from usdfoot.readers.clips import ClipSource
from usdfoot.readers.joints import match_joints
from usdfoot.readers.skeleton import RawSkeleton, read_joints, read_skeleton
from usdfoot.readers.skins import inherited_target
from usdfoot.readers.stage import StagePrims

__all__ = ["ClipFinder"]


class ClipFinder:
    """Looks up the skeletons of a stage's animations; every Skeleton is read once.

    Args:
        stage: Stage the prims belong to.
        prims: Its prims by kind.
    """

    def __init__(self, stage: Usd.Stage, prims: StagePrims) -> None:
        self._stage = stage
        self._animations = _distinct(prims.animations)
        self._skeletons = _readable(_distinct(prims.skeletons))
        self._bound: dict[Sdf.Path, Usd.Prim] = {}
        for prim in prims.skeletons:
            source = inherited_target(prim, "skel:animationSource")
            if source is not None:
                self._bound.setdefault(source, prim)

    def animations_below(self, scopes: Sequence[Sdf.Path]) -> list[Usd.Prim]:
        """Animations at or below the scopes in stage order, or in collections; without any, all of the stage's."""
        if not scopes:
            return list(self._animations)
        prims = (prim for scope in scopes for prim in self._prims_of(scope))
        return list({prim.GetPath(): prim for prim in prims if prim.IsA(UsdSkel.Animation)}.values())

    def _prims_of(self, scope: Sdf.Path) -> Iterable[Usd.Prim]:
        """Prims at or below a path, or in the collection there."""
        everything = Usd.TraverseInstanceProxies()
        if scope.IsPropertyPath():
            query = Usd.CollectionAPI.GetCollection(self._stage, scope).ComputeMembershipQuery()
            return Usd.CollectionAPI.ComputeIncludedObjects(query, self._stage, everything)
        prim = self._stage.GetPrimAtPath(scope)
        return Usd.PrimRange(prim, everything) if prim else ()

    def source_of(self, animation: Usd.Prim, character: Usd.Prim) -> ClipSource:
        """The animation with the skeleton it was made on.

        That is the target of usdfoot:clip:skeleton, else a Skeleton above it, else one that is bound to it, else the
        nearest with all its joints, else the character's.

        Args:
            animation: SkelAnimation.
            character: Skeleton of the character that is to use it.

        Raises:
            SkeletonError: If usdfoot:clip:skeleton names no usable Skeleton.
        """
        player = self._named(animation) or self._above(animation) or self._bound.get(animation.GetPath())
        prim = player or self._nearest(animation, character) or character
        raw = self._skeletons.get(prim.GetPath()) or read_skeleton(prim)
        return ClipSource(prim=animation, skeleton_prim=prim, skeleton=raw, is_bound=player is not None)

    def _named(self, animation: Usd.Prim) -> Usd.Prim | None:
        named = targets(animation, Token.SKELETON)
        prim = self._stage.GetPrimAtPath(named[0]) if named else None
        if named and not (prim and prim.IsA(UsdSkel.Skeleton)):
            raise SkeletonError(
                animation.GetPath(), f"{Token.SKELETON} points at {named[0]}, which is no Skeleton", "point it at one"
            )
        return prim

    def _above(self, animation: Usd.Prim) -> Usd.Prim | None:
        prim = animation.GetParent()
        while prim and not prim.IsPseudoRoot():
            if prim.IsA(UsdSkel.Skeleton):
                return prim
            prim = prim.GetParent()
        return None

    def _nearest(self, animation: Usd.Prim, character: Usd.Prim) -> Usd.Prim | None:
        """The Skeleton with all joints of the animation that shares the longest path with it."""
        joints = read_joints(animation)
        fitting = [path for path, raw in self._skeletons.items() if (match_joints(raw.joints, joints) >= 0).all()]
        if not fitting:
            return None

        def shared(path: Sdf.Path) -> tuple[int, bool]:
            common = animation.GetPath().GetCommonPrefix(path).pathElementCount
            return common, path == character.GetPath()

        best = max(fitting, key=shared)
        return self._stage.GetPrimAtPath(best)


def _readable(prims: Iterable[Usd.Prim]) -> Mapping[Sdf.Path, RawSkeleton]:
    """Skeletons that can be read; the others are named when somebody asks for them."""
    skeletons = {}
    for prim in prims:
        try:
            skeletons[prim.GetPath()] = read_skeleton(prim)
        except SkeletonError:
            continue
    return skeletons


def _distinct(prims: Iterable[Usd.Prim]) -> list[Usd.Prim]:
    """Prims without those that the same layers and paths give a second time, as instances and references do."""
    found: dict[object, Usd.Prim] = {}
    for prim in prims:
        specs = tuple((spec.layer.identifier, str(spec.path)) for spec in prim.GetPrimStack())
        found.setdefault((specs, _offset(prim)), prim)
    return list(found.values())


def _offset(prim: Usd.Prim) -> tuple[float, ...]:
    """First and last sample of a prim's animation on the stage, which layer offsets change."""
    animation = UsdSkel.Animation(prim)
    samples = animation.GetRotationsAttr().GetTimeSamples() if animation else []
    return (samples[0], samples[-1]) if samples else ()
