"""`human.usdc`: the person as SkelRoot, Skeleton and skinned meshes."""

from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel

from stagecraft.body import Part, build_body
from stagecraft.rig import FootShape, Rig
from stagecraft.rotation import FloatArray
from stagecraft.skinning import deform, skin_weights
from stagecraft.stage_file import define_skinned, extent_of, matrices, new_stage, uniform
from stagecraft.upper_body import resting_arms
from stagecraft.walker import joint_positions, local_rotations

SEGMENTS = (
    ("Neck", "Head", 0.081, 1.9),
    ("LeftUpLeg", "LeftArm", 0.2485, 0.5),
    ("LeftArm", "LeftForeArm", 0.028, 0.436),
    ("LeftForeArm", "LeftHand", 0.016, 0.430),
    ("LeftHand", "LeftFingers", 0.006, 0.9),
    ("LeftUpLeg", "LeftLeg", 0.100, 0.433),
    ("LeftLeg", "LeftFoot", 0.0465, 0.433),
    ("LeftFoot", "LeftToe", 0.0145, 0.5),
)
"""First joint, second joint, part of the body's mass, place of the centre from one to the other (Winter, table 4.1)."""


def write_human(path: Path, rig: Rig, foot: FootShape) -> None:
    """Write the person to `path`."""
    stage = new_stage(path, "Human", "SkelRoot", "a person of 1.75 m modelled by tools/stagecraft/body.py")
    root = UsdSkel.Root(stage.GetDefaultPrim())
    Usd.ModelAPI(root.GetPrim()).SetKind("component")
    turns = rest_rotations(rig)
    skeleton = _skeleton(stage, rig, turns)
    _biped(skeleton.GetPrim(), rig, foot, turns)
    UsdGeom.Scope.Define(stage, "/Human/Body")
    posed = [_skinned_part(stage, part, rig, turns) for part in build_body(rig)]
    root.CreateExtentAttr(extent_of(np.concatenate(posed)))
    stage.Save()


def rest_rotations(rig: Rig) -> FloatArray:
    """Joint to skeleton rotations of the rest pose: the modelling pose with the arms hanging, shape (J, 3, 3)."""
    turns = np.tile(np.eye(3), (len(rig.names), 1, 1))
    for name, rotation in resting_arms().items():
        turns[rig.index(name)] = rotation[0]
    return turns


def centre_of_mass(rig: Rig, turns: FloatArray) -> FloatArray:
    """Centre of mass in the rest pose, from the pelvis joint [m], shape (3,)."""
    places = joint_positions(rig, rig.place("Hips")[None], turns[None])[0]
    total, moment = 0.0, np.zeros(3)
    for start, end, mass, part in SEGMENTS:
        for side in ("Left", "Right") if start.startswith("Left") else ("Left",):
            first = rig.index(start.replace("Left", side))
            last = rig.index(end.replace("Left", side))
            moment += mass * (places[first] + part * (places[last] - places[first]))
            total += mass
    return moment / total - places[0]


def _skeleton(stage: Usd.Stage, rig: Rig, turns: FloatArray) -> UsdSkel.Skeleton:
    skeleton = UsdSkel.Skeleton.Define(stage, "/Human/Skeleton")
    skeleton.CreateJointsAttr(rig.tokens)
    identity = np.tile(np.eye(3), (len(rig.names), 1, 1))
    skeleton.CreateBindTransformsAttr(matrices(identity, rig.positions))
    bones = np.array([rig.bone(name) for name in rig.names])
    skeleton.CreateRestTransformsAttr(matrices(local_rotations(rig, turns[None])[0], bones))
    return skeleton


def _biped(prim: Usd.Prim, rig: Rig, foot: FootShape, turns: FloatArray) -> None:
    """The roles of the joints, so that nothing has to be guessed."""
    prim.AddAppliedSchema("UsdfootBipedAPI")
    uniform(prim, "usdfoot:biped:pelvis", Sdf.ValueTypeNames.Token, rig.path("Hips"))
    for side in ("Left", "Right"):
        for role, name in (("hip", "UpLeg"), ("knee", "Leg"), ("ankle", "Foot"), ("ball", "Toe")):
            uniform(prim, f"usdfoot:biped:{side.lower()}:{role}", Sdf.ValueTypeNames.Token, rig.path(side + name))
        uniform(prim, f"usdfoot:biped:{side.lower()}:ballHeight", Sdf.ValueTypeNames.Float, foot.ball_height)
    thigh, shank = (float(np.linalg.norm(rig.bone(name))) for name in ("LeftLeg", "LeftFoot"))
    nominal = float(np.linalg.norm(rig.place("LeftUpLeg") - rig.place("LeftFoot")))
    uniform(prim, "usdfoot:biped:com", Sdf.ValueTypeNames.Float3, Gf.Vec3f(*centre_of_mass(rig, turns).tolist()))
    uniform(prim, "usdfoot:biped:legLength:nominal", Sdf.ValueTypeNames.Float, nominal)
    uniform(prim, "usdfoot:biped:legLength:max", Sdf.ValueTypeNames.Float, thigh + shank)


def _skinned_part(stage: Usd.Stage, part: Part, rig: Rig, turns: FloatArray) -> FloatArray:
    """Author one mesh; returns its points in the rest pose [m], shape (N, 3)."""
    points = part.mesh.points
    joints, weights = skin_weights(points, rig)
    define_skinned(stage, f"/Human/Body/{part.name}", part, skeleton="/Human/Skeleton", joints=joints, weights=weights)
    return deform(points, joints, weights, rig, joint_positions(rig, rig.place("Hips")[None], turns[None])[0], turns)
