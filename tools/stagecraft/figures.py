"""Figures of the clips beside the published ones, for `stages/README.md`."""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np

from stagecraft.clips_stage import Clip
from stagecraft.leg_ik import knee_flexion
from stagecraft.rig import FootShape, Rig
from stagecraft.rotation import FloatArray
from stagecraft.walker import joint_positions


@dataclass(frozen=True, kw_only=True)
class ClipFigures:
    """What a clip measures."""

    clip: str
    seconds: float
    speed: float
    """Mean speed of the pelvis over the ground [m/s]."""
    excursion: float
    """Highest less lowest height of the pelvis [cm]."""
    rotation: float
    """Largest turn of the pelvis from the mean of chest and pelvis [degrees]."""
    list: float
    """Largest list of the pelvis to either side [degrees]."""
    knee_least: float
    knee_most: float
    """Knee flexion [degrees]."""
    sole_least: float
    """Lowest point of heel or ball over the ground [mm]."""


def measure(clip: Clip, rig: Rig, foot: FootShape) -> ClipFigures:
    """Figures of one clip."""
    seconds = clip.plan.end - clip.plan.start
    travel = np.linalg.norm(np.diff(clip.pelvis[:, [0, 2]], axis=0), axis=1).sum()
    pelvis, chest = clip.world[:, rig.index("Hips")], clip.world[:, rig.index("Chest")]
    apart = np.angle(np.exp(1j * (_yaw(pelvis) - _yaw(chest))))
    knees = np.degrees(np.concatenate([_knee(clip, rig, side) for side in ("Left", "Right")]))
    return ClipFigures(
        clip=clip.plan.name,
        seconds=seconds,
        speed=float(travel / seconds),
        excursion=100.0 * float(np.ptp(clip.pelvis[:, 1])),
        rotation=float(np.degrees(np.abs(apart).max()) / 2.0),
        list=float(np.degrees(np.abs(np.arcsin(pelvis[:, 1, 0])).max())),
        knee_least=float(knees.min()),
        knee_most=float(knees.max()),
        sole_least=1000.0 * _lowest(clip, rig, foot),
    )


def table(rows: list[ClipFigures]) -> Iterator[str]:
    """The figures as a Markdown table."""
    names = [field.name for field in fields(ClipFigures)]
    yield "| " + " | ".join(names) + " |"
    yield "|" + "---|" * len(names)
    for row in rows:
        values = [getattr(row, name) for name in names]
        yield "| " + " | ".join(value if isinstance(value, str) else f"{value + 0.0:.2f}" for value in values) + " |"


def _yaw(rotations: FloatArray) -> FloatArray:
    return np.arctan2(rotations[:, 0, 2], rotations[:, 2, 2])


def _knee(clip: Clip, rig: Rig, side: str) -> FloatArray:
    thigh, shank = (clip.world[:, rig.index(side + name)] for name in ("UpLeg", "Leg"))
    return knee_flexion(thigh, shank, (rig.bone(f"{side}Leg"), rig.bone(f"{side}Foot")))


def _lowest(clip: Clip, rig: Rig, foot: FootShape) -> float:
    """Height of the lowest sole point under ball or heel over the ground at y = 0 [m]."""
    places = joint_positions(rig, clip.pelvis, clip.world)
    balls = [places[:, rig.index(f"{side}Toe"), 1] - foot.ball_height for side in ("Left", "Right")]
    heel = np.array([0.0, -foot.ankle_height, foot.ankle_back - foot.heel_back])
    heels = [
        places[:, rig.index(f"{side}Foot"), 1] + (clip.world[:, rig.index(f"{side}Foot")] @ heel)[:, 1]
        for side in ("Left", "Right")
    ]
    return float(min(np.min(balls), np.min(heels)))
