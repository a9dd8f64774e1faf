"""Similarity: uniform scale, rotation and translation, and how one above a skeleton is folded into its joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.errors import SkeletonError
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["Similarity", "fold_into_joints", "similarity_of_matrices", "unfold_from_joints"]

_TOLERANCE = 1e-3
"""Relative difference of two axes' scales, or cosine between them, that still counts as rounding."""


@dataclass(frozen=True, kw_only=True)
class Similarity:
    """Maps p to scale * rotate(rotation, p) + translation. K = 1, or the number of samples where it moves."""

    scale: float
    """Uniform and positive, target units per source unit."""
    rotation: FloatArray
    """Unit quaternions xyzw, shape (K, 4)."""
    translation: FloatArray
    """In target units, shape (K, 3)."""

    def __len__(self) -> int:
        return len(self.rotation)

    def after(self, first: Similarity) -> Similarity:
        """The similarity that applies `first`, then this one."""
        turned = quaternion.rotate(self.rotation, first.translation)
        return Similarity(
            scale=self.scale * first.scale,
            rotation=quaternion.compose(self.rotation, first.rotation),
            translation=self.scale * turned + self.translation,
        )

    def inverse(self) -> Similarity:
        """The similarity that undoes this one."""
        rotation = quaternion.inverse(self.rotation)
        return Similarity(
            scale=1.0 / self.scale,
            rotation=rotation,
            translation=-quaternion.rotate(rotation, self.translation) / self.scale,
        )

    def apply(self, points: FloatArray) -> FloatArray:
        """Points (N, 3) mapped by a similarity that does not move (K = 1)."""
        return self.scale * quaternion.rotate(self.rotation, points) + self.translation

    def at(self, times: FloatArray, wanted: FloatArray) -> Similarity:
        """The similarity with samples at other times, held before the first and after the last.

        Args:
            times: Of its own samples, increasing, shape (K,).
            wanted: Times to sample at, shape (N,).
        """
        after = np.clip(np.searchsorted(times, wanted, side="right"), 1, len(times) - 1)
        before = after - 1
        fraction = np.clip((wanted - times[before]) / (times[after] - times[before]), 0.0, 1.0)
        moved = self.translation[before] + fraction[:, None] * (self.translation[after] - self.translation[before])
        turned = quaternion.slerp(self.rotation[before], self.rotation[after], fraction)
        return Similarity(scale=self.scale, rotation=turned, translation=moved)


def similarity_of_matrices(matrices: FloatArray, where: object) -> Similarity:
    """Similarity of USD matrices (row vectors), shape (K, 4, 4), all of the same scale.

    Args:
        matrices: As numpy gives `Gf.Matrix4d`: translation in the last row, shape (K, 4, 4).
        where: Prim the matrices belong to, for the message.

    Raises:
        SkeletonError: If a matrix has shear, mirrors, or scales by different factors along axes or over time.
    """
    linear = matrices[:, :3, :3]
    lengths = np.linalg.norm(linear, axis=-1)  # (K, 3)
    if not np.isfinite(matrices).all() or np.any(lengths <= 0.0):
        what = "has a transform above the joints that is not finite or scales to nothing"
        raise SkeletonError(where, what, "author finite transforms with a scale above 0")
    axes = linear / lengths[..., None]
    cosines = axes @ np.swapaxes(axes, -1, -2) - np.eye(3)
    scale = float(lengths[0].mean())
    if np.abs(cosines).max() > _TOLERANCE or np.abs(lengths / scale - 1.0).max() > _TOLERANCE:
        raise SkeletonError(
            where,
            f"has a transform above it with shear or different scales (first {np.round(lengths[0], 6)})",
            "scale all axes alike, or bake the transform into the asset",
        )
    if np.any(np.linalg.det(axes) < 0.0):
        raise SkeletonError(where, "is mirrored by a transform above it", "bake the negative scale into the asset")
    rotation = quaternion.continuous(quaternion.from_matrix(np.swapaxes(axes, -1, -2)))
    return Similarity(scale=scale, rotation=rotation, translation=np.array(matrices[:, 3, :3], dtype=float))


def fold_into_joints(
    similarity: Similarity, parents: IntArray, *, translations: FloatArray, rotations: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Joint-local transforms of the same skeleton seen in the similarity's target space.

    Root joints take the rigid part, all others only the scale, so that joint frames below the roots stay as they are.

    Args:
        similarity: From skeleton space to the target space, K = 1 or T.
        parents: Index of each joint's parent, -1 for roots, shape (J,).
        translations: Joint-local, skeleton units, shape (T, J, 3).
        rotations: Joint-local xyzw, shape (T, J, 4).

    Returns:
        Joint-local translations [target units] (T, J, 3) and rotations (T, J, 4).
    """
    roots = np.flatnonzero(parents < 0)
    turn, shift = similarity.rotation[:, None], similarity.translation[:, None]
    folded_translations = similarity.scale * translations
    folded_rotations = np.array(rotations, dtype=float)
    folded_translations[:, roots] = quaternion.rotate(turn, folded_translations[:, roots]) + shift
    folded_rotations[:, roots] = quaternion.compose(turn, rotations[:, roots])
    return folded_translations, folded_rotations


def unfold_from_joints(
    similarity: Similarity, parents: IntArray, *, translations: FloatArray, rotations: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Inverse of `fold_into_joints`: joint-local transforms as they stand in the skeleton's own space.

    Args:
        similarity: From skeleton space to the space of the joints given, K = 1 or T.
        parents: Index of each joint's parent, -1 for roots, shape (J,).
        translations: Joint-local [target units], shape (T, J, 3).
        rotations: Joint-local xyzw, shape (T, J, 4).

    Returns:
        Joint-local translations [skeleton units] (T, J, 3) and rotations (T, J, 4).
    """
    return fold_into_joints(similarity.inverse(), parents, translations=translations, rotations=rotations)
