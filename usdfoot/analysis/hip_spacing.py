"""Hip spacing: how far apart the hips are, and a body with narrower or wider ones ([P] 2.2, 3)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = ["hip_width", "space_hips"]


def hip_width(skeleton: Skeleton, biped: Biped) -> float:
    """Between the hip joints in the rest pose [m]."""
    places, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    return float(np.linalg.norm(places[biped.hips[0]] - places[biped.hips[1]]))


def space_hips(skeleton: Skeleton, biped: Biped, factor: float) -> Skeleton:
    """The skeleton with its hip joints `factor` times as far from each other, both moved from the middle between them.

    The legs below go with them; nothing else moves.
    """
    places, turns = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    hips = np.array(biped.hips)
    moved = (factor - 1.0) * (places[hips] - places[hips].mean(axis=0))
    translations = skeleton.rest_translations.copy()
    translations[hips] += quaternion.rotate(quaternion.inverse(turns[skeleton.parents[hips]]), moved)
    return replace(skeleton, rest_translations=translations)
