"""Monotone cubic interpolation (PCHIP) over many small knot sets at once."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import FloatArray

__all__ = ["pchip_slopes"]


def pchip_slopes(knot_times: FloatArray, knot_values: FloatArray) -> FloatArray:
    """Slopes at the knots that keep every cubic between two knots monotone (Fritsch, Butland 1984).

    Inside, the weighted harmonic mean of the neighbouring secants, 0 at local extremes; at the ends the three-point
    formula, limited. The same as `scipy.interpolate.PchipInterpolator`, for N knot sets at once.

    Args:
        knot_times: Strictly increasing along the last axis, shape (N, K), K >= 2.
        knot_values: Shape (N, K).

    Returns:
        Slopes, shape (N, K).
    """
    lengths = np.diff(knot_times, axis=1)
    secants = np.diff(knot_values, axis=1) / lengths
    if secants.shape[1] == 1:
        return np.repeat(secants, 2, axis=1)
    slopes = np.empty_like(knot_values, dtype=float)
    slopes[:, 1:-1] = _inner_slopes(lengths, secants)
    slopes[:, 0] = _end_slopes(lengths[:, 0], lengths[:, 1], secants[:, 0], secants[:, 1])
    slopes[:, -1] = _end_slopes(lengths[:, -1], lengths[:, -2], secants[:, -1], secants[:, -2])
    return slopes


def _inner_slopes(lengths: FloatArray, secants: FloatArray) -> FloatArray:
    """Weighted harmonic means of neighbouring secants, 0 where they differ in sign, shape (N, K - 2)."""
    before, after = secants[:, :-1], secants[:, 1:]
    weight_before = 2.0 * lengths[:, 1:] + lengths[:, :-1]
    weight_after = lengths[:, 1:] + 2.0 * lengths[:, :-1]
    same_sign = np.sign(before) * np.sign(after) > 0.0
    before, after = np.where(same_sign, before, 1.0), np.where(same_sign, after, 1.0)
    means = (weight_before + weight_after) / (weight_before / before + weight_after / after)
    return np.where(same_sign, means, 0.0)


def _end_slopes(length: FloatArray, next_length: FloatArray, secant: FloatArray, next_secant: FloatArray) -> FloatArray:
    """Three-point slopes at an end knot, limited to keep the shape, shape (N,); arguments from the end inwards."""
    slopes = ((2.0 * length + next_length) * secant - length * next_secant) / (length + next_length)
    turns = np.sign(secant) != np.sign(next_secant)
    slopes = np.where(turns & (np.abs(slopes) > 3.0 * np.abs(secant)), 3.0 * secant, slopes)
    return np.where(np.sign(slopes) != np.sign(secant), 0.0, slopes)
