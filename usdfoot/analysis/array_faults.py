"""What is wrong with the arrays of an animation: rotations and contacts."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray

__all__ = ["contact_faults", "sign_changes", "unlike_unit"]


def unlike_unit(rotations: FloatArray, *, tolerance: float = 1e-3) -> BoolArray:
    """Which rotations are not unit quaternions, or not finite.

    Args:
        rotations: xyzw, shape (..., 4).
        tolerance: Difference of the length from 1 that is let pass.
    """
    lengths = np.linalg.norm(rotations, axis=-1)
    return ~(np.abs(lengths - 1.0) <= tolerance)


def sign_changes(rotations: FloatArray) -> BoolArray:
    """Which rotations are on the other side of the sphere than the sample before, shape (F - 1, J).

    They are the same rotations, but whoever interpolates the numbers turns the joint once around.

    Args:
        rotations: xyzw, shape (F, J, 4).
    """
    return np.sum(rotations[1:] * rotations[:-1], axis=-1) < 0.0


def contact_faults(
    strikes: FloatArray, flats: FloatArray, liftoffs: FloatArray, *, first: float, last: float, tolerance: float = 1e-3
) -> tuple[BoolArray, BoolArray]:
    """Which contacts of one foot are out of order, and which reach outside the animation, shape (K,) each.

    In order are strike <= flat <= liftoff, strike < liftoff, and every strike after the liftoff before.

    Args:
        strikes: Time codes, shape (K,).
        flats: Time codes, shape (K,).
        liftoffs: Time codes, shape (K,).
        first: Time code of the animation's first sample.
        last: Time code of its last.
        tolerance: Time codes let pass at both ends.
    """
    within = (strikes <= flats) & (flats <= liftoffs) & (strikes < liftoffs)
    after = np.ones(len(strikes), dtype=bool)
    after[1:] = strikes[1:] >= liftoffs[:-1]
    inside = (np.minimum(strikes, flats) >= first - tolerance) & (np.maximum(flats, liftoffs) <= last + tolerance)
    return ~(within & after), ~inside
