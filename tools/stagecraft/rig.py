"""The skeleton of the person: 24 joints, 1.75 m tall in shoes; modelled with the arms 35 degrees out.

Lengths follow the segment table of Drillis and Contini (Winter, Biomechanics and Motor Control of Human Movement,
table 4.1) for a body of 1.73 m on soles of 2 cm. Every joint's axes are the skeleton's own in the modelling pose,
so a joint's rotation reads as what the limb did: about +X flexion, +Y yaw, +Z list.
"""

from dataclasses import dataclass

import numpy as np

from stagecraft.rotation import FloatArray

ARM_ANGLE = np.radians(35.0)
"""Angle of the arms from straight down in the modelling pose [rad]."""

SIDES = ("Left", "Right")

TORSO = (
    ("Hips", "", (0.0, 0.985, -0.005)),
    ("Spine", "Hips", (0.0, 1.080, -0.015)),
    ("Spine1", "Spine", (0.0, 1.200, -0.020)),
    ("Chest", "Spine1", (0.0, 1.320, -0.025)),
    ("Neck", "Chest", (0.0, 1.475, -0.020)),
    ("Head", "Neck", (0.0, 1.560, 0.000)),
)
LEG = (
    ("UpLeg", "Hips", (0.090, 0.935, 0.000)),
    ("Leg", "UpLeg", (0.090, 0.5135, 0.0260)),
    ("Foot", "Leg", (0.090, 0.0900, -0.0450)),
    ("Toe", "Foot", (0.090, 0.0340, 0.0900)),
)


@dataclass(frozen=True, kw_only=True)
class Rig:
    """Names, parents and places of the joints."""

    names: tuple[str, ...]
    """Leaf name of each joint, parents first."""
    parents: tuple[int, ...]
    """Index of the parent, -1 for the pelvis."""
    positions: FloatArray
    """Place of each joint in the modelling pose, skeleton space [m], shape (J, 3)."""

    def index(self, name: str) -> int:
        """Index of the joint called `name`."""
        return self.names.index(name)

    def path(self, name: str) -> str:
        """UsdSkel token of the joint: the path from the root."""
        parent = self.parents[self.index(name)]
        return name if parent < 0 else f"{self.path(self.names[parent])}/{name}"

    def place(self, name: str) -> FloatArray:
        """Place of a joint in the modelling pose [m], shape (3,)."""
        return self.positions[self.index(name)]

    def bone(self, name: str) -> FloatArray:
        """Vector from the parent of `name` to it in the modelling pose [m], shape (3,)."""
        parent = self.parents[self.index(name)]
        return self.place(name) - (self.positions[parent] if parent >= 0 else 0.0)

    @property
    def tokens(self) -> list[str]:
        """`Skeleton.joints`."""
        return [self.path(name) for name in self.names]


@dataclass(frozen=True, kw_only=True)
class FootShape:
    """The foot in its own vertical plane, flat on the ground."""

    ball_height: float
    """Ball joint above the sole [m]."""
    ankle_height: float
    """Ankle joint above the sole [m]."""
    ankle_back: float
    """Ankle behind the ball, along the foot [m]."""
    toe_length: float
    """Tip of the toes before the ball [m]."""

    @property
    def heel_back(self) -> float:
        """Point of the heel that strikes, behind the ball [m]: 0.4 of ankle to ball behind the ankle (design 2)."""
        return self.ankle_back + 0.4 * float(np.hypot(self.ankle_back, self.ankle_height - self.ball_height))


def human_rig() -> Rig:
    """The person's skeleton."""
    rows = list(TORSO)
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
        rows += [_sided(side, sign, row) for row in _arm()]
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
        rows += [_sided(side, sign, row) for row in LEG]
    names = tuple(name for name, _, _ in rows)
    return Rig(
        names=names,
        parents=tuple(names.index(parent) if parent else -1 for _, parent, _ in rows),
        positions=np.array([place for _, _, place in rows]),
    )


def human_foot() -> FootShape:
    """The shape of the person's shoe, as the joints have it."""
    places = {name: place for name, _, place in LEG}
    return FootShape(
        ball_height=places["Toe"][1],
        ankle_height=places["Foot"][1],
        ankle_back=places["Toe"][2] - places["Foot"][2],
        toe_length=0.072,
    )


def _arm() -> tuple[tuple[str, str, tuple[float, float, float]], ...]:
    """Clavicle to fingers of the left arm, straight, `ARM_ANGLE` from vertical."""
    shoulder = np.array([0.185, 1.420, -0.030])
    along = np.array([np.sin(ARM_ANGLE), -np.cos(ARM_ANGLE), 0.0])
    elbow, wrist = shoulder + 0.295 * along, shoulder + 0.550 * along
    fingers = wrist + 0.095 * along
    return (
        ("Shoulder", "Chest", (0.035, 1.435, -0.020)),
        ("Arm", "Shoulder", tuple(shoulder)),
        ("ForeArm", "Arm", tuple(elbow)),
        ("Hand", "ForeArm", tuple(wrist)),
        ("Fingers", "Hand", tuple(fingers)),
    )


def _sided(side: str, sign: float, row: tuple) -> tuple[str, str, tuple[float, float, float]]:
    name, parent, (x, y, z) = row
    central = parent in ("Hips", "Chest")
    return side + name, parent if central else side + parent, (sign * x, y, z)
