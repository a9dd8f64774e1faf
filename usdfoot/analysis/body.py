"""Body: a biped's trunk, neck, arms and tail, found by the names of joints and, where these say nothing, by shape."""

from __future__ import annotations

from dataclasses import dataclass

from usdfoot.analysis.arm_names import ARM_ROLES, arm_by_names, is_head, is_neck
from usdfoot.analysis.joint_words import ancestors
from usdfoot.analysis.limbs import Limbs, find_limbs
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Skeleton

__all__ = ["Arm", "Body", "find_body"]


@dataclass(frozen=True, kw_only=True)
class Arm:
    """Joints of one arm."""

    collar: tuple[int, ...]
    """From the trunk outward up to the upper arm, without it; none where the upper arm hangs on the trunk itself."""
    upper: int
    lower: int
    hand: int | None
    """Where the lower arm ends; None where the skeleton does."""

    @property
    def end(self) -> int:
        """The last joint of the arm."""
        return self.lower if self.hand is None else self.hand


@dataclass(frozen=True, kw_only=True)
class Body:
    """Chains of joints above the legs, each from the pelvis outward."""

    trunk: tuple[int, ...]
    """Above the pelvis up to the chest, which carries neck and arms."""
    neck: tuple[int, ...]
    """Above the chest up to the head, which is the last one."""
    arms: tuple[Arm | None, Arm | None]
    """Left and right."""
    tail: tuple[int, ...]

    @property
    def mapped(self) -> frozenset[int]:
        """All joints that have a place in the body."""
        joints = {*self.trunk, *self.neck}
        for arm in self.arms:
            if arm is not None:
                joints |= {*arm.collar, arm.upper, arm.lower} | ({arm.hand} if arm.hand is not None else set())
        return frozenset(joints)


def find_body(skeleton: Skeleton, biped: Biped, places: FloatArray) -> Body:
    """The body of a biped.

    The chest is the last joint that both arms hang on and no name counts to the neck: 3ds Max hangs the collar bones
    on the neck.

    Args:
        skeleton: Joints.
        biped: Its legs.
        places: Positions of the joints in a pose that faces +Z [m], shape (J, 3).
    """
    shape = find_limbs(skeleton, biped, places)
    arms = [_arm_joints(skeleton, biped, shape, side) for side in (0, 1)]
    known = [arm for arm in arms if arm is not None]
    if len(known) == 2:
        above = ancestors(skeleton.parents, known[1]["upper arm"])
        branch = next(joint for joint in ancestors(skeleton.parents, known[0]["upper arm"]) if joint in above)
        way = skeleton.chain(biped.pelvis, branch)[1:]
    else:
        way = shape.spine
    names = [skeleton.joints[joint] for joint in way]
    trunk = way[: next((index for index, name in enumerate(names) if is_neck(name) or is_head(name)), len(way))]
    chest = trunk[-1] if trunk else biped.pelvis
    return Body(
        trunk=trunk,
        neck=_neck(skeleton, shape, chest),
        arms=(_arm(skeleton, arms[0], (biped.pelvis, *way)), _arm(skeleton, arms[1], (biped.pelvis, *way))),
        tail=shape.tail,
    )


def _arm_joints(skeleton: Skeleton, biped: Biped, shape: Limbs, side: int) -> dict[str, int] | None:
    """Joints of one arm below the pelvis by role: by names, else by shape."""
    named = arm_by_names(skeleton.joints, skeleton.parents, side)
    if named is not None and biped.pelvis in ancestors(skeleton.parents, named["upper arm"]):
        return named
    if shape.upper_arms is None or shape.lower_arms is None or shape.hands is None:
        return None
    joints = (shape.upper_arms[side], shape.lower_arms[side], shape.hands[side])
    if joints[0] == joints[1]:
        return None
    return dict(zip(ARM_ROLES, joints if joints[1] != joints[2] else joints[:2], strict=False))


def _arm(skeleton: Skeleton, joints: dict[str, int] | None, trunk: tuple[int, ...]) -> Arm | None:
    """The arm with its collar: what lies between the trunk and the upper arm."""
    if joints is None:
        return None
    above = ancestors(skeleton.parents, joints["upper arm"])
    collar = above[: next(index for index, joint in enumerate(above) if joint in trunk)]
    return Arm(
        collar=tuple(reversed(collar)),
        upper=joints["upper arm"],
        lower=joints["lower arm"],
        hand=joints.get("hand"),
    )


def _neck(skeleton: Skeleton, shape: Limbs, chest: int) -> tuple[int, ...]:
    """Joints from the chest, without it, to the head: the highest so named, else the longest chain in the middle."""
    heads = [
        joint
        for joint in range(len(skeleton.joints))
        if is_head(skeleton.joints[joint]) and chest in ancestors(skeleton.parents, joint)
    ]
    if heads:
        head = min(heads, key=lambda joint: len(ancestors(skeleton.parents, joint)))
        return skeleton.chain(chest, head)[1:]
    below = [joint for joint in shape.neck if chest in ancestors(skeleton.parents, joint)]
    return skeleton.chain(chest, below[-1])[1:] if below else ()
