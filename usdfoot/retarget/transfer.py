"""Transfer: the rotations of a source's joints as those of a target's, in the world."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.retarget.frames import Frames
from usdfoot.retarget.rig import Rig

__all__ = ["pose_target", "transfer_rotations"]


def transfer_rotations(
    source: Rig, target: Rig, frames: tuple[Frames, Frames], turns: FloatArray
) -> dict[int, FloatArray]:
    """World rotations of the target's joints, by joint, shape (N, 4).

    Joints of legs and arms take over those of their counterparts. Joints of trunk, neck and collars take over what lies
    at their part of the chain's length, so that chains of different length bend alike.

    Args:
        source: Rig of the clips.
        target: Rig of the character.
        frames: Anatomical frames of both.
        turns: World rotations of the source's joints, shape (N, J, 4).
    """
    bodies = source.body, target.body
    meaning = {joint: quaternion.compose(turns[:, joint], frame) for joint, frame in frames[0].items()}
    pelvis = meaning[source.biped.pelvis]
    wanted = {target.biped.pelvis: pelvis}
    chest = meaning[bodies[0].trunk[-1]] if bodies[0].trunk else pelvis
    chains = [(bodies[0].trunk, bodies[1].trunk, pelvis), (bodies[0].neck, bodies[1].neck, chest)]
    bases = [(source.biped.pelvis, target.biped.pelvis), _chests(source, target)]
    for side in (0, 1):
        for pair in ("hips", "knees", "ankles", "balls"):
            wanted[getattr(target.biped, pair)[side]] = meaning[getattr(source.biped, pair)[side]]
        arms = bodies[0].arms[side], bodies[1].arms[side]
        if arms[0] is not None and arms[1] is not None:
            wanted |= {arms[1].upper: meaning[arms[0].upper], arms[1].lower: meaning[arms[0].lower]}
            if arms[0].hand is not None and arms[1].hand is not None:
                wanted[arms[1].hand] = meaning[arms[0].hand]
            chains.append((arms[0].collar, arms[1].collar, chest))
            bases.append(_chests(source, target))
    for (own, other, base), (start, other_start) in zip(chains, bases, strict=True):
        places = _places_along(source, own, start), _places_along(target, other, other_start)
        nodes = [base, *(meaning[joint] for joint in own)]
        if own:
            wanted |= dict(zip(other, _spread(np.concatenate([[0.0], places[0]]), nodes, places[1]), strict=True))
    return {
        joint: quaternion.compose(rotation, quaternion.inverse(frames[1][joint])) for joint, rotation in wanted.items()
    }


def _chests(source: Rig, target: Rig) -> tuple[int, int]:
    """The joints that carry neck and arms."""
    first, second = (rig.body.trunk[-1] if rig.body.trunk else rig.biped.pelvis for rig in (source, target))
    return first, second


def _places_along(rig: Rig, chain: Sequence[int], start: int) -> FloatArray:
    """How far along its chain each joint lies, by length, the last one at 1; shape (K,)."""
    places = rig.reference.places[[start, *chain]]
    lengths = np.cumsum(np.linalg.norm(np.diff(places, axis=0), axis=1))
    return lengths / lengths[-1] if len(chain) and lengths[-1] > 1e-9 else np.ones(len(chain))


def _spread(places: FloatArray, nodes: Sequence[FloatArray], wanted: FloatArray) -> list[FloatArray]:
    """Rotations (N, 4) at places (M,) of a chain on which they are known at places (K,), increasing."""
    found = []
    for place in wanted:
        before = min(int(np.searchsorted(places, place + 1e-9, side="right")) - 1, len(places) - 1)
        after = min(before + 1, len(places) - 1)
        fraction = (place - places[before]) / max(places[after] - places[before], 1e-9)
        if fraction < 1e-6:
            found.append(nodes[before])
        else:
            found.append(quaternion.slerp(nodes[before], nodes[after], np.array(fraction)))
    return found


def pose_target(
    target: Rig, wanted: dict[int, FloatArray], pelvis: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The target posed: joint-local rotations (N, J, 4), world positions [m] (N, J, 3) and rotations (N, J, 4).

    Joints without a wanted rotation keep the rest pose.

    Args:
        target: Rig of the character.
        wanted: World rotations by joint, shape (N, 4).
        pelvis: Pelvis joint in the world [m], shape (N, 3).
    """
    skeleton = target.skeleton
    local = np.repeat(skeleton.rest_rotations[None], len(pelvis), axis=0)
    places = np.repeat(skeleton.rest_translations[None], len(pelvis), axis=0)
    turns = local.copy()
    for joint, parent in enumerate(skeleton.parents.tolist()):
        above = turns[:, parent] if parent >= 0 else None
        if joint in wanted:
            turns[:, joint] = wanted[joint]
            undo = np.array([0.0, 0.0, 0.0, 1.0]) if above is None else quaternion.inverse(above)
            local[:, joint] = quaternion.compose(undo, wanted[joint])
        elif above is not None:
            turns[:, joint] = quaternion.compose(above, local[:, joint])
        if joint == target.biped.pelvis:
            places[:, joint] = pelvis
        elif above is not None:
            places[:, joint] = places[:, parent] + quaternion.rotate(above, places[:, joint])
    return local, places, turns
