"""World poses: clips of a rig end to end, with the contacts of their feet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from usdfoot.analysis.motion import joint_kinematics
from usdfoot.analysis.world import WorldClip
from usdfoot.maths import quaternion
from usdfoot.maths.runs import Runs
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.contacts import FootContacts
from usdfoot.retarget.rig import Rig

__all__ = ["WorldPoses", "grounded", "world_poses"]


@dataclass(frozen=True, kw_only=True)
class WorldPoses:
    """C clips in the world, N samples in all."""

    worlds: Sequence[WorldClip]
    """The clips and their contacts."""
    places: FloatArray
    """Joint positions [m], shape (N, J, 3)."""
    turns: FloatArray
    """Joint rotations, shape (N, J, 4)."""

    @property
    def runs(self) -> Runs:
        """Which samples are whose."""
        return Runs.of_lengths(np.array([len(world.clip.rotations) for world in self.worlds]))

    @property
    def samples(self) -> list[slice]:
        """Samples of each clip."""
        first = self.runs.first.tolist()
        return [slice(*ends) for ends in pairwise(first)]

    def frames_of(self, joints: Sequence[int], frames: Sequence[FloatArray]) -> FloatArray:
        """World rotations of K frames (4,), each fixed in its joint, shape (N, K, 4)."""
        return quaternion.compose(self.turns[:, list(joints)], np.stack(frames))


def world_poses(rig: Rig, worlds: Sequence[WorldClip]) -> WorldPoses:
    """All samples of world clips, by forward kinematics in the clips' own proportions."""
    translations, rotations = [world.clip.translations for world in worlds], [world.clip.rotations for world in worlds]
    joints = np.arange(len(rig.skeleton.joints))
    places, turns = joint_kinematics(rig.skeleton, translations, rotations, joints=joints)
    return WorldPoses(worlds=worlds, places=places, turns=turns)


def grounded(times: FloatArray, contacts: FootContacts) -> BoolArray:
    """Whether a foot is on the ground at times [s] (T,)."""
    if not len(contacts.strike_times):
        return np.zeros(len(times), dtype=bool)
    index = np.searchsorted(contacts.strike_times, times, side="right") - 1
    return (index >= 0) & (times <= contacts.liftoff_times[np.maximum(index, 0)])
