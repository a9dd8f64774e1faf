"""CrowdPose: all agents at one instant, and how poses are put together with what rests."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from usdfoot.engine.pose_source import Poses
from usdfoot.maths import quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.carried import CarriedJoints, find_carried
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.skeleton import forward_kinematics
from usdfoot.realtime.slots import with_rows

__all__ = ["CrowdPose", "RestingJoints", "rest_joints"]


@dataclass(frozen=True, kw_only=True)
class CrowdPose:
    """All N agents at one instant, canonical: metres, +Y up, facing +Z."""

    time: float
    """[s]"""
    root_positions: FloatArray
    """On the ground, world [m], shape (N, 3)."""
    root_yaws: FloatArray
    """About +Y from +Z to +X [rad], shape (N,)."""
    translations: FloatArray
    """Joint-local; those of top joints are below the root [m], float32, shape (N, J, 3)."""
    rotations: FloatArray
    """Joint-local xyzw, float32, shape (N, J, 4)."""
    halted: BoolArray
    """Who stands, or is about to, for want of a footstep, shape (N,)."""
    there: BoolArray
    """Who is there, shape (N,); those who are not rest at the origin."""

    def among(self, others: CrowdPose, agents: IntArray) -> CrowdPose:
        """A pose of others with these agents in rows `agents` (N,) of it."""
        arrays: dict[str, Any] = {
            name: with_rows(getattr(others, name), agents, values)
            for name, values in vars(self).items()
            if isinstance(values, np.ndarray)
        }
        return replace(others, **arrays)


@dataclass(frozen=True, kw_only=True)
class RestingJoints:
    """What is the same in every pose of a skeleton."""

    pelvis: int
    above: IntArray
    """Joints above the pelvis, which rest."""
    translations: FloatArray
    """Of the rest pose [m], float32, shape (J, 3)."""
    rotations: FloatArray
    """Of the rest pose, float32, shape (J, 4)."""
    place: FloatArray
    """The pelvis's parent below the root [m], shape (3,)."""
    turn: FloatArray
    """Its rotation, shape (4,)."""
    carried: CarriedJoints
    """Joints that rest but for going along with one of the body."""

    def pose(self, time: float, count: int) -> CrowdPose:
        """As many agents as there is room for, none of whom is there."""
        return CrowdPose(
            time=time,
            root_positions=np.zeros((count, 3)),
            root_yaws=np.zeros(count),
            translations=np.tile(self.translations, (count, 1, 1)),
            rotations=np.tile(self.rotations, (count, 1, 1)),
            halted=np.ones(count, dtype=bool),
            there=np.zeros(count, dtype=bool),
        )

    def finish(
        self, poses: Poses, roots: FloatArray, *, origins: FloatArray, time: float, halted: BoolArray
    ) -> CrowdPose:
        """Poses about the agents' origins (N, 3) [m], put below roots (N, 4): x, height, z [m] and yaw [rad]."""
        away = quaternion.yaw_quaternion(-roots[:, 3])
        undo = quaternion.inverse(self.turn)
        pelvis = quaternion.rotate(away, poses.pelvis_positions.numpy() + (origins - roots[:, :3]))
        turned = quaternion.compose(away, poses.pelvis_rotations.numpy())
        rotations = poses.rotations.numpy()
        rotations[:, self.pelvis] = quaternion.compose(undo, turned)
        rotations[:, self.above] = self.rotations[self.above]
        translations = np.empty((*rotations.shape[:2], 3), dtype=np.float32)
        translations[:] = self.translations
        translations[:, self.pelvis] = quaternion.rotate(undo, pelvis - self.place)
        if self.carried.joints.size:
            moved, turned = self.carried.carry(translations, rotations)
            translations[:, self.carried.joints], rotations[:, self.carried.joints] = moved, turned
        return CrowdPose(
            time=time,
            root_positions=roots[:, :3],
            root_yaws=roots[:, 3],
            translations=translations,
            rotations=rotations,
            halted=halted,
            there=np.ones(len(roots), dtype=bool),
        )


def rest_joints(library: ClipLibrary) -> RestingJoints:
    """What rests of a library's skeleton."""
    skeleton, pelvis = library.skeleton, library.biped.pelvis
    places, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    above = skeleton.ancestors(pelvis)
    return RestingJoints(
        pelvis=pelvis,
        above=np.array(above, dtype=np.intp),
        translations=skeleton.rest_translations.astype(np.float32),
        rotations=skeleton.rest_rotations.astype(np.float32),
        place=places[above[0]] if above else np.zeros(3),
        turn=turns[above[0]] if above else np.array([0.0, 0.0, 0.0, 1.0]),
        carried=find_carried(skeleton, library.biped),
    )
