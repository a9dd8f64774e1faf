"""Finds the legs of a skeleton and measures what was not authored."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from usdfoot.analysis.biped_names import LEG_ROLES, is_pelvis, leg_by_names
from usdfoot.analysis.biped_shape import legs_by_shape, reaching_child
from usdfoot.analysis.joint_words import is_end, is_helper
from usdfoot.errors import BipedError, SkeletonError
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import SIDES, Biped
from usdfoot.model.skeleton import Skeleton, forward_kinematics

__all__ = ["BALL_HEIGHT", "BALL_HEIGHTS", "BipedMeasures", "default_ball_heights", "find_biped", "make_biped"]

COM_ABOVE_HIPS = 0.055
"""Height of the standing body's centre of mass above the hip joints, as a fraction of the leg: 0.557 and 0.530 of the
stature (Palmer 1944; Winter 2009, Figure 4.1), legs from hip to ankle being 0.491 of it."""
NOMINAL_LEG = 0.95
"""Comfortable leg length as a fraction of the straight leg ([P] 2.2)."""
BALL_HEIGHT = 0.33
"""Height of the ball joint above the sole as a fraction of the distance from ankle to ball, where nothing tells more;
that of the mocap skeletons of CMU (0.32) and Bandai Namco (0.36)."""

BALL_HEIGHTS = (0.02, 0.6)
"""Between these fractions of that distance a ball joint above the origin's plane may be that of a foot that stands."""

TRUNK_HEIGHT = 0.2
"""Joints higher above the hips than this part of the hips' height are of the trunk or hang on it."""

LIKE_BONES = 2.5
"""Lengths of legs that differ from their bones by more than this factor are in other units: an inch has 2.54 cm."""

BipedMeasures = Mapping[str, float | FloatArray]
"""Authored measures in canonical space: ball_height:left, ball_height:right, com, nominal, maximal."""


def find_biped(skeleton: Skeleton, authored: Mapping[str, int]) -> dict[str, int]:
    """Joint index by role: "pelvis", "left hip", "left knee" and so on.

    Authored joints count first, then names, then the shape of the rest pose. A ball joint that no name tells is the
    joint below the ankle that reaches farthest. The pelvis is the lowest joint above both hips, or the next one above
    it whose name says so: 3ds Max hangs the thighs below the first joint of the spine. One that carries the legs alone,
    as Daz and Character Creator have it beside the spine, leaves that to the joint above it.

    Args:
        skeleton: Canonical skeleton.
        authored: Joints an artist named, by role.

    Raises:
        BipedError: If no joint is below another, roles are missing, the legs share joints, or those of a leg are not
            below each other or on one spot.
    """
    if (skeleton.parents < 0).all() and len(skeleton.joints) >= 2 * len(LEG_ROLES):
        remedy = "author joints as paths from the root down, such as Hips/LeftUpLeg/LeftLeg"
        raise BipedError(skeleton.name, "none of its joints is below another", remedy)
    positions, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    legs = _legs(skeleton, authored, positions)
    roles = {f"{side} {role}": joint for side, leg in zip(SIDES, legs, strict=True) for role, joint in leg.items()}
    roles |= dict(authored)
    missing = [f"{side} {role}" for side in SIDES for role in LEG_ROLES if f"{side} {role}" not in roles]
    if not missing and "pelvis" not in roles:
        pelvis = _pelvis(skeleton, positions, (roles["left hip"], roles["right hip"]))
        if pelvis is not None:
            roles["pelvis"] = pelvis
    if "pelvis" not in roles and not missing:
        missing = ["pelvis"]
    if missing:
        raise BipedError(skeleton.name, "no joint found for the role(s)", _remedy(missing), missing)
    _check_sides(skeleton, roles)
    _check_chains(skeleton, roles, positions)
    return roles


def make_biped(skeleton: Skeleton, roles: Mapping[str, int], measures: BipedMeasures) -> Biped:
    """The biped with the measures given, and proportions of the rest pose for those that are not.

    Args:
        skeleton: Canonical skeleton.
        roles: Joint index by role, all of them.
        measures: Authored or measured values, canonical.

    Raises:
        BipedError: If the balls are higher above the soles than the legs are long, or the lengths of legs are in other
            units than the bones.
    """
    positions, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    leg = positions[[[roles[f"{side} {role}"] for role in LEG_ROLES] for side in SIDES]]  # (2, 4, 3)
    bones = np.linalg.norm(np.diff(leg, axis=1), axis=-1)
    straight = float(bones[:, :2].sum(axis=1).mean())
    maximal = float(measures.get("maximal", straight))
    above_hips = leg[:, 0].mean(axis=0) + (0.0, COM_ABOVE_HIPS * straight, 0.0)
    com = np.asarray(measures.get("com", above_hips - positions[roles["pelvis"]]), dtype=float)
    defaults = default_ball_heights(leg)
    heights = [float(measures.get(f"ball_height:{side}", defaults[i])) for i, side in enumerate(SIDES)]
    if max(heights) > straight:
        what = f"its balls are {max(heights):.3g} m above the soles, its legs {straight:.3g} m long"
        remedy = "author usdfoot:biped:left:ballHeight and :right in the Skeleton's own units, or none"
        raise BipedError(skeleton.name, what, remedy)
    nominal = float(measures.get("nominal", NOMINAL_LEG * maximal))
    for name, length in (("max", maximal), ("nominal", nominal)):
        if not straight / LIKE_BONES <= length <= straight * LIKE_BONES:
            what = f"usdfoot:biped:legLength:{name} says {length:.3g} m, the bones of its legs are {straight:.3g} m"
            raise BipedError(skeleton.name, what, "author it in the Skeleton's own units, or none")
    pairs = {role: (roles[f"left {role}"], roles[f"right {role}"]) for role in LEG_ROLES}
    return Biped(
        pelvis=roles["pelvis"],
        hips=pairs["hip"],
        knees=pairs["knee"],
        ankles=pairs["ankle"],
        balls=pairs["ball"],
        ball_heights=np.array(heights),
        com=com,
        nominal_leg_length=nominal,
        maximal_leg_length=maximal,
    )


def default_ball_heights(leg: FloatArray) -> FloatArray:
    """Height of the ball joints above the sole where there is no skin to measure [m], shape (2,).

    If the rest pose stands on the origin's plane it is the joints' height there, both feet's mean; else a fraction of
    the distance from ankle to ball.

    Args:
        leg: Rest positions of hip, knee, ankle and ball of both legs [m], shape (2, 4, 3).
    """
    feet = np.linalg.norm(leg[:, 3] - leg[:, 2], axis=-1)
    heights = leg[:, 3, 1]
    stands = np.all((heights > BALL_HEIGHTS[0] * feet) & (heights < BALL_HEIGHTS[1] * feet) & (leg[:, 2, 1] > heights))
    level = abs(heights[0] - heights[1]) < 0.1 * feet.mean()
    return np.full(2, heights.mean() if stands and level else BALL_HEIGHT * feet.mean())


def _legs(
    skeleton: Skeleton, authored: Mapping[str, int], positions: FloatArray
) -> tuple[dict[str, int], dict[str, int]]:
    fixed = [{role: authored[f"{side} {role}"] for role in LEG_ROLES if f"{side} {role}" in authored} for side in SIDES]
    if all(len(leg) == len(LEG_ROLES) for leg in fixed):
        return fixed[0], fixed[1]
    named = [leg_by_names(skeleton.joints, skeleton.parents, side, fixed=fixed[side]) for side in (0, 1)]
    left, right = named[0], named[1]
    if left is None or right is None:
        shaped = legs_by_shape(skeleton.parents, positions)
        legs = shaped or (left or {}, right or {})
        return legs[0] | fixed[0], legs[1] | fixed[1]
    for leg in (left, right):
        ball = _reaching_child(skeleton, leg["ankle"], positions)
        if "ball" not in leg and ball is not None:
            leg["ball"] = ball
    return left, right


def _reaching_child(skeleton: Skeleton, ankle: int, positions: FloatArray) -> int | None:
    """The child of the ankle that is a bone and leads farthest, else the foot's own end; None if there is neither."""
    below = np.flatnonzero(skeleton.parents == ankle).tolist()
    bones = [joint for joint in below if not is_helper(skeleton.joints[joint])]
    ends = [joint for joint in below if is_end(skeleton.joints[joint])]
    return reaching_child(skeleton.parents, positions, ankle, children=bones or ends)


def _pelvis(skeleton: Skeleton, positions: FloatArray, hips: tuple[int, int]) -> int | None:
    """The lowest joint above both hips, or the lowest above that which is named as a pelvis; None without any."""
    first, second = (skeleton.ancestors(hip) for hip in hips)
    common = [joint for joint in first if joint in second]
    named = [joint for joint in common if is_pelvis(skeleton.joints[joint])]
    likely = [*named, *common]
    carrying = [joint for joint in named if _carries_trunk(skeleton, positions, joint, hips)]
    return next(iter([*carrying, *likely]), None)


def _carries_trunk(skeleton: Skeleton, positions: FloatArray, joint: int, hips: tuple[int, int]) -> bool:
    """Whether more hangs on a joint above both hips than the legs: something that reaches above the hips."""
    height = positions[list(hips), 1].mean()
    least = height + TRUNK_HEIGHT * (height - positions[:, 1].min())
    high = np.flatnonzero(positions[:, 1] > least)
    return any(joint in skeleton.ancestors(int(other)) for other in high)


def _check_sides(skeleton: Skeleton, roles: Mapping[str, int]) -> None:
    for role in LEG_ROLES:
        left, right = (roles[f"{side} {role}"] for side in SIDES)
        if left == right:
            what = f"left and right {role} are the same joint: {skeleton.joints[left]}"
            raise BipedError(skeleton.name, what, "author a joint of each leg, usdfoot:biped:left and :right")


def _check_chains(skeleton: Skeleton, roles: Mapping[str, int], positions: FloatArray) -> None:
    for side in SIDES:
        way = [roles["pelvis"], *(roles[f"{side} {role}"] for role in LEG_ROLES)]
        for above, below in pairwise(way):
            try:
                chained = above != below and bool(skeleton.chain(above, below))
            except SkeletonError:
                chained = False
            if not chained:
                raise BipedError(
                    skeleton.name,
                    f"{side} leg: joint {skeleton.joints[below]} is not below {skeleton.joints[above]}",
                    "pelvis, hip, knee, ankle and ball must follow each other down the hierarchy",
                )
        for above, below in pairwise(way[1:]):
            if not np.linalg.norm(positions[below] - positions[above]) > 0.0:
                raise BipedError(
                    skeleton.name,
                    f"{side} leg: joints {skeleton.joints[above]} and {skeleton.joints[below]} are on one spot at rest",
                    "give restTransforms bones their lengths, or author UsdfootBipedAPI joints that are apart",
                )


def _remedy(missing: list[str]) -> str:
    role = missing[0].replace(" ", ":")
    adding = "add a joint at the ball of each foot, or " if missing[0].endswith("ball") else ""
    return adding + (
        "apply UsdfootBipedAPI to the Skeleton and author the joints by name, for example "
        f'uniform token usdfoot:biped:{role} = "<joint>"'
    )
