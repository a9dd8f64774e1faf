"""USD stages as all files of `stages/` have them: metres, Y up, 30 codes a second, a default prim."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from stagecraft.body import Part
from stagecraft.rotation import FloatArray

CODES_PER_SECOND = 30.0


def new_stage(path: Path, default_prim: str, type_name: str, made_by: str) -> Usd.Stage:
    """An empty stage at `path` with the project's metadata and its default prim."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(CODES_PER_SECOND)
    stage.SetFramesPerSecond(CODES_PER_SECOND)
    stage.GetRootLayer().customLayerData = {"usdfoot": {"madeBy": f"tools/make_stages.py: {made_by}"}}
    stage.SetDefaultPrim(stage.DefinePrim(f"/{default_prim}", type_name))
    return stage


def uniform(prim: Usd.Prim, name: str, type_name: Sdf.ValueTypeName, value: object) -> None:
    """Author a uniform schema attribute, with or without the usdfoot plugin."""
    prim.CreateAttribute(name, type_name, custom=False, variability=Sdf.VariabilityUniform).Set(value)


def relate(prim: Usd.Prim, name: str, targets: Sequence[str]) -> None:
    """Author a schema relationship."""
    prim.CreateRelationship(name, custom=False).SetTargets([Sdf.Path(target) for target in targets])


def vectors(values: FloatArray) -> Vt.Vec3fArray:
    """Float triples for USD."""
    return Vt.Vec3fArray.FromNumpy(np.ascontiguousarray(values, dtype=np.float32))


def extent_of(points: FloatArray) -> Vt.Vec3fArray:
    """Bounds of `points`, shape (N, 3), in the precision they are written with."""
    written = np.asarray(points, dtype=np.float32)
    return Vt.Vec3fArray.FromNumpy(np.stack([written.min(axis=0), written.max(axis=0)]))


def define_mesh(
    stage: Usd.Stage,
    path: str,
    *,
    points: FloatArray,
    counts: NDArray[np.int64],
    indices: NDArray[np.int64],
    normals: FloatArray,
    colours: FloatArray,
    per: str,
) -> UsdGeom.Mesh:
    """A polygon mesh; `per` is "vertex" or "uniform" (per face), for normals and colours of which there are several."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(vectors(points))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.asarray(counts, dtype=np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(np.asarray(indices, dtype=np.int32).ravel()))
    mesh.CreateNormalsAttr(vectors(normals))
    mesh.SetNormalsInterpolation(per if len(normals) > 1 else UsdGeom.Tokens.constant)
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateExtentAttr(extent_of(points))
    mesh.CreateDisplayColorPrimvar(per if len(colours) > 1 else UsdGeom.Tokens.constant).Set(vectors(colours))
    return mesh


def define_skinned(
    stage: Usd.Stage, path: str, part: Part, *, skeleton: str, joints: NDArray[np.int64], weights: FloatArray
) -> None:
    """A part of a body, bound to `skeleton` by joints and weights of its points, shape (N, K) each."""
    quads = part.mesh.quads
    mesh = define_mesh(
        stage,
        path,
        points=part.mesh.points,
        counts=np.full(len(quads), 4),
        indices=quads,
        normals=part.mesh.normals,
        colours=part.colours,
        per="vertex",
    )
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton])
    binding.CreateGeomBindTransformAttr(Gf.Matrix4d(1.0))
    indices = Vt.IntArray.FromNumpy(joints.astype(np.int32).ravel())
    binding.CreateJointIndicesPrimvar(False, joints.shape[1]).Set(indices)
    shares = Vt.FloatArray.FromNumpy(weights.astype(np.float32).ravel())
    binding.CreateJointWeightsPrimvar(False, joints.shape[1]).Set(shares)


def matrices(rotations: FloatArray, places: FloatArray) -> Vt.Matrix4dArray:
    """USD matrices (row vectors) of rotations (J, 3, 3) and places (J, 3)."""
    whole = np.tile(np.eye(4), (len(places), 1, 1))
    whole[:, :3, :3] = np.swapaxes(rotations, -1, -2)
    whole[:, 3, :3] = places
    return Vt.Matrix4dArray([Gf.Matrix4d(row.tolist()) for row in whole])
