"""A two-legged dinosaur, 4.6 m long: bird legs that stand on their toes (digitigrade), horizontal body, long tail."""

import numpy as np

from stagecraft.animal import Animal, two_sided_rig
from stagecraft.body import Part, coloured, on_ground
from stagecraft.solids import blend, ellipsoid, limb, mirrored
from stagecraft.surface_nets import mesh_solid

HIDE, BELLY, STRIPE = (0.30, 0.38, 0.22), (0.66, 0.62, 0.44), (0.17, 0.23, 0.15)
CLAW, EYE = (0.20, 0.17, 0.13), (0.90, 0.60, 0.10)

MIDDLE = (
    ("Pelvis", "", (0.0, 1.300, 0.000)),
    ("Trunk", "Pelvis", (0.0, 1.340, 0.350)),
    ("Chest", "Trunk", (0.0, 1.400, 0.700)),
    ("Neck1", "Chest", (0.0, 1.520, 1.000)),
    ("Neck2", "Neck1", (0.0, 1.740, 1.170)),
    ("Head", "Neck2", (0.0, 1.900, 1.290)),
    ("Tail1", "Pelvis", (0.0, 1.310, -0.350)),
    ("Tail2", "Tail1", (0.0, 1.290, -0.750)),
    ("Tail3", "Tail2", (0.0, 1.270, -1.150)),
    ("Tail4", "Tail3", (0.0, 1.270, -1.550)),
    ("Tail5", "Tail4", (0.0, 1.290, -1.950)),
)
LEFT = (
    ("UpperArm", "Chest", (0.175, 1.320, 0.800)),
    ("LowerArm", "UpperArm", (0.205, 1.150, 0.740)),
    ("Claw", "LowerArm", (0.195, 1.060, 0.880)),
    ("Femur", "Pelvis", (0.170, 1.200, 0.020)),
    ("Tibia", "Femur", (0.190, 0.820, 0.200)),
    ("Metatarsus", "Tibia", (0.190, 0.400, -0.120)),
    ("Toes", "Metatarsus", (0.190, 0.070, 0.080)),
)


def dinosaur() -> Animal:
    """The dinosaur as it stands."""
    return Animal(
        name="Dinosaur",
        about="a two-legged dinosaur of 4.6 m modelled by tools/stagecraft/dinosaur.py",
        rig=two_sided_rig(MIDDLE, LEFT),
        legs={"hip": "Femur", "knee": "Tibia", "ankle": "Metatarsus", "ball": "Toes"},
        ball_height=0.070,
        com=(0.0, 1.290, 0.120),
        tips={
            "Head": (0.0, 1.860, 1.660),
            "Tail5": (0.0, 1.310, -2.700),
            "Claw": (0.190, 1.000, 0.960),
            "Toes": (0.190, 0.030, 0.360),
        },
        parts=(_body(), _legs(), _eyes()),
    )


def _body() -> Part:
    trunk = blend(
        [
            ellipsoid((0.0, 1.300, 0.020), (0.235, 0.270, 0.400)),
            ellipsoid((0.0, 1.300, 0.430), (0.255, 0.290, 0.420)),
            ellipsoid((0.0, 1.380, 0.780), (0.190, 0.220, 0.300)),
        ],
        0.15,
    )
    tail = blend(
        [
            limb((0.0, 1.310, -0.150), (0.0, 1.290, -0.900), (0.215, 0.130)),
            limb((0.0, 1.290, -0.900), (0.0, 1.270, -1.700), (0.130, 0.070)),
            limb((0.0, 1.270, -1.700), (0.0, 1.315, -2.700), (0.070, 0.018)),
        ],
        0.10,
    )
    head = blend(
        [
            limb((0.0, 1.400, 0.820), (0.0, 1.570, 1.050), (0.185, 0.125)),
            limb((0.0, 1.570, 1.050), (0.0, 1.900, 1.290), (0.125, 0.100)),
            ellipsoid((0.0, 1.915, 1.340), (0.115, 0.125, 0.165)),
            limb((0.0, 1.900, 1.400), (0.0, 1.860, 1.650), (0.105, 0.062)),
            mirrored(ellipsoid((0.070, 1.985, 1.370), (0.030, 0.030, 0.075))),
        ],
        0.07,
    )
    arms = mirrored(
        blend(
            [
                limb((0.165, 1.330, 0.800), (0.205, 1.150, 0.740), (0.066, 0.042)),
                limb((0.205, 1.150, 0.740), (0.195, 1.060, 0.880), (0.042, 0.030)),
                limb((0.195, 1.060, 0.880), (0.190, 1.000, 0.960), (0.028, 0.012)),
            ],
            0.03,
        )
    )
    solid = blend([blend([trunk, tail, head], 0.12), arms], 0.03)
    mesh = mesh_solid(solid, np.array([-0.32, 0.94, -2.75]), np.array([0.32, 2.08, 1.75]), 0.036)
    x, y, z = mesh.points.T
    back = mesh.normals[:, 1] > 0.35
    under = (mesh.normals[:, 1] < -0.45) & (np.abs(x) < 0.19)
    return coloured("Hide", mesh, HIDE, [(under, BELLY), (back & (np.sin(18.0 * z) > 0.25) & (y > 1.2), STRIPE)])


def _legs() -> Part:
    hip, knee, heel, ball = ((0.170, 1.180, 0.0), (0.190, 0.820, 0.190), (0.190, 0.400, -0.120), (0.190, 0.075, 0.080))
    leg = blend(
        [
            limb(hip, knee, (0.200, 0.120)),
            limb((0.180, 1.100, -0.080), (0.190, 0.780, 0.040), (0.150, 0.110)),
            limb(knee, heel, (0.125, 0.066)),
            limb((0.190, 0.720, 0.050), (0.190, 0.540, -0.060), (0.105, 0.070)),
            limb(heel, ball, (0.068, 0.066)),
        ],
        0.06,
    )
    toes = [
        limb(ball, (0.190 + reach * np.sin(angle), 0.030, 0.08 + reach * np.cos(angle)), (0.066, 0.030))
        for angle, reach in ((0.0, 0.300), (0.45, 0.250), (-0.45, 0.250))
    ]
    solid = mirrored(blend([leg, *toes], 0.03))
    mesh = on_ground(mesh_solid(solid, np.array([-0.45, -0.03, -0.35]), np.array([0.45, 1.42, 0.48]), 0.030))
    _, y, z = mesh.points.T
    return coloured("Legs", mesh, HIDE, [((y < 0.09) & (z > 0.31), CLAW)])


def _eyes() -> Part:
    solid = mirrored(ellipsoid((0.100, 1.945, 1.400), (0.020, 0.024, 0.024)))
    mesh = mesh_solid(solid, np.array([-0.15, 1.9, 1.35]), np.array([0.15, 2.0, 1.45]), 0.011)
    return coloured("Eyes", mesh, EYE, [])
