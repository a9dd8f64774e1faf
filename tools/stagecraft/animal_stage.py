"""`bird.usdc`, `dinosaur.usdc`: an animal as SkelRoot, Skeleton and skinned meshes."""

from pathlib import Path

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel

from stagecraft.animal import ROLES, Animal, bind
from stagecraft.stage_file import define_skinned, extent_of, matrices, new_stage, uniform


def write_animal(path: Path, animal: Animal) -> None:
    """Write the animal to `path`."""
    stage = new_stage(path, animal.name, "SkelRoot", animal.about)
    root = UsdSkel.Root(stage.GetDefaultPrim())
    Usd.ModelAPI(root.GetPrim()).SetKind("component")
    rig = animal.rig
    skeleton = UsdSkel.Skeleton.Define(stage, f"/{animal.name}/Skeleton")
    skeleton.CreateJointsAttr(rig.tokens)
    identity = np.tile(np.eye(3), (len(rig.names), 1, 1))
    skeleton.CreateBindTransformsAttr(matrices(identity, rig.positions))
    skeleton.CreateRestTransformsAttr(matrices(identity, np.array([rig.bone(name) for name in rig.names])))
    _biped(skeleton.GetPrim(), animal)
    UsdGeom.Scope.Define(stage, f"/{animal.name}/Body")
    for part in animal.parts:
        joints, weights = bind(part.mesh.points, animal)
        prim = f"/{animal.name}/Body/{part.name}"
        define_skinned(stage, prim, part, skeleton=f"/{animal.name}/Skeleton", joints=joints, weights=weights)
    root.CreateExtentAttr(extent_of(np.concatenate([part.mesh.points for part in animal.parts])))
    stage.Save()


def _biped(prim: Usd.Prim, animal: Animal) -> None:
    """The roles of the joints: no list of names knows them."""
    prim.AddAppliedSchema("UsdfootBipedAPI")
    rig, types = animal.rig, Sdf.ValueTypeNames
    uniform(prim, "usdfoot:biped:pelvis", types.Token, rig.path(rig.names[0]))
    for side in ("Left", "Right"):
        for role in ROLES:
            uniform(prim, f"usdfoot:biped:{side.lower()}:{role}", types.Token, rig.path(side + animal.legs[role]))
        uniform(prim, f"usdfoot:biped:{side.lower()}:ballHeight", types.Float, animal.ball_height)
    com = np.array(animal.com) - rig.positions[0]
    uniform(prim, "usdfoot:biped:com", types.Float3, Gf.Vec3f(*com.tolist()))
    uniform(prim, "usdfoot:biped:legLength:nominal", types.Float, animal.nominal_leg_length)
    uniform(prim, "usdfoot:biped:legLength:max", types.Float, animal.maximal_leg_length)
