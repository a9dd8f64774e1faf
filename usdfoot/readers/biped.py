"""Bipeds: what UsdfootBipedAPI authors, the rest from names, shape and skin."""

from __future__ import annotations

import logging

import numpy as np
from pxr import Usd

from usdfoot.analysis.biped import find_biped, make_biped
from usdfoot.analysis.biped_names import LEG_ROLES
from usdfoot.analysis.feet import ball_height_of_foot
from usdfoot.bridge.similarity import Similarity
from usdfoot.bridge.tokens import Biped as Token
from usdfoot.errors import BipedError
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import SIDES, Biped
from usdfoot.model.skeleton import Skeleton
from usdfoot.readers.authored import authored
from usdfoot.readers.joints import leaf_name
from usdfoot.readers.skeleton import RawSkeleton
from usdfoot.readers.skins import Skin, points_moved_by

__all__ = ["has_legs", "read_biped"]

_logger = logging.getLogger(__name__)

_ROLE_TOKENS = {"hip": Token.HIP, "knee": Token.KNEE, "ankle": Token.ANKLE, "ball": Token.BALL}


def read_biped(
    prim: Usd.Prim, raw: RawSkeleton, skeleton: Skeleton, *, skeleton_to_agent: Similarity, skin: Skin
) -> Biped:
    """The biped of a Skeleton in canonical space.

    Args:
        prim: The Skeleton, with or without UsdfootBipedAPI.
        raw: As it stands in USD.
        skeleton: Canonical.
        skeleton_to_agent: From one to the other.
        skin: Of the character; tells the height of the balls above the soles.

    Raises:
        BipedError: If a token names no joint, roles are missing, or a measure is not positive or not finite.
    """
    roles = find_biped(skeleton, _authored_roles(prim, raw))
    measures = _skin_measures(roles, raw, skeleton_to_agent, skin) | _authored_measures(prim, skeleton_to_agent)
    named = ", ".join(f"{role} = {leaf_name(skeleton.joints[joint])}" for role, joint in roles.items())
    _logger.info("%s: %s", prim.GetPath(), named)
    return make_biped(skeleton, roles, measures)


def has_legs(prim: Usd.Prim, raw: RawSkeleton, skeleton: Skeleton) -> bool:
    """Whether all roles of a biped are authored or found on a Skeleton; arguments as of `read_biped`."""
    try:
        find_biped(skeleton, _authored_roles(prim, raw))
    except BipedError:
        return False
    return True


def _authored_roles(prim: Usd.Prim, raw: RawSkeleton) -> dict[str, int]:
    tokens = {"pelvis": Token.PELVIS}
    tokens |= {f"{name} {role}": _ROLE_TOKENS[role][side] for side, name in enumerate(SIDES) for role in LEG_ROLES}
    values = {role: (name, authored(prim, name)) for role, name in tokens.items()}
    return {role: _joint_index(prim, name, str(value), raw) for role, (name, value) in values.items() if value}


def _joint_index(prim: Usd.Prim, attribute: str, token: str, raw: RawSkeleton) -> int:
    """Index of the joint a token names: the full path, or the leaf name where that is unique."""
    if token in raw.joints:
        return raw.joints.index(token)
    found = [i for i, joint in enumerate(raw.joints) if leaf_name(joint) == leaf_name(token)]
    if len(found) == 1 and leaf_name(token) == token:
        return found[0]
    names = f"is the name of {len(found)} joints" if found else "is none of the joints"
    raise BipedError(
        prim.GetPath(),
        f"{attribute} = {token} {names}",
        "author a joint path of this Skeleton or a leaf name that is unique",
        [raw.joints[i] for i in found] or [leaf_name(joint) for joint in raw.joints],
    )


def _authored_measures(prim: Usd.Prim, skeleton_to_agent: Similarity) -> dict[str, float | FloatArray]:
    """Authored lengths, which are in the Skeleton's own space, in metres."""
    names = {f"ball_height:{side}": Token.BALL_HEIGHT[i] for i, side in enumerate(SIDES)}
    names |= {"nominal": Token.LEG_LENGTH_NOMINAL, "maximal": Token.LEG_LENGTH_MAX}
    measures: dict[str, float | FloatArray] = {}
    for measure, name in names.items():
        value = authored(prim, name)
        if value is not None and not (np.isfinite(value) and value > 0.0):
            raise BipedError(prim.GetPath(), f"{name} is {value:g}", "author a positive length, or none")
        if value is not None:
            measures[measure] = float(value) * skeleton_to_agent.scale
    com = authored(prim, Token.COM)
    if com is not None:
        if not np.isfinite(np.array(com)).all():
            raise BipedError(prim.GetPath(), f"{Token.COM} is {com}", "author a finite point, or none")
        turned = quaternion.rotate(skeleton_to_agent.rotation[0], np.array(com, dtype=float))
        measures["com"] = turned * skeleton_to_agent.scale
    return measures


def _skin_measures(
    roles: dict[str, int], raw: RawSkeleton, skeleton_to_agent: Similarity, skin: Skin
) -> dict[str, float | FloatArray]:
    """Heights of the balls above the soles of the skin in the bind pose [m], the mean of both feet."""
    if raw.bind_matrices is None or not len(skin.points):
        return {}
    origins = _turned(raw.bind_matrices[:, 3, :3], skeleton_to_agent)
    heights = []
    for side in SIDES:
        foot = _subtree(raw, roles[f"{side} ankle"])
        points = _turned(points_moved_by(skin, foot), skeleton_to_agent)
        heights.append(ball_height_of_foot(points, origins[roles[f"{side} ankle"]], origins[roles[f"{side} ball"]]))
    measured = [height for height in heights if height is not None]
    return {f"ball_height:{side}": float(np.mean(measured)) for side in SIDES} if measured else {}


def _turned(points: FloatArray, similarity: Similarity) -> FloatArray:
    return similarity.scale * quaternion.rotate(similarity.rotation[0], points) + similarity.translation[0]


def _subtree(raw: RawSkeleton, joint: int) -> list[int]:
    """A joint and all below it."""
    below = [joint]
    for index, parent in enumerate(raw.parents):
        if parent in below:
            below.append(index)
    return below
