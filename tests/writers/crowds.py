"""Hand-made characters, motions and scenes with known truth, for the writers' tests."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdSkel, Vt

from usdfoot.bridge.chunk_files import chunk_files
from usdfoot.bridge.scene import Character, Scene, StageInfo
from usdfoot.bridge.similarity import Similarity, similarity_of_matrices
from usdfoot.bridge.units import StageUnits
from usdfoot.maths import quaternion
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.biped import Biped
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.contacts import Contacts, FootContacts
from usdfoot.model.motion import Motion, StepResults
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.model.terrain import Terrain
from usdfoot.readers.bounds import read_bounds
from usdfoot.readers.skeleton import matrices_of, read_skeleton, skeleton_in
from usdfoot.writers import crowd as crowd_writer
from usdfoot.writers.chunks import write_chunk
from usdfoot.writers.crowd import check_output, crowd_format
from usdfoot.writers.placing import place_characters

JOINTS = ["root"] + [
    f"root/pelvis{rest}"
    for side in ("L", "R")
    for rest in ([""] if side == "L" else [])
    + [f"/hip{side}", f"/hip{side}/knee{side}", f"/hip{side}/knee{side}/ankle{side}"]
    + [f"/hip{side}/knee{side}/ankle{side}/ball{side}"]
]
OFFSETS = {
    "root": (0.0, 0.1, 0.0),
    "pelvis": (0.0, 0.85, 0.0),
    "hip": (0.1, -0.05, 0.0),
    "knee": (0.0, -0.42, 0.02),
    "ankle": (0.0, -0.4, -0.02),
    "ball": (0.0, -0.05, 0.13),
}


@dataclass(frozen=True, kw_only=True)
class Rig:
    """How the asset stands in its file."""

    units: StageUnits = field(default_factory=StageUnits)
    scale_above: float = 1.0
    """Scale op between the character prim and the Skeleton."""
    bound: bool = False
    """Whether the Skeleton has an animation of its own."""
    moving: bool = False
    """Whether a transform between the character prim and the Skeleton moves and turns, over four time codes."""


def write_character(path: Path, rig: Rig) -> Path:
    """A skinned character, file authored in the rig's units, facing the canonical +Z."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, rig.units.meters_per_unit)
    UsdGeom.SetStageUpAxis(stage, rig.units.up_axis)
    stage.SetTimeCodesPerSecond(rig.units.time_codes_per_second)
    root = UsdSkel.Root.Define(stage, "/Hero")
    stage.SetDefaultPrim(root.GetPrim())
    group = UsdGeom.Xform.Define(stage, "/Hero/Group")
    if rig.moving:
        move, turn = group.AddTranslateOp(), group.AddRotateXOp()
        for code in range(5):
            move.Set(Gf.Vec3d(0.3, 0.2, 0.1) * code / rig.units.meters_per_unit, code)
            turn.Set(10.0 * code, code)
    group.AddScaleOp().Set(Gf.Vec3f(rig.scale_above))
    skeleton = UsdSkel.Skeleton.Define(stage, "/Hero/Group/Skeleton")
    per_unit = 1.0 / (rig.units.meters_per_unit * rig.scale_above)
    matrices = []
    for joint in JOINTS:
        leaf = joint.rsplit("/", 1)[-1]
        offset = np.array(OFFSETS[leaf.rstrip("LR")]) * (-1.0 if leaf == "hipR" else 1.0, 1.0, 1.0)
        turn = (0.0, 0.0, 0.0, 1.0)
        if leaf == "root":
            offset, turn = rig.units.directions_to_stage(offset), rig.units.frames_to_stage(np.array(turn))
        x, y, z, w = (float(value) for value in turn)
        matrices.append(Gf.Matrix4d(Gf.Rotation(Gf.Quatd(w, x, y, z)), Gf.Vec3d(*(offset * per_unit).tolist())))
    topology = UsdSkel.Topology(JOINTS)
    skeleton.CreateJointsAttr(JOINTS)
    skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray(matrices))
    bind = UsdSkel.ConcatJointTransforms(topology, Vt.Matrix4dArray(matrices))
    skeleton.CreateBindTransformsAttr(bind)
    mesh = UsdGeom.Mesh.Define(stage, "/Hero/Group/Body")
    points = np.array([matrix.ExtractTranslation() for matrix in bind], dtype=np.float32)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    corners = np.stack([points.min(axis=0), points.max(axis=0)]) + np.array([[-0.01], [0.01]]) * per_unit
    mesh.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(corners.astype(np.float32)))
    mesh.CreateFaceVertexCountsAttr([3, 3])
    mesh.CreateFaceVertexIndicesAttr([2, 3, 4, 6, 7, 8])
    mesh.CreateSubdivisionSchemeAttr("none")
    mesh.CreateNormalsAttr(Vt.Vec3fArray(len(points), Gf.Vec3f(0, 0, 1)))
    mesh.SetNormalsInterpolation("vertex")
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateJointIndicesPrimvar(False, 1).Set(Vt.IntArray(range(len(points))))
    binding.CreateJointWeightsPrimvar(False, 1).Set(Vt.FloatArray(len(points), 1.0))
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    if rig.bound:
        animation = UsdSkel.Animation.Define(stage, "/Hero/Group/Skeleton/Idle")
        animation.CreateJointsAttr(JOINTS)
        animation.SetTransforms(Vt.Matrix4dArray(matrices))
        own = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
        own.CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    stage.GetRootLayer().Save()
    return path


def character_of(path: Path, *, tilt: float = 0.0, size: float = 1.0, codes: Sequence[float] = (0.0,)) -> Character:
    """The character as a reader would describe it, with a biped known from the joint order.

    Args:
        path: Its file.
        tilt: Rotation of the character prim about the stage's x axis in the scene [rad].
        size: Scale of the character prim in the scene.
        codes: Time codes to know the transforms above the Skeleton at; more than one only where they move.
    """
    stage = Usd.Stage.Open(str(path))
    units = StageUnits(
        meters_per_unit=UsdGeom.GetStageMetersPerUnit(stage),
        up_axis=str(UsdGeom.GetStageUpAxis(stage)),
        time_codes_per_second=stage.GetTimeCodesPerSecond(),
    )
    prim = stage.GetPrimAtPath("/Hero/Group/Skeleton")
    raw = read_skeleton(prim)
    to_prim = similarity_of_matrices(matrices_of(prim, np.array(codes)), prim.GetPath())
    stance = quaternion.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(tilt))
    to_agent = Similarity(
        scale=size * units.meters_per_unit,
        rotation=units.frames_to_canonical(stance)[None],
        translation=np.zeros((1, 3)),
    ).after(to_prim)
    skeleton = skeleton_in(raw, to_agent)
    biped = Biped(
        pelvis=1,
        hips=(2, 6),
        knees=(3, 7),
        ankles=(4, 8),
        balls=(5, 9),
        ball_heights=np.array([0.03, 0.03]),
        com=np.zeros(3),
        nominal_leg_length=0.75,
        maximal_leg_length=0.82,
    )
    return Character(
        path="/World/Hero",
        asset=str(path),
        asset_prim="/Hero",
        skeleton_path="Group/Skeleton",
        agent_rotation=stance,
        agent_scale=size,
        skeleton_to_agent=to_agent,
        skeleton=skeleton,
        biped=biped,
        rest_scales=raw.scales,
        inherited_scales=raw.inherited_scales,
        bounds=read_bounds(str(path), "/Hero", skeleton_path="Group/Skeleton", joints=raw.joints),
        still_extent=None,
    )


def wandering_motion(name: str, character: Character, *, frames: int, rate: float, seed: int = 1) -> Motion:
    """Smooth made-up motion of all joints; contacts and results of a four-step plan."""
    generator = np.random.default_rng(seed)
    times = np.arange(frames) / rate
    joints = len(character.skeleton.joints)
    phases, axes = generator.uniform(0.0, 6.0, (joints,)), generator.normal(size=(joints, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    swings = 0.4 * np.sin(3.0 * times[:, None] + phases)
    rotations = quaternion.compose(character.skeleton.rest_rotations, quaternion.from_axis_angle(axes[None], swings))
    stand = FootContacts(
        strike_times=np.array([0.0, 0.6]),
        flat_times=np.array([0.1, 0.7]),
        liftoff_times=np.array([0.4, 1.0]),
        positions=np.array([[0.1, 0.0, 0.0], [0.1, 0.02, 1.0]]),
        yaws=np.zeros(2),
        ball_first=np.zeros(2, dtype=bool),
    )
    return Motion(
        name=name,
        times=times,
        root_positions=np.stack([0.3 * times, 0.1 * np.sin(times), 1.2 * times], axis=1),
        root_yaws=3.0 + times,
        pelvis_positions=np.stack([0.02 * np.sin(times), 0.9 + 0.03 * np.cos(times), 0.0 * times], axis=1),
        pelvis_rotations=quaternion.from_axis_angle(np.array([0.6, 0.0, 0.8]), 0.2 * np.sin(2.0 * times)),
        rotations=rotations,
        contacts=Contacts(left=stand, right=stand),
        results=results_of(4),
    )


def results_of(count: int) -> StepResults:
    """Different numbers in every column."""
    ramp = np.arange(count) + 1.0
    return StepResults(
        blend_error=ramp * 1e-4,
        placement_error=ramp * 2e-4,
        slide=ramp * 3e-4,
        yaw_error=ramp * 1e-3,
        hull_distance=ramp * 4e-4,
        time_warp=1.0 + ramp * 0.1,
        root_velocity_error=0.05 * ramp,
        root_weight=np.zeros(count),
        beta=ramp * 0.05,
        status=tuple(["ok", "outsideHull", "ikLimited", "unreachable"][i % 4] for i in range(count)),
        clip_counts=np.full(count, 2),
        clips=("a", "b") * count,
        clip_weights=np.tile([0.25, 0.75], count),
    )


def four_steps(name: str) -> FootstepPlan:
    """Left, right, left, right along +Z on rising ground."""
    return FootstepPlan(
        name=name,
        sides=np.array([0, 1, 0, 1]),
        positions=np.array([[0.1, 0.0, 0.0], [-0.1, 0.01, 0.5], [0.1, 0.02, 1.0], [-0.1, 0.03, 1.5]]),
        orientations=quaternion.yaw_quaternion(np.array([0.0, 0.1, 0.2, 0.3])),
        strike_times=np.array([0.0, 0.3, 0.6, 0.9]),
        liftoff_times=np.array([0.4, 0.7, 1.0, 1.3]),
        root_weights=np.zeros(4),
    )


def scene_of(character: Character, units: StageUnits, *, agents: int, frames: int) -> Scene:
    """Agents of one character on the same plan."""
    rate = units.time_codes_per_second
    library = ClipLibrary(skeleton=character.skeleton, biped=character.biped, clips=())
    crowd = Crowd(
        agents=tuple(
            Agent(name=f"A{i}", source=f"/World/A{i}", plan=four_steps(f"/World/Plans/A{i}"), library=0, character=0)
            for i in range(agents)
        ),
        libraries=(library,),
        terrain=Terrain(
            meshes=(),
            points=np.zeros((0, 3)),
            triangles=np.zeros((0, 3), dtype=int),
            mesh_indices=np.zeros(0, dtype=int),
            walkable=np.zeros(0, dtype=bool),
        ),
        frame_times=np.arange(frames) / rate,
        frame_rate=rate,
    )
    stage = StageInfo(
        identifier=character.asset,
        units=units,
        frames_per_second=rate,
        start_code=0.0,
        end_code=frames - 1.0,
        layers=(character.asset,),
    )
    return Scene(stage=stage, crowd=crowd, characters=(character,), frame_codes=np.arange(frames, dtype=float))


def world_joints(motion: Motion, character: Character) -> np.ndarray:
    """Joint positions [m] in the canonical world by a plain loop, shape (F, J, 3)."""
    skeleton = character.skeleton
    rest_positions, rest_turns = forward_kinematics(
        skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations
    )
    positions = np.zeros((len(motion.times), len(skeleton.joints), 3))
    for frame in range(len(motion.times)):
        turn = quaternion.yaw_quaternion(motion.root_yaws[frame])
        turns = {}
        for joint, parent in enumerate(skeleton.parents):
            if joint < character.biped.pelvis:
                place, spin = rest_positions[joint], rest_turns[joint]
            elif joint == character.biped.pelvis:
                place, spin = motion.pelvis_positions[frame], motion.pelvis_rotations[frame]
            else:
                above, spin_above = turns[int(parent)]
                place = above + quaternion.rotate(spin_above, skeleton.rest_translations[joint])
                spin = quaternion.compose(spin_above, motion.rotations[frame, joint])
            turns[joint] = (place, spin)
            positions[frame, joint] = quaternion.rotate(turn, place) + motion.root_positions[frame]
    return positions


def write_crowd(scene: Scene, motions: Sequence[Motion], folder: Path, *, collect: bool = False) -> tuple[Path, ...]:
    """The motions written as a crowd of one chunk; paths of crowd.usd and report.json."""
    check_output(scene, folder)
    characters = place_characters(scene.characters, folder, layer_format=crowd_format(scene), collect=collect)
    references = [(placed.reference.assetPath, str(placed.reference.primPath)) for placed in characters]
    cast = {agent.name: references[agent.character] for agent in scene.crowd.agents}
    files = chunk_files(0, 1)
    write_chunk(scene, motions, folder, files=files, references=[cast[motion.name] for motion in motions])
    with crowd_writer.open_crowd(scene, folder, intact={}) as crowd:
        crowd.add_chunk(files)
        return crowd.finish(
            [motion.name for motion in motions],
            characters=characters,
            provenance={"version": "1"},
            report={"agents": []},
        )
