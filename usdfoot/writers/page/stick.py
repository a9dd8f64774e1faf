"""Which joints of a skeleton make a stick figure."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton, forward_kinematics
from usdfoot.writers.page.pictures import StickFigure

__all__ = ["stick_figure"]

SMALLEST = 0.2
"""Limbs that reach less far from the joint they hang on, in leg lengths, are not drawn: fingers, toes, face."""
BODY = 2
"""Side of joints that are in neither leg."""


def stick_figure(skeleton: Skeleton, biped: Biped) -> StickFigure:
    """The pelvis and the joints below it, without small ones; legs and head are always among them."""
    positions, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    above = [_ancestors(skeleton, joint) for joint in range(len(skeleton.joints))]
    reach = np.zeros(len(skeleton.joints))
    for joint, ancestors in enumerate(above):
        for child, parent in pairwise(ancestors):
            reach[child] = max(reach[child], float(np.linalg.norm(positions[joint] - positions[parent])))
    feet = positions[list(biped.balls)] - positions[list(biped.ankles)]
    legs = [set(skeleton.chain(biped.pelvis, ball)) for ball in biped.balls]
    head = _head(skeleton, above, biped.pelvis)
    needed = legs[0] | legs[1] | (set(above[head]) if head >= 0 else set())
    large = reach >= SMALLEST * biped.nominal_leg_length
    below = [joint for joint, ancestors in enumerate(above) if biped.pelvis in ancestors]
    kept = [biped.pelvis, *(joint for joint in below if joint != biped.pelvis and (large[joint] or joint in needed))]
    sides = [next((side for side in (0, 1) if biped.hips[side] in above[joint]), BODY) for joint in kept]
    return StickFigure(
        joints=tuple(kept),
        parents=(-1, *(kept.index(int(skeleton.parents[joint])) for joint in kept[1:])),
        sides=tuple(sides),
        head=kept.index(head) if head >= 0 else -1,
        leg_length=float(biped.nominal_leg_length),
        foot_length=float(np.linalg.norm(feet, axis=1).mean()),
    )


def _ancestors(skeleton: Skeleton, joint: int) -> list[int]:
    """The joint, its parent, the parent's parent and so on."""
    way = [joint]
    while skeleton.parents[way[-1]] >= 0:
        way.append(int(skeleton.parents[way[-1]]))
    return way


def _head(skeleton: Skeleton, above: list[list[int]], pelvis: int) -> int:
    """The joint named head that is nearest to the pelvis, -1 without any."""
    named = [
        joint
        for joint, path in enumerate(skeleton.joints)
        if "head" in path.rsplit("/", 1)[-1].lower() and pelvis in above[joint]
    ]
    return min(named, key=lambda joint: len(above[joint]), default=-1)
