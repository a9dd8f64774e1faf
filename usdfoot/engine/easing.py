"""Warp functions that come in smoothly: steps, ramps and maxima without corners."""

from __future__ import annotations

import warp as wp

__all__ = ["ramp", "rising", "smootherstep", "soft_positive", "together"]


@wp.func
def smootherstep(x: float) -> float:
    """Rises from 0 to 1 over 0..1 without velocity or acceleration at the ends."""
    y = wp.clamp(x, 0.0, 1.0)
    return y * y * y * (10.0 + y * (6.0 * y - 15.0))


@wp.func
def rising(x: wp.float64) -> wp.float64:
    """`smootherstep` in double precision."""
    y = wp.clamp(x, wp.float64(0.0), wp.float64(1.0))
    return y * y * y * (wp.float64(10.0) + y * (wp.float64(6.0) * y - wp.float64(15.0)))


@wp.func
def soft_positive(x: float, width: float) -> float:
    """Smooth max(x, 0), above it by at most half the width."""
    return 0.5 * (x + wp.sqrt(x * x + width * width))


@wp.func
def ramp(x: float, width: float) -> float:
    """max(x, 0) with its corner rounded from -width to width; exactly zero before."""
    y = wp.clamp(x + width, 0.0, 2.0 * width)
    return y * y / (4.0 * width) + wp.max(x - width, 0.0)


@wp.func
def together(first: float, second: float) -> float:
    """Smooth maximum of two lengths that are not below zero, zero only where both are."""
    most = wp.max(wp.max(first, second), 1.0e-6)
    one = first / most
    two = second / most
    return most * wp.sqrt(wp.sqrt(one * one * one * one + two * two * two * two))
