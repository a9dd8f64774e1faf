"""Bones: the hierarchy in a motion capture file, and the skeleton it becomes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from usdfoot.analysis.biped import find_biped
from usdfoot.errors import BipedError, ClipError
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import SIDES
from usdfoot.model.capture import Capture
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton

__all__ = ["Bones", "bone_clip", "bone_skeleton", "euler_rotations", "joint_paths", "upright", "with_ball_ends"]

Z_UP = np.array([-np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])
"""Turns axes with +Z up and -Y ahead into canonical ones."""


@dataclass(frozen=True, kw_only=True)
class Bones:
    """Joints of a file, parents before children, without rotations: all of them are zero in the file's own pose."""

    names: tuple[str, ...]
    """As the file has them, J of them."""
    parents: tuple[int, ...]
    """Index of each joint's parent, -1 for the root."""
    offsets: FloatArray
    """From the parent [m], shape (J, 3)."""
    ends: Mapping[int, FloatArray]
    """Where bones end on which nothing hangs, from their joint [m], by joint."""


def joint_paths(names: Sequence[str], parents: Sequence[int]) -> tuple[str, ...]:
    """Joint paths as USD has them, of names as other programs have them.

    Namespaces ("mixamorig:") are left out, what is no letter, digit or underscore becomes an underscore, and a name
    that its parent has given to a child already gets a number.
    """
    paths: list[str] = []
    taken: set[str] = set()
    for name, parent in zip(names, parents, strict=True):
        leaf = re.sub(r"\W+", "_", name.rpartition(":")[2].strip()) or "joint"
        leaf = f"_{leaf}" if leaf[0].isdigit() else leaf
        above = f"{paths[parent]}/" if parent >= 0 else ""
        path, number = above + leaf, 1
        while path in taken:
            path, number = f"{above}{leaf}_{number}", number + 1
        taken.add(path)
        paths.append(path)
    return tuple(paths)


def bone_skeleton(where: str, bones: Bones) -> Skeleton:
    """The skeleton in the file's own pose."""
    rotations = np.tile([0.0, 0.0, 0.0, 1.0], (len(bones.names), 1))
    return Skeleton(
        name=where,
        joints=joint_paths(bones.names, bones.parents),
        parents=np.array(bones.parents, dtype=int),
        rest_translations=bones.offsets,
        rest_rotations=rotations,
    )


def bone_clip(skeleton: Skeleton, clip: Clip) -> Clip:
    """The clip with still samples for the joints at the end of the skeleton that it lacks."""
    frames, joints = clip.rotations.shape[:2]
    translations = np.tile(skeleton.rest_translations[joints:], (frames, 1, 1))
    rotations = np.tile(skeleton.rest_rotations[joints:], (frames, 1, 1))
    return replace(
        clip,
        translations=np.concatenate([clip.translations, translations], axis=1),
        rotations=np.concatenate([clip.rotations, rotations], axis=1),
    )


def with_ball_ends(where: str, bones: Bones) -> Bones:
    """The bones, with the ends of the feet as joints where no joint is the ball of a foot.

    Every foot needs a ball joint; in many BVH files it is only the end of the bone that begins at the ankle. The ends
    of hands, head and toes are left out.
    """
    if _legs(where, bones) is not None:
        return bones
    chosen = [joint for joint, offset in bones.ends.items() if np.linalg.norm(offset) > 0.0]
    longer = _with_ends(bones, chosen)
    roles = _legs(where, longer)
    if roles is None:
        return bones
    count = len(bones.names)
    balls = {roles[f"{side} ball"] for side in SIDES}
    return _with_ends(bones, [joint for i, joint in enumerate(chosen) if count + i in balls])


def _with_ends(bones: Bones, joints: Sequence[int]) -> Bones:
    """Bones with joints at the ends of some."""
    if not joints:
        return bones
    return Bones(
        names=(*bones.names, *(f"{bones.names[joint]}_Toe" for joint in joints)),
        parents=(*bones.parents, *joints),
        offsets=np.concatenate([bones.offsets, np.array([bones.ends[joint] for joint in joints])]),
        ends={},
    )


def _legs(where: str, bones: Bones) -> dict[str, int] | None:
    try:
        return find_biped(bone_skeleton(where, bones), {})
    except BipedError:
        return None


def upright(capture: Capture, *, up: str) -> Capture:
    """What a file with that axis up holds, now with +Y up.

    Args:
        capture: In the file's axes.
        up: Y or Z.

    Raises:
        ClipError: If there is no such axis.
    """
    if up not in ("Y", "Z"):
        raise ClipError("up", f"is {up!r}", "Y or Z is up")
    if up == "Y":
        return capture
    own = capture.skeleton
    turns = np.where(own.parents[:, None] < 0, Z_UP, [0.0, 0.0, 0.0, 1.0])
    skeleton = replace(
        own,
        rest_translations=quaternion.rotate(turns, own.rest_translations),
        rest_rotations=quaternion.compose(turns, own.rest_rotations),
    )
    clips = [
        replace(
            clip,
            translations=quaternion.rotate(turns, clip.translations),
            rotations=quaternion.continuous(quaternion.compose(turns, clip.rotations)),
        )
        for clip in capture.clips
    ]
    return replace(capture, skeleton=skeleton, clips=tuple(clips))


def euler_rotations(angles: FloatArray, axes: Sequence[int]) -> FloatArray:
    """Rotations by angles [rad] (T, K) about K axes (0 = x), the first outermost: R = R_0 R_1 ..., xyzw, (T, 4)."""
    rotations = np.tile([0.0, 0.0, 0.0, 1.0], (len(angles), 1))
    for column, axis in enumerate(axes):
        rotations = quaternion.compose(rotations, quaternion.from_axis_angle(np.eye(3)[axis], angles[:, column]))
    return rotations
