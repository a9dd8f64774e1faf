"""Characters: the skinned assets that agents reference, in the agent's space."""

from __future__ import annotations

import logging

import numpy as np
from pxr import Usd, UsdGeom, UsdSkel

from usdfoot.analysis.other_legs import find_other_feet
from usdfoot.bridge.scene import BlendShapes, Character
from usdfoot.bridge.similarity import Similarity, similarity_of_matrices
from usdfoot.bridge.units import StageUnits
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Pose, Skeleton, forward_kinematics
from usdfoot.readers.assets import asset_of
from usdfoot.readers.attributes import array_at
from usdfoot.readers.biped import read_biped
from usdfoot.readers.bounds import read_bounds
from usdfoot.readers.candidates import find_skeleton
from usdfoot.readers.joints import leaf_name
from usdfoot.readers.samples import read_samples
from usdfoot.readers.skeleton import RawSkeleton, is_moving, matrices_of, read_skeleton, skeleton_in, split_matrices
from usdfoot.readers.skins import inherited_target, read_skin
from usdfoot.readers.stage import start_code

__all__ = ["character_key", "read_character"]

_logger = logging.getLogger(__name__)

_LEVEL = 1e-6
_UPRIGHT = 0.5
"""Legs that go down by less than this part of their length lie rather than stand."""


def read_character(prim: Usd.Prim, units: StageUnits, frame_codes: FloatArray) -> Character:
    """The character at or below a prim.

    Args:
        prim: The agent prim itself, or the prim its usdfoot:agent:character points at.
        units: Of the stage.
        frame_codes: Time codes of the crowd's frames, for transforms above the Skeleton that move.

    Raises:
        SkeletonError: If there is no usable Skeleton or a transform above it is no similarity.
        BipedError: If its legs are not found.
    """
    skeleton_prim = find_skeleton(prim)
    raw = read_skeleton(skeleton_prim)
    tilt, scale = _upright(prim, units)
    skeleton_to_agent = _skeleton_to_agent(prim, skeleton_prim, units, frame_codes, tilt, scale)
    skeleton = skeleton_in(raw, skeleton_to_agent)
    meshes = [mesh for mesh in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()) if mesh.IsA(UsdGeom.PointBased)]
    skin = read_skin(meshes, skeleton_prim, raw)
    asset, asset_prim, variants = asset_of(prim)
    _warn_of_size(prim, skeleton.rest_translations, asset)
    biped = read_biped(skeleton_prim, raw, skeleton, skeleton_to_agent=skeleton_to_agent, skin=skin)
    bind_pose = _bind_pose(raw, skeleton_to_agent)
    _warn_of_posture(prim, skeleton, biped, bind_pose, asset)
    _warn_of_other_legs(prim, skeleton, biped)
    return Character(
        path=str(prim.GetPath()),
        asset=asset,
        asset_prim=asset_prim,
        variants=variants,
        skeleton_path=_relative(skeleton_prim, prim),
        agent_rotation=_snapped(units.frames_to_stage(tilt)),
        agent_scale=scale,
        skeleton_to_agent=skeleton_to_agent,
        skeleton=skeleton,
        biped=biped,
        rest_scales=raw.scales,
        inherited_scales=raw.inherited_scales,
        bounds=read_bounds(
            asset, asset_prim, variants=variants, skeleton_path=_relative(skeleton_prim, prim), joints=raw.joints
        ),
        still_extent=_still_extent(prim, units, tilt, scale),
        bind_pose=bind_pose,
        blend_shapes=_blend_shapes(skeleton_prim),
    )


def character_key(prim: Usd.Prim, units: StageUnits) -> tuple[object, ...]:
    """What two prims have in common if they are the same character: asset, variants, tilt and scale."""
    tilt, scale = _upright(prim, units)
    return (asset_of(prim), tuple(np.round(_snapped(tilt), 5)), float(f"{scale:.6g}"))


def _upright(prim: Usd.Prim, units: StageUnits) -> tuple[FloatArray, float]:
    """Rotation without yaw from the prim's space to canonical axes, shape (4,), and the prim's scale in the world.

    The prim's rotation is cut into yaw after tilt (swing and twist about the up axis). The yaw only places the prim.
    """
    start = start_code(prim.GetStage()).GetValue()
    to_world = similarity_of_matrices(matrices_of(prim, np.array([start])), prim.GetPath())
    rotation = units.frames_to_canonical(to_world.rotation)[0]
    yaw = np.array([0.0, rotation[1], 0.0, rotation[3]])
    if np.linalg.norm(yaw) < _LEVEL:
        return rotation, to_world.scale
    return quaternion.compose(quaternion.inverse(quaternion.normalised(yaw)), rotation), to_world.scale


def _skeleton_to_agent(
    prim: Usd.Prim, skeleton: Usd.Prim, units: StageUnits, codes: FloatArray, tilt: FloatArray, scale: float
) -> Similarity:
    """From the Skeleton's space to the agent's, at every code if a transform between the two moves."""
    if not is_moving(skeleton, below=prim):
        codes = np.array([start_code(prim.GetStage()).GetValue()])
    to_prim = matrices_of(skeleton, codes) @ np.linalg.inv(matrices_of(prim, codes))
    upright = Similarity(scale=scale * units.meters_per_unit, rotation=tilt[None], translation=np.zeros((1, 3)))
    return upright.after(similarity_of_matrices(to_prim, skeleton.GetPath()))


def _bind_pose(raw: RawSkeleton, skeleton_to_agent: Similarity) -> Pose | None:
    """The bind pose in the agent's space."""
    if raw.bind_matrices is None:
        return None
    places, turns, _ = split_matrices(raw.bind_matrices)
    turn, shift = skeleton_to_agent.rotation[0], skeleton_to_agent.translation[0]
    return Pose(
        places=skeleton_to_agent.scale * quaternion.rotate(turn, places) + shift,
        turns=quaternion.compose(turn, turns),
    )


def _still_extent(prim: Usd.Prim, units: StageUnits, tilt: FloatArray, scale: float) -> FloatArray | None:
    """Bounds of the geometry below the prim that no joint moves, in the agent's space [m], shape (2, 3)."""
    upright = Similarity(scale=scale * units.meters_per_unit, rotation=tilt[None], translation=np.zeros((1, 3)))
    purposes = [UsdGeom.Tokens.default_, UsdGeom.Tokens.render, UsdGeom.Tokens.proxy]
    cache = UsdGeom.BBoxCache(start_code(prim.GetStage()), purposes)
    corners = []
    for gprim in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()):
        if not gprim.IsA(UsdGeom.Gprim) or inherited_target(gprim, "skel:skeleton") is not None:
            continue
        box = cache.ComputeRelativeBound(gprim, prim).ComputeAlignedRange()
        if not box.IsEmpty():
            corners.append(upright.apply(np.array([box.GetCorner(i) for i in range(8)])))
    if not corners:
        return None
    points = np.concatenate(corners)
    return np.stack([points.min(axis=0), points.max(axis=0)])


def _blend_shapes(skeleton: Usd.Prim) -> BlendShapes | None:
    """Blend shape weights of the animation the Skeleton is bound to."""
    source = inherited_target(skeleton, "skel:animationSource")
    animation = UsdSkel.Animation(skeleton.GetStage().GetPrimAtPath(source)) if source else None
    names = tuple(map(str, array_at(animation.GetBlendShapesAttr()))) if animation else ()
    if not animation or not names:
        return None
    weights = read_samples(animation.GetBlendShapeWeightsAttr(), len(names))
    return BlendShapes(names=names, codes=weights.codes, weights=weights.values) if weights else None


def _warn_of_size(prim: Usd.Prim, rest_translations: FloatArray, asset: str) -> None:
    reach = float(np.linalg.norm(rest_translations, axis=-1).max())
    if not 0.02 < reach < 20.0:
        _logger.warning(
            "%s: bones of %.3g m; %s seems to be in other units than the scene, scale the prim to fit",
            prim.GetPath(),
            reach,
            asset,
        )


def _warn_of_posture(prim: Usd.Prim, skeleton: Skeleton, biped: Biped, bind: Pose | None, asset: str) -> None:
    """Say so if the legs point down neither at rest nor in the bind pose."""
    rest, _ = forward_kinematics(skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations)
    legs = [(p[list(biped.ankles)] - p[list(biped.hips)]).sum(axis=0) for p in (rest, bind.places if bind else rest)]
    if all(-leg[1] < _UPRIGHT * np.linalg.norm(leg) for leg in legs):
        _logger.warning(
            "%s: its legs do not point down; %s seems to have another up axis than the scene, rotate the prim upright",
            prim.GetPath(),
            asset,
        )


def _warn_of_other_legs(prim: Usd.Prim, skeleton: Skeleton, biped: Biped) -> None:
    """Say so if a character stands on more than two legs."""
    others = find_other_feet(skeleton, biped)
    if others:
        _logger.warning(
            "%s: stands on more than two legs. footsteps are of %s alone; %s move as in clips, or not at all. "
            "let other legs follow in your own rig, or author UsdfootBipedAPI for those that are to walk",
            prim.GetPath(),
            " and ".join(leaf_name(skeleton.joints[ankle]) for ankle in biped.ankles),
            ", ".join(leaf_name(skeleton.joints[joint]) for joint in others),
        )


def _relative(prim: Usd.Prim, ancestor: Usd.Prim) -> str:
    path = str(prim.GetPath().MakeRelativePath(ancestor.GetPath()))
    return "" if path == "." else path


def _snapped(rotation: FloatArray) -> FloatArray:
    """The rotation, or the exact identity where it differs from it by rounding only."""
    rotation = rotation if rotation[3] >= 0.0 else -rotation
    return np.array([0.0, 0.0, 0.0, 1.0]) if np.abs(rotation[:3]).max() < _LEVEL else rotation
