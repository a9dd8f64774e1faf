"""Counterparts: joints of two rigs that play the same part without being of trunk, neck or collars."""

from __future__ import annotations

from usdfoot.analysis.joint_words import words_of
from usdfoot.retarget.rig import Rig

__all__ = ["find_counterparts"]


def find_counterparts(source: Rig, target: Rig) -> tuple[dict[int, int], dict[int, int]]:
    """The source's joint for each joint of the target: those of legs and arms, and those below them by name.

    Joints of equal names correspond where the joints they hang on do: fingers, eyes, props. Trunk, neck and collars are
    chains, which correspond as a whole; what hangs on chest and head corresponds nevertheless.
    """
    limbs = {target.biped.pelvis: source.biped.pelvis}
    for name in ("hips", "knees", "ankles", "balls"):
        limbs |= dict(zip(getattr(target.biped, name), getattr(source.biped, name), strict=True))
    for own, other in zip(source.body.arms, target.body.arms, strict=True):
        if own is not None and other is not None:
            limbs |= {other.upper: own.upper, other.lower: own.lower}
            if own.hand is not None and other.hand is not None:
                limbs[other.hand] = own.hand
    known = dict(limbs)
    for chain, others in ((source.body.trunk, target.body.trunk), (source.body.neck, target.body.neck)):
        if chain and others:
            known[others[-1]] = chain[-1]
    mapped = source.body.mapped | set(limbs.values()), target.body.mapped | set(limbs)
    names = {
        (int(parent), tuple(words_of(joint))): index
        for index, (joint, parent) in enumerate(zip(source.skeleton.joints, source.skeleton.parents, strict=True))
        if index not in mapped[0]
    }
    named = {}
    for index, (joint, parent) in enumerate(zip(target.skeleton.joints, target.skeleton.parents.tolist(), strict=True)):
        partner = names.get((known[parent], tuple(words_of(joint)))) if parent in known else None
        if partner is not None and index not in mapped[1]:
            known[index] = named[index] = partner
    return limbs, named
