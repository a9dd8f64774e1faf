"""Clips: SkelAnimations of any exporter as samples on a character's joints, in canonical space."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

import numpy as np
from pxr import Usd, UsdSkel

from usdfoot.analysis.axes import axis_turns, with_axes
from usdfoot.bridge.similarity import Similarity, fold_into_joints, similarity_of_matrices
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import ClipError
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip, ShapeTrack
from usdfoot.model.limits import DEFAULT_LIMITS
from usdfoot.model.skeleton import Skeleton, forward_kinematics
from usdfoot.readers.attributes import array_at
from usdfoot.readers.clip_attributes import read_clip_attributes
from usdfoot.readers.clip_placing import in_units_of, stood_up
from usdfoot.readers.joints import leaf_name, match_joints
from usdfoot.readers.samples import SampledArray, interpolate_linear, interpolate_rotations, read_samples, regular_codes
from usdfoot.readers.skeleton import RawSkeleton, fold_scales, is_moving, matrices_of, read_joints, skeleton_in
from usdfoot.readers.transform_codes import transform_codes

__all__ = ["ClipSource", "missing_leg_joints", "read_clip"]

_logger = logging.getLogger(__name__)

_MOST_SAMPLES = 1e4
"""A second; no camera takes more, and analysis has windows of so and so many seconds."""
_OTHER_AXES = 0.7
"""Axes of legs are other ones from here on [rad]; less may be the poses that were current when rigs were written."""


@dataclass(frozen=True, kw_only=True)
class ClipSource:
    """A SkelAnimation with the skeleton it was made on."""

    prim: Usd.Prim
    skeleton_prim: Usd.Prim
    skeleton: RawSkeleton
    is_bound: bool
    """Whether the skeleton plays the animation; only then do moving transforms above it belong to the clip."""


def read_clip(
    source: ClipSource,
    skeleton: Skeleton,
    biped: Biped,
    *,
    units: StageUnits,
    most_frames: int = DEFAULT_LIMITS.frames,
) -> Clip:
    """The clip on the joints of a character.

    Transforms above the clip's own skeleton are applied, moving ones too, and what is missing there for a file in other
    units or with another up axis. Joints that the clip lacks keep the rest
    pose of its skeleton, or of the character's where that lacks them as well.

    Args:
        source: Animation and its skeleton.
        skeleton: The character's, canonical.
        biped: The character's.
        units: Of the stage.
        most_frames: Samples that a clip may have.

    Raises:
        ClipError: If leg joints are missing, nothing moves, or values are not finite.
        SkeletonError: If a transform above the clip's skeleton is no similarity.
    """
    where = str(source.prim.GetPath())
    missing = missing_leg_joints(source, skeleton, biped)
    if missing:
        raise ClipError(
            where,
            f"does not move the leg joints of {skeleton.name}",
            "put it on these joints with usdfoot retarget, or point usdfoot:clip:skeleton at its own Skeleton",
            missing,
        )
    codes, translations, rotations = _sample(source, units, most_frames)
    times = units.codes_to_times(codes)
    attributes = read_clip_attributes(source.prim, times, units)
    similarity = _skeleton_to_world(source, codes, units)
    similarity = stood_up(
        where, similarity, source.skeleton, poses=(translations, rotations), skeleton=skeleton, biped=biped, units=units
    )
    own = skeleton_in(source.skeleton, similarity)
    similarity = in_units_of(where, similarity, own, skeleton=skeleton, biped=biped)
    translations, rotations = fold_into_joints(similarity, own.parents, translations=translations, rotations=rotations)
    turns = _other_axes(where, own, skeleton, biped)
    if turns is not None:
        translations, rotations = with_axes(own.parents, turns, translations=translations, rotations=rotations)
    translations, rotations = _on_joints_of(skeleton, own, translations, rotations)
    _check_legs(where, skeleton, biped, translations, rotations)
    return Clip(
        name=where,
        rate=(len(times) - 1) / float(times[-1] - times[0]),
        start_time=float(times[0]),
        translations=translations,
        rotations=quaternion.continuous(rotations),
        style=attributes.style,
        root_motion=attributes.root_motion,
        cyclic=attributes.cyclic,
        range_start=attributes.range_start,
        range_end=attributes.range_end,
        mirror=attributes.mirror,
        events=attributes.events,
        synthetic=attributes.synthetic,
        shapes=_shapes(UsdSkel.Animation(source.prim), codes),
    )


def missing_leg_joints(source: ClipSource, skeleton: Skeleton, biped: Biped) -> list[str]:
    """Names of the character's pelvis, hips, knees and ankles that the animation does not move."""
    animated = read_joints(source.prim)
    legs = (*biped.hips, *biped.knees, *biped.ankles)
    matches = match_joints(animated, skeleton.joints)
    return [leaf_name(skeleton.joints[joint]) for joint in legs if matches[joint] < 0]


def _sample(source: ClipSource, units: StageUnits, most_frames: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Regular time codes (T,) and joint-local translations and rotations of all joints of the clip's skeleton."""
    animation, raw = UsdSkel.Animation(source.prim), source.skeleton
    where = source.prim.GetPath()
    joints = read_joints(source.prim)
    twice = sorted({joint for joint in joints if joints.count(joint) > 1})
    if twice:
        raise ClipError(where, "lists joints twice", "every joint path must be unique", twice)
    rotations = read_samples(animation.GetRotationsAttr(), len(joints))
    translations = read_samples(animation.GetTranslationsAttr(), len(joints))
    scales = read_samples(animation.GetScalesAttr(), len(joints))
    if rotations is None:
        held = len(array_at(animation.GetRotationsAttr(), Usd.TimeCode.EarliestTime()))
        what = f"has {held or 'no'} rotations for its {len(joints)} joints"
        raise ClipError(where, what, "author one quaternion a joint")
    _check_finite(where, rotations, translations, scales)
    if translations is None:
        _logger.warning("%s: has no translations for its %d joints, they stay as at rest", where, len(joints))
    codes = _sample_codes(source, rotations, translations, units, most_frames)
    order = match_joints(joints, raw.joints)
    all_rotations = _spread(raw.rotations, interpolate_rotations(rotations, codes), order)
    all_scales = _spread(raw.scales, scales.values, order) if scales else raw.scales[None]
    rest = raw.translations / raw.inherited_scales[:, None]
    local = interpolate_linear(translations, codes) if translations else None
    all_translations = _spread(rest, local, order) if local is not None else np.repeat(rest[None], len(codes), axis=0)
    folded, _ = fold_scales(raw.parents, all_translations, all_scales, where=where)
    return codes, folded, all_rotations


def _shapes(animation: UsdSkel.Animation, codes: FloatArray) -> ShapeTrack | None:
    """Blend shapes of the animation at time codes (T,)."""
    names = tuple(map(str, array_at(animation.GetBlendShapesAttr(), error=ClipError)))
    samples = read_samples(animation.GetBlendShapeWeightsAttr(), len(names)) if names else None
    if samples is None or not np.isfinite(samples.values).all():
        return None
    weights = interpolate_linear(replace(samples, values=samples.values[..., None]), codes)[..., 0]
    return ShapeTrack(names=names, weights=weights)


def _sample_codes(
    source: ClipSource,
    rotations: SampledArray,
    translations: SampledArray | None,
    units: StageUnits,
    most_frames: int,
) -> FloatArray:
    """Regular time codes over the samples of the animation, shape (T,)."""
    moving = [samples.codes for samples in (rotations, translations) if samples and len(samples.codes) > 1]
    if not moving:
        raise ClipError(
            source.prim.GetPath(), "has fewer than two time samples", "a clip needs at least two, a pose is no clip"
        )
    codes = np.concatenate(moving)
    above = transform_codes(source.skeleton_prim) if source.is_bound else codes
    within = above[(above >= codes.min()) & (above <= codes.max())]
    regular = regular_codes([codes, within], units.time_codes_per_second, where=source.prim.GetPath(), most=most_frames)
    rate = (len(regular) - 1) / float(np.ptp(units.codes_to_times(regular)))
    if rate > _MOST_SAMPLES:
        what, remedy = (
            f"has {rate:.2g} samples a second",
            "correct their times, or the offset of a layer or reference",
        )
        raise ClipError(source.prim.GetPath(), what, remedy)
    return regular


def _spread(rest: FloatArray, values: FloatArray, order: IntArray) -> FloatArray:
    """Animated values (T, A, C) in the skeleton's order, the rest (J, C) where a joint is not animated."""
    result = np.repeat(np.asarray(rest, dtype=float)[None], len(values), axis=0)
    found = order >= 0
    result[:, found] = values[:, order[found]]
    return result


def _check_finite(
    where: object, rotations: SampledArray, translations: SampledArray | None, scales: SampledArray | None
) -> None:
    for label, samples in (("rotations", rotations), ("translations", translations), ("scales", scales)):
        if samples is None:
            continue
        bad = ~np.isfinite(samples.values).all(axis=(1, 2))
        if label == "rotations":
            bad |= np.any(np.linalg.norm(samples.values, axis=-1) < 1e-6, axis=1)
        if bad.any():
            code = samples.codes[np.flatnonzero(bad)[0]]
            raise ClipError(where, f"{label} at time code {code:g} are not finite, or zero", "repair the sample")


def _check_legs(where: str, skeleton: Skeleton, biped: Biped, translations: FloatArray, rotations: FloatArray) -> None:
    """Raises ClipError if the first sample puts joints of a leg on one spot that are apart at rest."""
    short = _leg_bones(biped, skeleton.parents, translations[0], rotations[0]) == 0.0
    if not short.any():
        return
    short &= _leg_bones(biped, skeleton.parents, skeleton.rest_translations, skeleton.rest_rotations) > 0.0
    flat = np.array([biped.knees, biped.ankles])[short]
    if flat.size:
        remedy = "author translations as they are below the joint above, and no scales of 0"
        raise ClipError(where, "gives legs no length", remedy, [leaf_name(skeleton.joints[joint]) for joint in flat])


def _leg_bones(biped: Biped, parents: IntArray, translations: FloatArray, rotations: FloatArray) -> FloatArray:
    """Length of thighs and shins of both legs in one pose, shape (2, 2)."""
    below = np.array([biped.knees, biped.ankles])
    if (parents[below] == [biped.hips, biped.knees]).all():
        return np.asarray(np.linalg.norm(translations[below], axis=-1))
    positions, _ = forward_kinematics(parents, translations, rotations)
    return np.asarray(np.linalg.norm(np.diff(positions[[biped.hips, biped.knees, biped.ankles]], axis=0), axis=-1))


def _skeleton_to_world(source: ClipSource, codes: FloatArray, units: StageUnits) -> Similarity:
    """From the space of the clip's skeleton to the canonical world, at every code if it moves."""
    moving = source.is_bound and is_moving(source.skeleton_prim)
    matrices = matrices_of(source.skeleton_prim, codes if moving else codes[:1])
    to_stage = similarity_of_matrices(matrices, source.skeleton_prim.GetPath())
    return Similarity(
        scale=to_stage.scale * units.meters_per_unit,
        rotation=units.frames_to_canonical(to_stage.rotation),
        translation=units.points_to_canonical(to_stage.translation),
    )


def _other_axes(where: str, own: Skeleton, skeleton: Skeleton, biped: Biped) -> FloatArray | None:
    """Turns (K, 4) from the character's joint axes to the clip's; None if those of the legs are about the same.

    One skeleton placed in two ways differs in its roots only, and its axes are the same.
    """
    below = skeleton.parents >= 0
    if own.joints == skeleton.joints and all(
        np.allclose(getattr(own, name)[below], getattr(skeleton, name)[below], atol=1e-6)
        for name in ("rest_translations", "rest_rotations")
    ):
        return None
    order = match_joints(own.joints, skeleton.joints)
    turns = axis_turns(own, skeleton, order)
    legs = order[[biped.pelvis, *biped.hips, *biped.knees, *biped.ankles]]
    angles = np.linalg.norm(quaternion.to_rotation_vector(turns[legs]), axis=1)
    if angles.max() < _OTHER_AXES:
        return None
    _logger.warning(
        "%s: joint axes differ from those of %s by up to %.0f degrees, the clip is retargeted by the rest poses",
        where,
        skeleton.name,
        np.degrees(angles.max()),
    )
    return turns


def _on_joints_of(
    skeleton: Skeleton, own: Skeleton, translations: FloatArray, rotations: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Joint-local samples on the character's joints.

    A joint whose parents correspond is copied. Others, below joints that only one of the two skeletons has, keep
    their place in skeleton space. Joints that only the character has keep its rest pose.
    """
    order = match_joints(own.joints, skeleton.joints)
    expected = np.where(skeleton.parents >= 0, order[skeleton.parents], -1)
    copied = (order >= 0) & (own.parents[order] == expected) & ((skeleton.parents < 0) | (expected >= 0))
    if copied.all():
        return translations[:, order], rotations[:, order]
    clip_positions, clip_rotations = forward_kinematics(own.parents, translations, rotations)
    count = len(skeleton.joints)
    new_translations = np.repeat(skeleton.rest_translations[None], len(rotations), axis=0)
    new_rotations = np.repeat(skeleton.rest_rotations[None], len(rotations), axis=0)
    positions = np.zeros((len(rotations), count, 3))
    turns = np.tile([0.0, 0.0, 0.0, 1.0], (len(rotations), count, 1))
    for joint, parent in enumerate(skeleton.parents):
        source = order[joint]
        origin = (positions[:, parent], turns[:, parent]) if parent >= 0 else (np.zeros(3), np.array([0.0, 0, 0, 1.0]))
        if copied[joint]:
            new_translations[:, joint], new_rotations[:, joint] = translations[:, source], rotations[:, source]
        elif source >= 0:
            back = quaternion.inverse(origin[1])
            new_translations[:, joint] = quaternion.rotate(back, clip_positions[:, source] - origin[0])
            new_rotations[:, joint] = quaternion.compose(back, clip_rotations[:, source])
        positions[:, joint] = origin[0] + quaternion.rotate(origin[1], new_translations[:, joint])
        turns[:, joint] = quaternion.compose(origin[1], new_rotations[:, joint])
    return new_translations, new_rotations
