"""Small USD stages with known contents, in any units, axes and rate; everything is given in canonical space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from usdfoot.bridge.tokens import Agent, Plan, Schema

LEG = ("UpLeg", "Leg", "Foot", "ToeBase")
JOINTS = (
    "Hips",
    "Hips/Spine",
    "Hips/Spine/Head",
    *("/".join(["Hips", *(f"Left{name}" for name in LEG[: i + 1])]) for i in range(4)),
    *("/".join(["Hips", *(f"Right{name}" for name in LEG[: i + 1])]) for i in range(4)),
)
_LEG_OFFSETS = ((0.1, -0.05, 0.0), (0.0, -0.42, 0.0), (0.0, -0.4, 0.0), (0.0, -0.08, 0.12))
OFFSETS = np.array(
    [
        (0.0, 1.0, 0.0),
        (0.0, 0.2, 0.0),
        (0.0, 0.4, 0.0),
        *_LEG_OFFSETS,
        *((-x, y, z) for x, y, z in _LEG_OFFSETS),
    ]
)
"""Joint-local rest translations [m]: a person of 1.6 m whose balls are 5 cm above the ground, +Y up, facing +Z."""
BALL_HEIGHT = 0.05


@dataclass(frozen=True)
class Units:
    """What a test stage is written in."""

    meters: float = 1.0
    up: str = "Y"
    rate: float = 24.0

    def points(self, points) -> np.ndarray:
        """Canonical points or translations as stage values."""
        return self.directions(points) / self.meters

    def directions(self, vectors) -> np.ndarray:
        vectors = np.asarray(vectors, dtype=float)
        x, y, z = np.moveaxis(vectors, -1, 0)
        return np.stack((x, -z, y) if self.up == "Z" else (x, y, z), axis=-1)

    def rotations(self, quaternions) -> np.ndarray:
        quaternions = np.asarray(quaternions, dtype=float)
        return np.concatenate([self.directions(quaternions[..., :3]), quaternions[..., 3:]], axis=-1)


def new_stage(path=None, units: Units | None = None) -> Usd.Stage:
    """A stage in a file, or in memory, with default prim /World."""
    units = units or Units()
    stage = Usd.Stage.CreateNew(str(path)) if path else Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, units.meters)
    UsdGeom.SetStageUpAxis(stage, units.up)
    stage.SetTimeCodesPerSecond(units.rate)
    stage.SetFramesPerSecond(units.rate)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    return stage


def add_character(
    stage: Usd.Stage,
    path: str,
    units: Units,
    *,
    joints: Sequence[str] = JOINTS,
    offsets=OFFSETS,
    root_type: str = "SkelRoot",
    with_rest: bool = True,
    with_body: bool = False,
) -> UsdSkel.Skeleton:
    """A prim of `root_type` with a Skeleton below it, and on request a rigidly skinned box at every joint."""
    stage.DefinePrim(path, root_type)
    skeleton = UsdSkel.Skeleton.Define(stage, f"{path}/Skeleton")
    local = [Gf.Matrix4d(1.0).SetTranslate(Gf.Vec3d(*map(float, offset))) for offset in units.points(offsets)]
    world: list[Gf.Matrix4d] = []
    for i, joint in enumerate(joints):
        parent = joint.rsplit("/", 1)[0]
        world.append(local[i] * world[list(joints).index(parent)] if "/" in joint else local[i])
    skeleton.CreateJointsAttr(list(joints))
    skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray(world))
    if with_rest:
        skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray(local))
    if with_body:
        _add_body(stage, f"{path}/Body", skeleton, [matrix.ExtractTranslation() for matrix in world], units)
    return skeleton


def _add_body(stage, path, skeleton, positions, units) -> None:
    """A box from each joint to the ground plane for the feet, small for the others."""
    mesh = add_mesh(stage, path, np.zeros((0, 3)), [], units)
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    centres = np.array([tuple(position) for position in positions])
    sizes = units.points(np.full((len(centres), 3), BALL_HEIGHT))
    points = (centres[:, None] + corners * np.abs(sizes)[:, None]).reshape(-1, 3)
    faces = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    every = (faces[None] + 8 * np.arange(len(centres))[:, None, None]).reshape(-1)
    mesh.GetPointsAttr().Set(Vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
    mesh.GetFaceVertexCountsAttr().Set(Vt.IntArray([4] * (6 * len(centres))))
    mesh.GetFaceVertexIndicesAttr().Set(Vt.IntArray.FromNumpy(every.astype(np.int32)))
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateGeomBindTransformAttr(Gf.Matrix4d(1.0))
    indices = np.repeat(np.arange(len(centres)), 8).astype(np.int32)
    binding.CreateJointIndicesPrimvar(False, 1).Set(Vt.IntArray.FromNumpy(indices))
    binding.CreateJointWeightsPrimvar(False, 1).Set(Vt.FloatArray([1.0] * (8 * len(centres))))


def walk_pose(times, offsets=OFFSETS, joints: Sequence[str] = JOINTS, speed: float = 1.2):
    """Joint-local translations (T, J, 3) and rotations (T, J, 4) of something that swings its legs and travels +Z."""
    times = np.asarray(times, dtype=float)
    translations = np.repeat(np.asarray(offsets, dtype=float)[None], len(times), axis=0)
    rotations = np.tile([0.0, 0.0, 0.0, 1.0], (len(times), len(joints), 1))
    translations[:, 0, 2] += speed * times
    translations[:, 0, 1] += 0.02 * np.sin(4.0 * np.pi * times)
    for index, joint in enumerate(joints):
        name = joint.rsplit("/", 1)[-1]
        swing = {"UpLeg": 0.4, "Leg": 0.3, "Foot": 0.2}.get(name.removeprefix("Left").removeprefix("Right"), 0.05)
        sign = -1.0 if name.startswith("Right") else 1.0
        half = 0.5 * swing * sign * np.sin(2.0 * np.pi * times + index)
        rotations[:, index, 0], rotations[:, index, 3] = np.sin(half), np.cos(half)
    return translations, rotations


def add_clip(
    stage: Usd.Stage,
    path: str,
    units: Units,
    times,
    translations,
    rotations,
    *,
    joints: Sequence[str] = JOINTS,
    scales=None,
) -> UsdSkel.Animation:
    """A SkelAnimation with samples at the given times [s]."""
    animation = UsdSkel.Animation.Define(stage, path)
    animation.CreateJointsAttr(list(joints))
    animation.CreateTranslationsAttr()
    animation.CreateRotationsAttr()
    scales = np.ones((len(joints), 3)) if scales is None else np.asarray(scales, dtype=float)
    animation.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(*map(float, scale)) for scale in scales]))
    for time, moved, turned in zip(times, units.points(translations), units.rotations(rotations), strict=True):
        code = float(time) * units.rate
        animation.GetTranslationsAttr().Set(Vt.Vec3fArray.FromNumpy(moved.astype(np.float32)), code)
        animation.GetRotationsAttr().Set(Vt.QuatfArray.FromNumpy(turned.astype(np.float32)), code)
    return animation


def straight_steps(count: int = 6, length: float = 0.6, width: float = 0.2, step_time: float = 0.55):
    """Sides, positions, strike and liftoff times of a straight walk along +Z."""
    sides = np.arange(count) % 2
    positions = np.stack([np.where(sides == 0, 0.5, -0.5) * width, np.zeros(count), length * np.arange(count)], axis=1)
    strikes = 0.5 + step_time * np.arange(count)
    return sides, positions, strikes, strikes + 1.2 * step_time


def add_plan(
    stage: Usd.Stage,
    path: str,
    units: Units,
    steps=None,
    *,
    yaws=None,
    with_api: bool = True,
    half: bool = True,
) -> UsdGeom.PointInstancer:
    """A footstep plan; yaws None = no orientations are authored."""
    sides, positions, strikes, liftoffs = steps if steps is not None else straight_steps()
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    prints = [UsdGeom.Xform.Define(stage, f"{path}/Prints/{name}").GetPath() for name in ("Left", "Right")]
    instancer.CreatePrototypesRel().SetTargets(prints)
    instancer.CreateProtoIndicesAttr(Vt.IntArray([int(side) for side in sides]))
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(units.points(positions).astype(np.float32)))
    if yaws is not None:
        half_yaws = 0.5 * np.asarray(yaws, dtype=float)
        zero = np.zeros_like(half_yaws)
        turned = units.rotations(np.stack([zero, np.sin(half_yaws), zero, np.cos(half_yaws)], axis=-1))
        if half:
            instancer.CreateOrientationsAttr(Vt.QuathArray.FromNumpy(turned.astype(np.float16)))
        else:
            instancer.CreateOrientationsfAttr(Vt.QuatfArray.FromNumpy(turned.astype(np.float32)))
    prim = instancer.GetPrim()
    for name, times in ((Plan.STRIKE_TIMES, strikes), (Plan.LIFTOFF_TIMES, liftoffs)):
        attribute = prim.CreateAttribute(name, Sdf.ValueTypeNames.TimeCodeArray, False, Sdf.VariabilityUniform)
        attribute.Set(Sdf.TimeCodeArray([Sdf.TimeCode(float(time) * units.rate) for time in times]))
    if with_api:
        prim.AddAppliedSchema(Schema.PLAN)
    return instancer


def add_agent(stage: Usd.Stage, prim_path: str, /, **targets: str) -> Usd.Prim:
    """An agent prim with relationships by their last word: plan, path, trajectory, character, clips."""
    prim = stage.GetPrimAtPath(prim_path) or UsdGeom.Xform.Define(stage, prim_path).GetPrim()
    prim.AddAppliedSchema(Schema.AGENT)
    relationships = (Agent.PLAN, Agent.PATH, Agent.TRAJECTORY, Agent.CHARACTER, Agent.CLIPS)
    names = {name.rsplit(":", 1)[-1]: name for name in relationships}
    for word, target in targets.items():
        prim.CreateRelationship(names[word], False).SetTargets([Sdf.Path(target)])
    return prim


def add_mesh(stage: Usd.Stage, path: str, points, faces, units: Units, *, terrain: bool = False) -> UsdGeom.Mesh:
    """A mesh of polygons given as lists of point indices."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    stage_points = units.points(np.asarray(points, dtype=float).reshape(-1, 3))
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(stage_points.astype(np.float32)))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray([len(face) for face in faces]))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray([int(i) for face in faces for i in face]))
    if terrain:
        mesh.GetPrim().AddAppliedSchema(Schema.TERRAIN)
    return mesh


def add_ground(stage: Usd.Stage, path: str, units: Units, *, size: float = 10.0, terrain: bool = True) -> UsdGeom.Mesh:
    """A level square, wound counter-clockwise from above."""
    square = [(-size, 0.0, -size), (-size, 0.0, size), (size, 0.0, size), (size, 0.0, -size)]
    return add_mesh(stage, path, square, [(0, 1, 2, 3)], units, terrain=terrain)


def simple_scene(path=None, units: Units | None = None, *, schemas: bool = True, seconds: float = 3.0) -> Usd.Stage:
    """A character with a body, one clip, a ground and one plan, with or without usdfoot's schemas."""
    units = units or Units()
    stage = new_stage(path, units)
    add_character(stage, "/World/Hero", units, with_body=True)
    times = np.arange(0.0, seconds, 1.0 / 30.0)
    add_clip(stage, "/World/Clips/walk", units, times, *walk_pose(times))
    add_ground(stage, "/World/Ground", units, terrain=schemas)
    add_plan(stage, "/World/Plans/Walk", units, yaws=np.zeros(6), with_api=schemas)
    if schemas:
        add_agent(stage, "/World/Hero", plan="/World/Plans/Walk", clips="/World/Clips")
    if path:
        stage.GetRootLayer().Save()
    return stage


def crowd_stage(tmp_path, count=3):
    """Agents with one asset each of their own, one plan each, all clips shared."""
    source = new_stage(tmp_path / "hero.usda")
    add_character(source, "/World/Hero", Units())
    source.GetRootLayer().Save()
    stage = new_stage(tmp_path / "scene.usda")
    times = np.arange(0.0, 1.0, 1.0 / 30.0)
    add_clip(stage, "/World/Clips/walk", Units(), times, *walk_pose(times))
    for i in range(count):
        add_plan(stage, f"/World/Plans/P{i}", Units(), yaws=np.zeros(6))
        prim = stage.DefinePrim(f"/World/Group{i}/Walker")
        prim.GetReferences().AddReference("./hero.usda", "/World/Hero")
        add_agent(stage, str(prim.GetPath()), plan=f"/World/Plans/P{i}")
    return stage


def messages(scene, severity="error"):
    """What is said of a scene that was read."""
    return [problem.message for problem in scene.crowd.problems if problem.severity == severity]
