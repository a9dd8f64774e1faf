"""Other legs: what stands on the ground at rest beside the two legs of a biped, as quadrupeds have it."""

from __future__ import annotations

import numpy as np

from usdfoot.analysis.joint_pairs import joint_pairs
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = ["find_other_feet"]

LOW = 0.15
"""Feet of other legs end at most this part of the leg above the lowest joint of the two."""
APART = 0.6
"""They stand at least this part of the leg from both feet; skirts and capes hang nearer."""
LONG = 0.4
"""They hang at least this part of the leg below the joint on the body's middle."""


def find_other_feet(skeleton: Skeleton, biped: Biped) -> tuple[int, ...]:
    """The last joints of limbs other than the two legs that reach down to where these stand at rest, in pairs.

    Args:
        skeleton: The character's, upright.
        biped: Its two legs.
    """
    places, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    above = [{joint, *skeleton.ancestors(joint)} for joint in range(len(skeleton.joints))]
    own = [not chain.isdisjoint(biped.hips) for chain in above]
    ground, leg = places[own, 1].min(), biped.maximal_leg_length
    partners, balls = joint_pairs(skeleton, biped), places[list(biped.balls)]
    found = []
    for joint in np.setdiff1d(np.arange(len(own)), skeleton.parents).tolist():
        apart = np.linalg.norm((places[joint] - balls)[:, [0, 2]], axis=1).min()
        middle = [place for place in above[joint] if partners[place] == place]
        if own[joint] or partners[joint] == joint or not middle or apart < APART * leg:
            continue
        hangs = places[max(middle, key=lambda place: len(above[place])), 1] - places[joint, 1]
        if places[joint, 1] - ground < LOW * leg and hangs > LONG * leg:
            found.append(joint)
    return tuple(found)
