"""A running bird of 1.15 m: backward knees (the heel joint of real birds), a long metatarsus, toes flat on the ground.

The thigh of a bird is hidden in its body; what is seen as the upper leg is the shin (tibia). So the leg has two bones:
tibia down and back, metatarsus down and forward, as in the figures of [P].
"""

import numpy as np

from stagecraft.animal import Animal, two_sided_rig
from stagecraft.body import Part, coloured, on_ground
from stagecraft.solids import blend, ellipsoid, limb, mirrored
from stagecraft.surface_nets import mesh_solid

PLUMAGE, WING, RUMP = (0.24, 0.20, 0.17), (0.13, 0.11, 0.10), (0.60, 0.55, 0.48)
SKIN, BEAK, LEG, CLAW = (0.28, 0.42, 0.55), (0.85, 0.55, 0.15), (0.78, 0.48, 0.20), (0.25, 0.20, 0.16)
EYE = (0.05, 0.04, 0.04)

MIDDLE = (
    ("Body", "", (0.0, 0.640, 0.000)),
    ("Breast", "Body", (0.0, 0.660, 0.130)),
    ("Neck1", "Breast", (0.0, 0.735, 0.230)),
    ("Neck2", "Neck1", (0.0, 0.850, 0.285)),
    ("Neck3", "Neck2", (0.0, 0.960, 0.295)),
    ("Head", "Neck3", (0.0, 1.065, 0.305)),
    ("Tail1", "Body", (0.0, 0.665, -0.150)),
    ("Tail2", "Tail1", (0.0, 0.650, -0.270)),
)
LEFT = (
    ("Wing", "Breast", (0.125, 0.725, 0.110)),
    ("WingTip", "Wing", (0.150, 0.670, -0.050)),
    ("Tibia", "Body", (0.085, 0.585, 0.050)),
    ("Tarsus", "Tibia", (0.085, 0.330, -0.085)),
    ("Toes", "Tarsus", (0.085, 0.034, 0.000)),
    ("ToeTips", "Toes", (0.085, 0.016, 0.058)),
)


def bird() -> Animal:
    """The bird as it stands."""
    return Animal(
        name="Bird",
        about="a running bird of 1.15 m modelled by tools/stagecraft/bird.py",
        rig=two_sided_rig(MIDDLE, LEFT),
        legs={"hip": "Tibia", "knee": "Tarsus", "ankle": "Toes", "ball": "ToeTips"},
        ball_height=0.016,
        com=(0.0, 0.650, 0.036),
        tips={
            "Head": (0.0, 1.060, 0.430),
            "Tail2": (0.0, 0.620, -0.380),
            "WingTip": (0.130, 0.630, -0.200),
            "ToeTips": (0.085, 0.012, 0.130),
        },
        parts=(_body(), _legs(), _beak(), _eyes()),
    )


def _body() -> Part:
    trunk = blend(
        [
            ellipsoid((0.0, 0.675, 0.010), (0.150, 0.150, 0.235)),
            ellipsoid((0.0, 0.690, 0.130), (0.110, 0.120, 0.130)),
            limb((0.0, 0.690, -0.150), (0.0, 0.620, -0.360), (0.085, 0.030), flat=((0.0, 1.0, 0.3), 0.55)),
        ],
        0.08,
    )
    neck = blend(
        [
            limb((0.0, 0.720, 0.200), (0.0, 0.850, 0.285), (0.075, 0.045)),
            limb((0.0, 0.850, 0.285), (0.0, 0.960, 0.295), (0.045, 0.034)),
            limb((0.0, 0.960, 0.295), (0.0, 1.065, 0.305), (0.034, 0.032)),
            ellipsoid((0.0, 1.085, 0.325), (0.042, 0.044, 0.062)),
        ],
        0.03,
    )
    wings = mirrored(ellipsoid((0.135, 0.675, -0.030), (0.032, 0.085, 0.180)))
    thighs = mirrored(limb((0.085, 0.590, 0.045), (0.085, 0.440, -0.030), (0.088, 0.040)))
    solid = blend([blend([trunk, neck], 0.06), wings, thighs], 0.025)
    mesh = mesh_solid(solid, np.array([-0.22, 0.38, -0.42]), np.array([0.22, 1.15, 0.42]), 0.0145)
    x, y, z = mesh.points.T
    wing = (np.abs(x) > 0.118) & (y > 0.56) & (y < 0.78) & (z < 0.16)
    return coloured(
        "Plumage",
        mesh,
        PLUMAGE,
        [(wing, WING), ((z < -0.24), RUMP), (y > 0.93, SKIN), ((y > 1.09) & (z < 0.33), PLUMAGE)],
    )


def _legs() -> Part:
    knee, base = (0.085, 0.330, -0.085), (0.085, 0.030, 0.000)
    toes = [
        limb(base, (0.085 + reach * np.sin(angle), 0.009, reach * np.cos(angle)), (0.015, 0.007))
        for angle, reach in ((0.0, 0.140), (0.42, 0.120), (-0.42, 0.120))
    ]
    back = limb(base, (0.078, 0.010, -0.030), (0.013, 0.007))
    leg = blend(
        [
            limb((0.085, 0.450, -0.022), knee, (0.036, 0.021)),
            ellipsoid(knee, (0.023, 0.026, 0.026)),
            limb(knee, base, (0.0175, 0.0150)),
        ],
        0.015,
    )
    solid = mirrored(blend([leg, blend([*toes, back], 0.010)], 0.012))
    mesh = on_ground(mesh_solid(solid, np.array([-0.17, -0.01, -0.12]), np.array([0.17, 0.49, 0.16]), 0.0092))
    return coloured("Legs", mesh, LEG, [((mesh.points[:, 1] < 0.02) & (mesh.points[:, 2] > 0.115), CLAW)])


def _beak() -> Part:
    solid = limb((0.0, 1.078, 0.370), (0.0, 1.055, 0.455), (0.024, 0.007), flat=((0.0, 1.0, 0.0), 0.8))
    mesh = mesh_solid(solid, np.array([-0.04, 1.03, 0.34]), np.array([0.04, 1.12, 0.47]), 0.007)
    return coloured("Beak", mesh, BEAK, [])


def _eyes() -> Part:
    mesh = mesh_solid(
        mirrored(ellipsoid((0.036, 1.097, 0.340), (0.010, 0.010, 0.010))),
        np.array([-0.06, 1.08, 0.32]),
        np.array([0.06, 1.12, 0.36]),
        0.005,
    )
    return coloured("Eyes", mesh, EYE, [])
