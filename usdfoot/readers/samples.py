"""Time samples of animation attributes, brought onto one regular grid."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Tf, Usd

from usdfoot.bridge.usd_errors import usd_reason
from usdfoot.errors import ClipError
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.limits import DEFAULT_LIMITS, check_limit
from usdfoot.readers.attributes import checked

__all__ = ["SampledArray", "interpolate_linear", "interpolate_rotations", "read_samples", "regular_codes"]

_logger = logging.getLogger(__name__)

_SLOWEST = 24.0
"""Keys farther apart than this rate [Hz] are filled in between: contacts cannot be seen in fewer samples."""
_SAME = 1e-4
"""Difference in spacing, as a fraction of it, that still counts as regular."""


@dataclass(frozen=True, kw_only=True)
class SampledArray:
    """Values of an array attribute at its own time codes."""

    codes: FloatArray
    """Increasing, shape (S,); one entry, 0, for a value that does not change."""
    values: FloatArray
    """Shape (S, N, C), or (S, N) for plain numbers."""


def read_samples(attribute: Usd.Attribute, count: int) -> SampledArray | None:
    """All time samples of an array attribute, or its default; None if there is neither.

    Samples that are blocked or do not hold `count` elements are left out, the latter with a warning.

    Raises:
        ClipError: If USD cannot read one, as in a damaged file, or they are of another type than the schema's.
    """
    codes = list(attribute.GetTimeSamples())
    try:
        values = [attribute.Get(code) for code in codes] if codes else [attribute.Get()]
    except Tf.ErrorException as error:
        raise ClipError(attribute.GetPath(), "cannot be read", usd_reason(error)) from error
    for value in {type(value): value for value in values if value is not None}.values():
        checked(attribute, value, error=ClipError)
    codes = codes or [0.0]
    kept = [i for i, value in enumerate(values) if value is not None and len(value) == count]
    if not kept:
        return None
    odd = [code for code, value in zip(codes, values, strict=True) if value is not None and len(value) != count]
    if odd:
        _logger.warning(
            "%s: %d sample(s) that hold other than %d values are left out, first at time code %g",
            attribute.GetPath(),
            len(odd),
            count,
            odd[0],
        )
    return SampledArray(
        codes=np.array([codes[i] for i in kept], dtype=float),
        values=np.stack([np.asarray(values[i]) for i in kept]).astype(float),
    )


def regular_codes(
    codes: Sequence[FloatArray],
    codes_per_second: float,
    *,
    where: object = "samples",
    most: int = DEFAULT_LIMITS.frames,
) -> FloatArray:
    """A regular grid of time codes through the samples, as dense as they are.

    The spacing is the median one, divided by a whole number where that is sparser than 24 Hz. Samples that are
    regular already keep their own codes.

    Args:
        codes: Time codes of the sampled attributes.
        codes_per_second: Time codes in one second.
        where: Prim they are of.
        most: Codes that the grid may have.

    Raises:
        SceneError: If it would have more.
    """
    merged = np.unique(np.concatenate([c for c in codes if len(c) > 1] or [codes[0]]))
    if len(merged) < 2:
        return merged
    gaps = np.diff(merged)
    merged = merged[np.concatenate([[True], gaps > _SAME * np.median(gaps)])]
    spacing = float(np.median(np.diff(merged)))
    spacing /= np.ceil(max(1.0, spacing / codes_per_second * _SLOWEST - _SAME))
    intervals = max(1, round((merged[-1] - merged[0]) / spacing))
    check_limit(where, "frames", intervals + 1, limit=most)
    grid = merged[0] + spacing * np.arange(intervals + 1)
    if abs(grid[-1] - merged[-1]) < _SAME * spacing * intervals:
        return np.linspace(merged[0], merged[-1], intervals + 1)
    return grid[grid <= merged[-1] + _SAME * spacing]


def interpolate_linear(samples: SampledArray, codes: FloatArray) -> FloatArray:
    """Values at time codes (T,), linear between samples and held outside, shape (T, N, C)."""
    before, after, fraction = _brackets(samples.codes, codes)
    weight = fraction[:, None, None]
    return samples.values[before] * (1.0 - weight) + samples.values[after] * weight


def interpolate_rotations(samples: SampledArray, codes: FloatArray) -> FloatArray:
    """Unit quaternions xyzw at time codes (T,), spherical between samples, continuous in sign, shape (T, N, 4)."""
    values = quaternion.continuous(quaternion.normalised(samples.values))
    before, after, fraction = _brackets(samples.codes, codes)
    exact = np.all((fraction == 0.0) | (before == after))
    result = values[before] if exact else quaternion.slerp(values[before], values[after], fraction[:, None])
    return quaternion.continuous(result)


def _brackets(samples: FloatArray, codes: FloatArray) -> tuple[np.ndarray, np.ndarray, FloatArray]:
    """Index of the sample before and after each code, and the fraction between the two."""
    after = np.clip(np.searchsorted(samples, codes, side="right"), 1, len(samples) - 1) if len(samples) > 1 else None
    if after is None:
        zero = np.zeros(len(codes), dtype=int)
        return zero, zero, np.zeros(len(codes))
    before = after - 1
    fraction = np.clip((codes - samples[before]) / (samples[after] - samples[before]), 0.0, 1.0)
    at_end = fraction >= 1.0
    return np.where(at_end, after, before), after, np.where(at_end, 0.0, fraction)
