"""The body of the person: clothes, skin, hair and shoes as closed smooth surfaces around the joints.

Radii and depths are those of an average adult (girths after Pheasant and Haslegrave, Bodyspace, 2006), modelled in the
rig's modelling pose.
"""

from dataclasses import dataclass

import numpy as np

from stagecraft.rig import Rig
from stagecraft.rotation import FloatArray
from stagecraft.solids import Solid, blend, cut, ellipsoid, limb, mirrored
from stagecraft.surface_nets import QuadMesh, mesh_solid

SKIN, LIPS = (0.80, 0.58, 0.46), (0.66, 0.36, 0.32)
HAIR, EYE_WHITE, PUPIL = (0.17, 0.11, 0.07), (0.93, 0.92, 0.90), (0.10, 0.07, 0.05)
SHIRT, COLLAR = (0.23, 0.42, 0.62), (0.86, 0.87, 0.88)
TROUSERS, BELT = (0.20, 0.22, 0.27), (0.14, 0.10, 0.08)
SHOE, SOLE = (0.36, 0.20, 0.12), (0.90, 0.89, 0.86)


@dataclass(frozen=True, kw_only=True)
class Part:
    """One mesh of the body."""

    name: str
    mesh: QuadMesh
    colours: FloatArray
    """Linear RGB of each vertex, shape (N, 3)."""


def build_body(rig: Rig) -> list[Part]:
    """All meshes of the person, in the rig's modelling pose."""
    return [_skin(rig), _eyes(), _hair(), _shirt(rig), _trousers(rig), _shoes(rig)]


def _trousers(rig: Rig) -> Part:
    hip, knee, ankle = (rig.place(name) for name in ("LeftUpLeg", "LeftLeg", "LeftFoot"))
    calf = knee + 0.32 * (ankle - knee) + [0.0, 0.0, -0.008]
    hem = ankle + [0.0, 0.012, 0.002]
    leg = blend(
        [
            limb(hip + [0.006, -0.02, -0.006], knee + [0.0, 0.0, -0.012], (0.090, 0.063)),
            limb(hip + [0.010, -0.12, 0.012], knee + [0.0, 0.10, 0.004], (0.072, 0.056)),
            limb(knee + [0.0, 0.0, -0.012], calf, (0.062, 0.063)),
            limb(calf, hem, (0.063, 0.053)),
        ],
        0.05,
    )
    seat = blend(
        [
            ellipsoid((0.0, 0.975, -0.006), (0.158, 0.120, 0.108)),
            mirrored(ellipsoid((0.072, 0.925, -0.048), (0.084, 0.085, 0.078))),
        ],
        0.05,
    )
    solid = cut(blend([seat, mirrored(cut(leg, (0, 0.078, 0), (0, -1, 0)))], 0.03), (0, 1.055, 0), (0, 1, 0))
    mesh = mesh_solid(solid, np.array([-0.22, 0.06, -0.17]), np.array([0.22, 1.08, 0.15]), 0.0155)
    return coloured("Trousers", mesh, TROUSERS, [(mesh.points[:, 1] > 1.03, BELT)])


def _shirt(rig: Rig) -> Part:
    shoulder, elbow = rig.place("LeftArm"), rig.place("LeftForeArm")
    along = (elbow - shoulder) / np.linalg.norm(elbow - shoulder)
    sleeve = cut(limb(shoulder + [-0.008, -0.004, 0.0], elbow, (0.062, 0.050)), shoulder + 0.225 * along, along)
    trunk = blend(
        [
            ellipsoid((0.0, 1.000, -0.004), (0.166, 0.150, 0.116)),
            ellipsoid((0.0, 1.120, 0.000), (0.143, 0.150, 0.106)),
            ellipsoid((0.0, 1.275, -0.014), (0.163, 0.160, 0.117)),
            mirrored(ellipsoid((0.070, 1.325, 0.050), (0.080, 0.070, 0.052))),
            mirrored(ellipsoid((0.085, 1.345, -0.070), (0.085, 0.105, 0.050))),
            mirrored(limb((0.03, 1.432, -0.022), shoulder + [-0.012, -0.012, 0.0], (0.058, 0.060))),
        ],
        0.06,
    )
    solid = cut(
        cut(blend([trunk, mirrored(sleeve)], 0.035), (0, 0.935, 0), (0, -1, 0)), (0, 1.487, 0.02), (0.0, 1.0, 0.45)
    )
    mesh = mesh_solid(solid, np.array([-0.42, 0.9, -0.17]), np.array([0.42, 1.53, 0.16]), 0.0155)
    collar = (mesh.points @ [0.0, 1.0, 0.45] > 1.478) & (np.abs(mesh.points[:, 0]) < 0.085)
    return coloured("Shirt", mesh, SHIRT, [(collar, COLLAR)])


def _skin(rig: Rig) -> Part:
    head = blend(
        [
            ellipsoid((0.0, 1.650, 0.000), (0.074, 0.090, 0.094)),
            ellipsoid((0.0, 1.598, 0.034), (0.052, 0.062, 0.056)),
            limb((0.0, 1.643, 0.084), (0.0, 1.617, 0.094), (0.008, 0.011)),
            mirrored(ellipsoid((0.036, 1.622, 0.055), (0.026, 0.024, 0.026))),
            ellipsoid((0.0, 1.588, 0.086), (0.020, 0.009, 0.009)),
        ],
        0.022,
    )
    ears = mirrored(ellipsoid((0.076, 1.635, -0.006), (0.010, 0.030, 0.019)))
    neck = limb((0.0, 1.43, -0.022), (0.0, 1.585, 0.002), (0.060, 0.054))
    solid = blend([blend([head, ears], 0.01), neck], 0.035)
    top = mesh_solid(solid, np.array([-0.1, 1.36, -0.12]), np.array([0.1, 1.76, 0.13]), 0.0085)
    arms = mesh_solid(mirrored(_arm(rig)), np.array([-0.62, 0.74, -0.12]), np.array([0.62, 1.32, 0.12]), 0.0085)
    mesh = QuadMesh(
        points=np.concatenate([top.points, arms.points]),
        normals=np.concatenate([top.normals, arms.normals]),
        quads=np.concatenate([top.quads, arms.quads + len(top.points)]),
    )
    x, y, z = mesh.points.T
    lips = (np.abs(x) < 0.024) & (np.abs(y - 1.588) < 0.0085) & (z > 0.085)
    brows = (np.abs(np.abs(x) - 0.032) < 0.017) & (np.abs(y - 1.668) < 0.005) & (z > 0.06)
    return coloured("Skin", mesh, SKIN, [(lips, LIPS), (brows, HAIR)])


def _arm(rig: Rig) -> Solid:
    """Forearm and hand; the palm faces the thigh, the thumb points ahead."""
    elbow, wrist, knuckles = (rig.place(name) for name in ("LeftForeArm", "LeftHand", "LeftFingers"))
    along = (wrist - elbow) / np.linalg.norm(wrist - elbow)
    across = np.array([along[1], -along[0], 0.0])  # out of the back of the hand, towards the body
    ahead = np.array([0.0, 0.0, 1.0])
    forearm = blend(
        [
            limb(elbow - 0.09 * along, elbow, (0.042, 0.043)),
            limb(elbow, elbow + 0.4 * (wrist - elbow), (0.043, 0.042)),
            limb(elbow + 0.4 * (wrist - elbow), wrist, (0.042, 0.027)),
        ],
        0.02,
    )
    palm = limb(wrist + 0.012 * along, knuckles - 0.004 * along, (0.030, 0.043), flat=(across, 0.42))
    fingers = [
        limb(
            knuckles + 0.019 * (1.5 - n) * ahead,
            knuckles + length * along + 0.017 * (1.5 - n) * ahead,
            (0.0105, 0.0085),
        )
        for n, length in enumerate((0.074, 0.084, 0.078, 0.060))
    ]
    thumb = limb(
        wrist + 0.030 * along + 0.022 * ahead, wrist + 0.085 * along + 0.056 * ahead + 0.008 * across, (0.015, 0.0105)
    )
    return blend([forearm, blend([palm, *fingers, thumb], 0.012)], 0.02)


def _eyes() -> Part:
    mesh = mesh_solid(
        mirrored(ellipsoid((0.031, 1.646, 0.0735), (0.0135, 0.0105, 0.0125))),
        np.array([-0.06, 1.62, 0.05]),
        np.array([0.06, 1.67, 0.1]),
        0.0035,
    )
    away = np.hypot(np.abs(mesh.points[:, 0]) - 0.031, mesh.points[:, 1] - 1.646)
    return coloured("Eyes", mesh, EYE_WHITE, [((away < 0.0062) & (mesh.points[:, 2] > 0.078), PUPIL)])


def _hair() -> Part:
    cap = blend(
        [
            ellipsoid((0.0, 1.654, -0.004), (0.083, 0.096, 0.100)),
            ellipsoid((0.0, 1.600, -0.050), (0.066, 0.062, 0.050)),
        ],
        0.03,
    )
    hairline = cut(cut(cap, (0, 1.690, 0.052), (0.0, -0.42, 0.9), 0.02), (0, 1.560, 0), (0, -1, 0))
    mesh = mesh_solid(hairline, np.array([-0.1, 1.53, -0.12]), np.array([0.1, 1.77, 0.12]), 0.0095)
    return coloured("Hair", mesh, HAIR, [])


def _shoes(rig: Rig) -> Part:
    ankle, ball = rig.place("LeftFoot"), rig.place("LeftToe")
    x = float(ball[0])
    shoe = blend(
        [
            ellipsoid((x - 0.003, 0.036, ankle[2] - 0.012), (0.040, 0.050, 0.056)),
            limb((x, 0.050, ankle[2]), (x, 0.038, ball[2]), (0.040, 0.040)),
            ellipsoid((x + 0.002, 0.022, ball[2] + 0.006), (0.049, 0.040, 0.078)),
            limb((x, 0.080, ankle[2] - 0.004), (x, 0.120, ankle[2] - 0.006), (0.043, 0.042)),
        ],
        0.03,
    )
    solid = cut(cut(shoe, (0, 0, 0), (0, -1, 0), 0.006), (0, 0.135, 0), (0, 1, 0))
    mesh = mesh_solid(mirrored(solid), np.array([-0.18, -0.02, -0.14]), np.array([0.18, 0.16, 0.2]), 0.0105)
    level = on_ground(mesh)
    return coloured("Shoes", level, SHOE, [(level.points[:, 1] < 0.024, SOLE)])


def on_ground(mesh: QuadMesh) -> QuadMesh:
    """The mesh with a level sole at y = 0 and nothing below it."""
    points = mesh.points.copy()
    points[(mesh.normals[:, 1] < -0.8) & (points[:, 1] < 0.006), 1] = 0.0
    points[:, 1] = np.maximum(points[:, 1], 0.0)
    return QuadMesh(points=points, normals=mesh.normals, quads=mesh.quads)


def coloured(
    name: str,
    mesh: QuadMesh,
    base: tuple[float, float, float],
    patches: list[tuple[np.ndarray, tuple[float, float, float]]],
) -> Part:
    """A part of one colour with patches of others; each patch is a mask of the vertices and its colour."""
    colours = np.tile(base, (len(mesh.points), 1))
    for where, colour in patches:
        colours[where] = colour
    return Part(name=name, mesh=mesh, colours=colours)
