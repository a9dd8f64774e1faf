"""Legs: how far the pelvis comes down so that they reach the feet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from usdfoot.maths.types import FloatArray
from usdfoot.retarget.poses import WorldPoses, grounded
from usdfoot.retarget.rig import Rig

__all__ = ["Legs", "legs_of", "lowering"]

REACH = 0.99
"""Part of its length a leg that stands is stretched to, unless the source's is stretched farther."""
DEEPEST = 0.35
"""The pelvis is lowered by at most this part of the leg."""
AHEAD = 0.1
"""The pelvis comes down and up again within so long [s]."""


@dataclass(frozen=True, kw_only=True)
class Legs:
    """Both legs in N samples."""

    hips: FloatArray
    """Hip joints [m], shape (N, 2, 3)."""
    thighs: FloatArray
    """From hip to knee [m], shape (N, 2, 3)."""
    shins: FloatArray
    """From knee to ankle [m], shape (N, 2, 3)."""

    @property
    def lengths(self) -> FloatArray:
        """Of the straight legs [m], shape (N, 2)."""
        return np.linalg.norm(self.thighs, axis=-1) + np.linalg.norm(self.shins, axis=-1)


def legs_of(rig: Rig, places: FloatArray) -> Legs:
    """Legs of joint positions (N, J, 3)."""
    hips, knees, ankles = (places[:, list(pair)] for pair in (rig.biped.hips, rig.biped.knees, rig.biped.ankles))
    return Legs(hips=hips, thighs=knees - hips, shins=ankles - knees)


def lowering(poses: WorldPoses, source: Legs, target: Legs, *, ankles: FloatArray) -> FloatArray:
    """How far the target's pelvis is lowered so that the feet on the ground are within reach [m], shape (N,).

    Args:
        poses: The source's clips.
        source: Their legs.
        target: Legs of the character as it takes over the clips.
        ankles: Where its ankles have to be [m], shape (N, 2, 3).
    """
    stretched = np.linalg.norm(source.thighs + source.shins, axis=-1) / source.lengths
    longest = target.lengths * np.maximum(stretched, REACH)
    offsets = target.hips - ankles
    level = np.sum(offsets[..., [0, 2]] ** 2, axis=-1)
    needed = np.clip(offsets[..., 1] - np.sqrt(np.maximum(longest**2 - level, 0.0)), 0.0, DEEPEST * target.lengths)
    drops = []
    for world, own in zip(poses.worlds, poses.samples, strict=True):
        stands = np.stack([grounded(world.clip.times, world.contacts[side]) for side in (0, 1)], axis=1)
        drops.append(_eased_maximum(np.where(stands, needed[own], 0.0).max(axis=1), round(AHEAD * world.clip.rate)))
    return np.concatenate(drops)


def _eased_maximum(values: FloatArray, reach: int) -> FloatArray:
    """A smooth curve over values (T,), nowhere below them.

    The mean over a window of maxima over the same window is no less than what lies in its middle.
    """
    reach = max(1, reach)
    highest = maximum_filter1d(values, 2 * reach + 1, mode="nearest")
    return gaussian_filter1d(highest, 0.5 * reach, mode="nearest", truncate=reach / (0.5 * reach))
