"""Gaps: what one rig has and the other has not."""

from __future__ import annotations

from usdfoot.analysis.body import Arm
from usdfoot.analysis.joint_words import ancestors, is_helper
from usdfoot.model.biped import SIDES
from usdfoot.retarget.counterparts import find_counterparts
from usdfoot.retarget.rig import Rig

__all__ = ["find_gaps"]

MOST_NAMES = 10


def find_gaps(source: Rig, target: Rig) -> tuple[str, ...]:
    """Sentences about the source's parts that move nothing, and the target's joints that keep their rest pose."""
    parts = zip(_parts(source).items(), _parts(target).values(), strict=True)
    lost = [part for (part, own), other in parts if own and not other]
    moved = {joint for counterparts in find_counterparts(source, target) for joint in counterparts}
    for own, other in zip(_parts(source).values(), _parts(target).values(), strict=True):
        moved |= set(other) if own else set()
    still = [
        joint.rsplit("/", 1)[-1]
        for index, joint in enumerate(target.skeleton.joints)
        if index not in moved
        and not is_helper(joint)
        and target.biped.pelvis in ancestors(target.skeleton.parents, index)
    ]
    sentences = []
    if lost:
        sentences.append(f"{target.skeleton.name} has no {_listed(lost)}: what the clips do with it is lost")
    if still:
        sentences.append(
            f"{_listed(still)} of {target.skeleton.name} keep the rest pose: {source.skeleton.name} lacks them"
        )
    return tuple(sentences)


def _parts(rig: Rig) -> dict[str, tuple[int, ...]]:
    """Joints of each part of the body above the legs that is there."""
    parts = {"trunk": rig.body.trunk, "neck and head": rig.body.neck}
    for side, arm in zip(SIDES, rig.body.arms, strict=True):
        parts |= {f"{side} {part}": joints for part, joints in _arm_parts(arm).items()}
    return parts


def _arm_parts(arm: Arm | None) -> dict[str, tuple[int, ...]]:
    if arm is None:
        return {"collar": (), "arm": (), "hand": ()}
    return {"collar": arm.collar, "arm": (arm.upper, arm.lower), "hand": () if arm.hand is None else (arm.hand,)}


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return ", ".join(names[:MOST_NAMES]) + more
