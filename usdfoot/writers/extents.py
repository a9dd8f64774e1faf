"""Extents: the box of every frame around a posed character, in the space of its agent prim."""

from __future__ import annotations

from itertools import product

import numpy as np
import warp as wp

from usdfoot.bridge.scene import Character
from usdfoot.bridge.units import StageUnits
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.writers.pose_kernels import box_frames

__all__ = ["prim_extents"]

_LANES = 64
"""Frames whose joints are kept at once."""


def prim_extents(
    character: Character, translations: FloatArray, rotations: FloatArray, *, units: StageUnits
) -> FloatArray:
    """Boxes of F frames as USD computes them, shape (F, 2, 3) [stage units].

    That is the box around the joints, padded. Geometry that is not skinned, which USD leaves out, is added; where a
    transform above the Skeleton moves, which USD takes as it is at no time at all, it counts as it is at each frame.

    Args:
        character: Whose frames these are.
        translations: Joint-local, in the Skeleton's units, as written, float32, shape (F, J, 3).
        rotations: Unit xyzw, as written, float32, shape (F, J, 4).
        units: Of the written stage.
    """
    boxes = np.empty((len(rotations), 2, 3), dtype=np.float32)
    boxes[:, 0], boxes[:, 1] = np.inf, -np.inf
    on_device = wp.array(boxes, dtype=wp.vec3f)
    scales = np.asarray(character.rest_scales, dtype=np.float16)
    animation = [_array(translations, wp.vec3f), _array(rotations, wp.quatf), _array(scales, wp.vec3f)]
    for bound in character.bounds:
        placing = _placing(character, bound.to_prim, units)
        scratch = (min(_LANES, len(boxes)), len(bound.parents))
        wp.launch(
            box_frames,
            dim=scratch[0],
            inputs=[
                wp.array(bound.parents.astype(np.int32), dtype=wp.int32),
                wp.array(bound.sources.astype(np.int32), dtype=wp.int32),
                *_rows(bound.rest_matrices),
                *animation,
                *_rows(placing),
                bound.padding,
                wp.empty(scratch, dtype=wp.mat33d),
                wp.empty(scratch, dtype=wp.vec3d),
            ],
            outputs=[on_device],
        )
    extents = on_device.numpy()
    if character.still_extent is not None:
        corners = np.array(list(product(*character.still_extent.T)))
        turn, scale = _to_prim(character, units)
        corners = quaternion.rotate(turn, corners) * scale
        extents[:, 0] = np.minimum(extents[:, 0], corners.min(axis=0))
        extents[:, 1] = np.maximum(extents[:, 1], corners.max(axis=0))
    return extents


def _to_prim(character: Character, units: StageUnits) -> tuple[FloatArray, float]:
    """Rotation and scale from the agent's space to the prim's."""
    to_agent = quaternion.compose(units.axes_to_canonical, character.agent_rotation)
    return quaternion.inverse(to_agent), 1.0 / (units.meters_per_unit * character.agent_scale)


def _placing(character: Character, still: FloatArray, units: StageUnits) -> FloatArray:
    """Matrices from the Skeleton to the prim, one, or one a frame where they move, shape (1 or F, 4, 4)."""
    similarity = character.skeleton_to_agent
    if len(similarity) == 1:
        return still[None]
    turn, scale = _to_prim(character, units)
    axes = similarity.scale * quaternion.rotate(similarity.rotation[:, None], np.eye(3))
    rows = np.concatenate([axes, similarity.translation[:, None]], axis=1)
    matrices = np.zeros((len(similarity), 4, 4))
    matrices[:, :, :3] = scale * quaternion.rotate(turn, rows)
    matrices[:, 3, 3] = 1.0
    return matrices


def _rows(matrices: FloatArray) -> tuple[wp.array, wp.array]:
    """Axes and places of affine matrices (N, 4, 4)."""
    axes, places = np.ascontiguousarray(matrices[:, :3, :3]), np.ascontiguousarray(matrices[:, 3, :3])
    return wp.array(axes, dtype=wp.mat33d), wp.array(places, dtype=wp.vec3d)


def _array(values: FloatArray, kind: type) -> wp.array:
    return wp.array(np.ascontiguousarray(values, dtype=np.float32), dtype=kind, copy=False)
