"""Animals on two legs: a skeleton, what its legs are, and closed surfaces bound to its bones by distance."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stagecraft.body import Part
from stagecraft.rig import SIDES, Rig
from stagecraft.rotation import FloatArray
from stagecraft.skinning import INFLUENCES

Place = tuple[float, float, float]
Row = tuple[str, str, Place]
"""Name, parent and place of a joint [m]."""

ROLES = ("hip", "knee", "ankle", "ball")


@dataclass(frozen=True, kw_only=True)
class Animal:
    """A character that walks on two legs, modelled as it stands."""

    name: str
    about: str
    """What it is, for the stage's metadata."""
    rig: Rig
    legs: Mapping[str, str]
    """Joint of the left leg without its side, by role."""
    ball_height: float
    """Ball joint above the sole [m]."""
    com: Place
    """Centre of mass, skeleton space [m]."""
    tips: Mapping[str, Place]
    """Where the bones of joints without children end [m]; right ones mirror the left."""
    parts: tuple[Part, ...]
    stiffness: float = 6.0
    """How sharply the skin follows its nearest bone, in bone radii."""

    @property
    def nominal_leg_length(self) -> float:
        """Hip to ankle as modelled [m]."""
        hip, ankle = (self.rig.place(f"Left{self.legs[role]}") for role in ("hip", "ankle"))
        return float(np.linalg.norm(hip - ankle))

    @property
    def maximal_leg_length(self) -> float:
        """Hip to ankle with the knee straight [m]."""
        places = [self.rig.place(f"Left{self.legs[role]}") for role in ("hip", "knee", "ankle")]
        return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def two_sided_rig(middle: Sequence[Row], left: Sequence[Row]) -> Rig:
    """A skeleton of joints in the middle and, for each side, those of the left and their mirror images.

    A parent of a `left` joint that is no `left` joint itself is one in the middle.
    """
    own = {name for name, _, _ in left}
    rows = list(middle)
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
        for name, parent, (x, y, z) in left:
            rows.append((side + name, side + parent if parent in own else parent, (sign * x, y, z)))
    names = tuple(name for name, _, _ in rows)
    return Rig(
        names=names,
        parents=tuple(names.index(parent) if parent else -1 for _, parent, _ in rows),
        positions=np.array([place for _, _, place in rows]),
    )


def bind(points: FloatArray, animal: Animal) -> tuple[NDArray[np.int64], FloatArray]:
    """Joint indices and weights (sum 1, largest first) of `points` (N, 3), shape (N, 4) each: the nearest bones hold.

    A left point is not held by a right bone, nor the other way.
    """
    distances = np.stack([_distance(points, animal, joint) for joint in range(len(animal.rig.names))], axis=1)
    for side, sign in zip(SIDES, (1.0, -1.0), strict=True):
        across = sign * points[:, 0] < -0.01
        others = np.array([name.startswith(side) for name in animal.rig.names])
        distances[across[:, None] & others] += 1.0
    size = 0.1 * animal.nominal_leg_length
    share = np.exp(-animal.stiffness * (distances - distances.min(axis=1, keepdims=True)) / size)
    order = np.argsort(-share, axis=1, kind="stable")[:, :INFLUENCES]
    weights = np.take_along_axis(share, order, axis=1)
    weights /= weights.sum(axis=1, keepdims=True)
    weights[weights < 0.01] = 0.0
    weights /= weights.sum(axis=1, keepdims=True)
    return np.where(weights > 0.0, order, 0), weights


def _distance(points: FloatArray, animal: Animal, joint: int) -> FloatArray:
    """Distance of points (N, 3) to the bones from a joint to its children, or to its tip [m], shape (N,)."""
    start = animal.rig.positions[joint]
    ends = [animal.rig.positions[child] for child, parent in enumerate(animal.rig.parents) if parent == joint]
    nearest = np.full(len(points), np.inf)
    for end in ends or [_tip(animal, joint)]:
        axis = end - start
        along = np.clip((points - start) @ axis / max(float(axis @ axis), 1e-12), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(points - start - along[:, None] * axis, axis=1))
    return nearest


def _tip(animal: Animal, joint: int) -> FloatArray:
    name = animal.rig.names[joint]
    bare = name.removeprefix("Left").removeprefix("Right")
    if bare not in animal.tips:
        return animal.rig.positions[joint]
    tip = np.array(animal.tips[bare])
    return tip * [-1.0, 1.0, 1.0] if name.startswith("Right") else tip
