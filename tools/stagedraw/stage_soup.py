"""What a USD stage shows at a time: static meshes, footprints, and characters as UsdSkel deforms them."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom, UsdSkel, Vt

from stagedraw.soup import FloatArray, MeshShape, Soup, join, place, read_lines, read_mesh, transform

EVERYTHING = Usd.TraverseInstanceProxies()


@dataclass(frozen=True, kw_only=True)
class Skin:
    """One mesh bound to a skeleton."""

    shape: MeshShape
    joints: NDArray[np.int64]
    """Joints of the mesh's own order, shape (N, K)."""
    weights: FloatArray
    """Their weights, sum 1, shape (N, K)."""
    query: UsdSkel.SkinningQuery


@dataclass(frozen=True, kw_only=True)
class Character:
    """A skeleton and its skins."""

    path: str
    """The SkelRoot."""
    prim: Usd.Prim
    """The Skeleton; within an instance its proxy, which knows where it stands (the query's prim does not)."""
    skeleton: UsdSkel.SkeletonQuery
    skins: tuple[Skin, ...]


def static_soup(stage: Usd.Stage, code: float) -> Soup:
    """Every visible mesh that no skeleton moves, linear curves, and the instances of every PointInstancer."""
    time = Usd.TimeCode(code)
    soups: list[Soup] = []
    xforms = UsdGeom.XformCache(time)
    prims = iter(Usd.PrimRange(stage.GetPseudoRoot(), EVERYTHING))
    for prim in prims:
        if prim.IsA(UsdGeom.Imageable) and not _visible(prim, time):
            prims.PruneChildren()
        elif prim.IsA(UsdGeom.PointInstancer):
            soups += _instances(UsdGeom.PointInstancer(prim), time, xforms)
            prims.PruneChildren()
        elif prim.IsA(UsdGeom.Mesh) and not prim.HasAPI(UsdSkel.BindingAPI):
            shape = read_mesh(UsdGeom.Mesh(prim))
            soups.append(place(shape, transform(shape.points, xforms.GetLocalToWorldTransform(prim))))
        elif prim.IsA(UsdGeom.BasisCurves):
            shape = read_lines(UsdGeom.BasisCurves(prim))
            soups.append(place(shape, transform(shape.points, xforms.GetLocalToWorldTransform(prim))))
    return join(soups)


def read_characters(stage: Usd.Stage) -> list[Character]:
    """All visible characters, instances included."""
    return [
        character
        for prim in Usd.PrimRange(stage.GetPseudoRoot(), EVERYTHING)
        if prim.IsA(UsdSkel.Root) and _visible(prim, Usd.TimeCode.EarliestTime())
        for character in _characters(UsdSkel.Root(prim))
    ]


def character_soup(character: Character, code: float) -> Soup:
    """The character's skin at a time code, by linear blend skinning."""
    time = Usd.TimeCode(code)
    to_world = UsdGeom.XformCache(time).GetLocalToWorldTransform(character.prim)
    turned = character.skeleton.ComputeSkinningTransforms(time)
    soups = []
    for skin in character.skins:
        mapper = skin.query.GetJointMapper()
        own = mapper and not mapper.IsIdentity()
        matrices = np.array(mapper.RemapTransforms(turned, Vt.Matrix4dArray(len(mapper))) if own else turned)
        bound = transform(skin.shape.points, skin.query.GetGeomBindTransform(time))
        moved = np.zeros_like(bound)
        for influence in range(skin.joints.shape[1]):
            matrix = matrices[skin.joints[:, influence]]
            point = np.einsum("nj,njk->nk", bound, matrix[:, :3, :3]) + matrix[:, 3, :3]
            moved += skin.weights[:, influence, None] * point
        soups.append(place(skin.shape, transform(moved, to_world)))
    return join(soups)


def _characters(root: UsdSkel.Root) -> Iterator[Character]:
    cache = UsdSkel.Cache()
    cache.Populate(root, EVERYTHING)
    for binding in cache.ComputeSkelBindings(root, EVERYTHING):
        targets = [query for query in binding.GetSkinningTargets() if query.GetPrim().IsA(UsdGeom.Mesh)]
        yield Character(
            path=str(root.GetPath()),
            prim=binding.GetSkeleton().GetPrim(),
            skeleton=cache.GetSkelQuery(binding.GetSkeleton()),
            skins=tuple(_skin(query) for query in targets),
        )


def _skin(query: UsdSkel.SkinningQuery) -> Skin:
    shape = read_mesh(UsdGeom.Mesh(query.GetPrim()))
    indices, weights = query.ComputeVaryingJointInfluences(len(shape.points))
    joints = np.array(indices, dtype=np.int64).reshape(len(shape.points), -1)
    shares = np.array(weights, dtype=np.float64).reshape(joints.shape)
    shares /= np.maximum(shares.sum(axis=1, keepdims=True), 1e-9)
    return Skin(shape=shape, joints=joints, weights=shares, query=query)


def _instances(instancer: UsdGeom.PointInstancer, time: Usd.TimeCode, xforms: UsdGeom.XformCache) -> Iterator[Soup]:
    """The meshes at or below each prototype, once an instance."""
    to_world = xforms.GetLocalToWorldTransform(instancer.GetPrim())
    prototypes = [
        _prototype(instancer.GetPrim().GetStage().GetPrimAtPath(target), xforms)
        for target in instancer.GetPrototypesRel().GetForwardedTargets()
    ]
    matrices = instancer.ComputeInstanceTransformsAtTime(
        time, time, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask
    )
    numbers = instancer.GetProtoIndicesAttr().Get(time) or []
    mask = instancer.ComputeMaskAtTime(time) or [True] * len(numbers)
    for number, matrix, shown in zip(numbers, matrices, mask, strict=False):
        for shape, points in prototypes[number] if shown else ():
            yield place(shape, transform(points, matrix * to_world))


def _prototype(prim: Usd.Prim, xforms: UsdGeom.XformCache) -> list[tuple[MeshShape, FloatArray]]:
    """Meshes of a prototype with their points in its parent's space."""
    above = xforms.GetLocalToWorldTransform(prim.GetParent()).GetInverse()
    meshes = [child for child in Usd.PrimRange(prim, EVERYTHING) if child.IsA(UsdGeom.Mesh)]
    shapes = [read_mesh(UsdGeom.Mesh(mesh)) for mesh in meshes]
    return [
        (shape, transform(shape.points, xforms.GetLocalToWorldTransform(mesh) * above))
        for mesh, shape in zip(meshes, shapes, strict=True)
    ]


def _visible(prim: Usd.Prim, time: Usd.TimeCode) -> bool:
    return UsdGeom.Imageable(prim).ComputeVisibility(time) != UsdGeom.Tokens.invisible
