"""Candidates: the Skeletons that may be a character's, and which of them is."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence

from pxr import Usd, UsdGeom, UsdSkel

from usdfoot.bridge.similarity import Similarity, similarity_of_matrices
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SkeletonError
from usdfoot.readers.assets import character_prim_of
from usdfoot.readers.biped import has_legs
from usdfoot.readers.skeleton import StartTransforms, read_joints, read_skeleton, skeleton_in
from usdfoot.readers.skins import inherited_target
from usdfoot.readers.stage import StagePrims

__all__ = ["find_skeleton", "only_character"]

_logger = logging.getLogger(__name__)


def find_skeleton(prim: Usd.Prim) -> Usd.Prim:
    """The Skeleton at or below a prim: the first that skins a mesh, else the first with joints.

    Of several that skin meshes, as a body, a face and hair do, the first with legs counts.

    Raises:
        SkeletonError: If there is none.
    """
    below = list(Usd.PrimRange(prim, Usd.TraverseInstanceProxies()))
    skeletons = [candidate for candidate in below if candidate.IsA(UsdSkel.Skeleton)]
    bound = {inherited_target(mesh, "skel:skeleton") for mesh in below if mesh.IsA(UsdGeom.Mesh)}
    skinned = [skeleton for skeleton in skeletons if skeleton.GetPath() in bound]
    ranked = skinned or [skeleton for skeleton in skeletons if _has_joints(skeleton)] or skeletons
    if not ranked:
        raise SkeletonError(
            prim.GetPath(),
            "has no Skeleton at or below it",
            "point usdfoot:agent:character at the prim that holds the character's SkelRoot",
        )
    return _with_legs(ranked)[0]


def only_character(prims: StagePrims, foreign: Iterable[Usd.Prim] = ()) -> Usd.Prim:
    """The character of a stage that names none: the one with skin, with legs, or the only one.

    Args:
        prims: Of the stage.
        foreign: Prims that are no part of a character: plans and terrain.

    Raises:
        SkeletonError: If there is none, or several different ones.
    """
    skeletons = [prim for prim in prims.skeletons if _has_joints(prim)]
    bound = {inherited_target(mesh, "skel:skeleton") for mesh in prims.meshes}
    candidates = [prim for prim in skeletons if prim.GetPath() in bound] or skeletons
    visible = [prim for prim in candidates if UsdGeom.Imageable(prim).ComputeVisibility() != UsdGeom.Tokens.invisible]
    candidates = _with_legs(visible or candidates)
    if not candidates:
        raise SkeletonError("stage", "has no Skeleton with joints", "add a character: a SkelRoot with a Skeleton")
    if len({_joints(prim) for prim in candidates}) > 1:
        raise SkeletonError(
            "stage",
            "has several characters",
            "apply UsdfootAgentAPI to an agent prim and point usdfoot:agent:character at one of them",
            [prim.GetPath() for prim in candidates],
        )
    if len(candidates) > 1:
        _logger.info("%d characters with the same joints, %s is used", len(candidates), candidates[0].GetPath())
    return character_prim_of(candidates[0], foreign)


def _with_legs(skeletons: Sequence[Usd.Prim]) -> list[Usd.Prim]:
    """Of skeletons with different joints those with legs, if there are some; else all."""
    differ = len({_joints(prim) for prim in skeletons}) > 1
    found = [prim for prim in skeletons if _has_legs(prim)] if differ else []
    return found or list(skeletons)


def _has_legs(prim: Usd.Prim) -> bool:
    """Whether the legs of a Skeleton are authored or found, seen as it stands on the stage."""
    stage = prim.GetStage()
    units = StageUnits(up_axis=str(UsdGeom.GetStageUpAxis(stage)))
    try:
        to_stage = similarity_of_matrices(StartTransforms(stage).matrix_of(prim)[None], prim.GetPath())
        upright = Similarity(
            scale=to_stage.scale,
            rotation=units.frames_to_canonical(to_stage.rotation),
            translation=units.directions_to_canonical(to_stage.translation),
        )
        raw = read_skeleton(prim)
        return has_legs(prim, raw, skeleton_in(raw, upright))
    except SkeletonError:
        return False


def _has_joints(prim: Usd.Prim) -> bool:
    """Whether it lists joints, or what cannot be joints: then that is said where it is read."""
    try:
        return bool(read_joints(prim))
    except SkeletonError:
        return True


def _joints(prim: Usd.Prim) -> tuple[str, ...]:
    try:
        return read_joints(prim)
    except SkeletonError:
        return ()
