"""The biped of [P] 2.2: a body at the centre of mass, two virtual legs, two feet."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.analysis.body import find_body
from usdfoot.analysis.feet import heels_ahead
from usdfoot.errors import BipedError
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.skeleton import Skeleton, forward_kinematics
from usdfoot.model.tuning import BodyTuning
from usdfoot.retarget.rig import standing_pose

__all__ = ["PhysicsBiped", "measure_biped", "standing_skeleton", "tune_biped"]

TOE_REACH = 0.35
"""The end of the sole ahead of the ball, as a fraction of the distance from ankle to ball."""


@dataclass(frozen=True, kw_only=True)
class PhysicsBiped:
    """Five frames ([P] Figure 5). Pairs are (left, right).

    The body's frame has its origin at the centre of mass, +Z ahead and +Y up when it stands. A print's frame has its
    origin on the ground under the ball, +Z along the foot and +Y along the ground's normal.

    Raises:
        BipedError: If a length is not positive, or the legs' nominal length exceeds the maximal.
    """

    name: str
    """Prim path of the Skeleton, for messages."""
    hips: FloatArray
    """Hip joints in the body's frame [m], shape (2, 3)."""
    pelvis: FloatArray
    """Pelvis joint in the body's frame [m], shape (3,)."""
    pelvis_rotation: FloatArray
    """Rest rotation of the pelvis joint in the body's frame, xyzw, shape (4,)."""
    nominal_length: float
    """Comfortable length of the virtual leg, hip to ankle [m]."""
    maximal_length: float
    """Length of the virtual leg with the knee straight [m]."""
    ankles: FloatArray
    """Ankle joints of the flat feet in the prints' frames [m], shape (2, 3)."""
    heel: float
    """Rear end of the sole along the print's +Z, negative [m]."""
    toe: float
    """Front end of the sole along the print's +Z [m]."""
    humanlike: bool = False
    """Whether its trunk stands and has arms and a neck, so that its masses are distributed as people's."""

    def __post_init__(self) -> None:
        finite = all(np.isfinite(values).all() for values in (self.hips, self.pelvis, self.ankles))
        lengths = (self.nominal_length, self.maximal_length)
        if not finite or not np.isfinite(lengths).all() or min(lengths) <= 0.0:
            raise BipedError(self.name, f"has legs of length {lengths[0]:.4g} (nominal), {lengths[1]:.4g} (maximal) m",
                             "both must be positive")  # fmt: skip
        if self.nominal_length > self.maximal_length:
            raise BipedError(
                self.name,
                f"legs are nominally {self.nominal_length:.4g} m long, more than their maximum of "
                f"{self.maximal_length:.4g} m",
                "author usdfoot:biped:legLength:nominal below legLength:max",
            )
        if not self.heel < self.toe:
            raise BipedError(self.name, "has feet without length", "ankle and ball must lie apart")


def standing_skeleton(library: ClipLibrary) -> Skeleton:
    """The skeleton at rest in the pose it was rigged in, where its own rest pose is a frame of some animation."""
    skeleton = library.skeleton
    pose = standing_pose(skeleton, library.biped, library.bind_pose)
    if pose is not library.bind_pose:
        return skeleton
    hangs = skeleton.parents >= 0
    above = np.where(hangs[:, None], pose.turns[skeleton.parents], [0.0, 0.0, 0.0, 1.0])
    return replace(skeleton, rest_rotations=quaternion.compose(quaternion.inverse(above), pose.turns))


def measure_biped(skeleton: Skeleton, biped: Biped) -> PhysicsBiped:
    """The biped of a character, measured on the rest pose and as far as authored.

    The body faces across the hips, whichever way the rest pose looks; the feet count as flat in the rest pose.
    """
    places, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    hips, ankles, balls = (places[list(pair)] for pair in (biped.hips, biped.ankles, biped.balls))
    across = hips[0] - hips[1]
    facing = planar.yaw_of(np.array([-across[2], across[0]]))
    to_body = quaternion.yaw_quaternion(-facing)
    com = places[biped.pelvis] + biped.com
    feet = balls - ankles  # (2, 3)
    lengths = np.linalg.norm(feet, axis=1)
    ahead = np.hypot(feet[:, 0], feet[:, 2])
    soles = np.column_stack([np.zeros(2), biped.ball_heights - feet[:, 1], -ahead])
    return PhysicsBiped(
        name=skeleton.name,
        hips=quaternion.rotate(to_body, hips - com),
        pelvis=quaternion.rotate(to_body, places[biped.pelvis] - com),
        pelvis_rotation=quaternion.compose(to_body, turns[biped.pelvis]),
        nominal_length=biped.nominal_leg_length,
        maximal_length=biped.maximal_leg_length,
        ankles=soles,
        heel=float(np.mean(heels_ahead(ahead, -feet[:, 1], biped.ball_heights) - ahead)),
        toe=TOE_REACH * float(lengths.mean()),
        humanlike=_is_humanlike(skeleton, biped, quaternion.rotate(to_body, places)),
    )


def _is_humanlike(skeleton: Skeleton, biped: Biped, places: FloatArray) -> bool:
    """Whether a body has two arms, a neck and a trunk that stands; places (J, 3) in the body's frame [m]."""
    body = find_body(skeleton, biped, places)
    if None in body.arms or not body.neck or not body.trunk:
        return False
    across = places[body.trunk[-1]] - places[biped.pelvis]
    return bool(across[1] > abs(across[2]))


def tune_biped(biped: PhysicsBiped, tuning: BodyTuning) -> PhysicsBiped:
    """The biped with crouch and centre of mass as tuned ([P] 3); legs stretch up to their maximal length."""
    given = tuning.given
    shift = np.array([given.get(name, 0.0) for name in ("com_left", "com_up", "com_ahead")])
    return replace(
        biped,
        hips=biped.hips - shift,
        pelvis=biped.pelvis - shift,
        nominal_length=min(biped.nominal_length * (1.0 - given.get("crouch", 0.0)), biped.maximal_length),
    )
