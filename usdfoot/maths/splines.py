"""C2 splines through evenly spaced samples of many runs at once, such as the clips of a library."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_banded
from scipy.sparse import csr_matrix

from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["Splines", "build_splines", "spline_shares"]


@dataclass(frozen=True, kw_only=True)
class Splines:
    """Not-a-knot cubic splines of R runs, their N samples end to end."""

    first: IntArray
    """Index of each run's first sample, shape (R + 1,); the last entry is N."""
    starts: FloatArray
    """Time of each run's first sample [s], shape (R,)."""
    rates: FloatArray
    """Samples a second of each run [Hz], shape (R,)."""
    values: FloatArray
    """Samples, shape (N, K)."""
    slopes: FloatArray
    """Change a sample, shape (N, K)."""

    @property
    def ends(self) -> FloatArray:
        """Time of each run's last sample [s], shape (R,)."""
        return self.starts + (np.diff(self.first) - 1) / self.rates

    def at(self, runs: IntArray, times: FloatArray, columns: IntArray | slice = slice(None)) -> FloatArray:
        """Values of some columns of runs (M,) at times (M,) [s], shape (M, columns)."""
        rows, f = self._places(runs, times)
        g = 1.0 - f
        values = np.stack([(1.0 + 2.0 * f) * g * g, (1.0 + 2.0 * g) * f * f], axis=1)
        slopes = np.stack([f * g * g, -g * f * f], axis=1)
        return _blend(rows, values, self.values[:, columns]) + _blend(rows, slopes, self.slopes[:, columns])

    def rates_at(self, runs: IntArray, times: FloatArray, columns: IntArray | slice = slice(None)) -> FloatArray:
        """Derivatives [1/s] of some columns of runs (M,) at times (M,) [s], shape (M, columns)."""
        rows, f = self._places(runs, times)
        g = 1.0 - f
        values = np.stack([-6.0 * f * g, 6.0 * f * g], axis=1)
        slopes = np.stack([g * (g - 2.0 * f), f * (f - 2.0 * g)], axis=1)
        found = _blend(rows, values, self.values[:, columns]) + _blend(rows, slopes, self.slopes[:, columns])
        return found * self.rates[runs, None]

    def _places(self, runs: IntArray, times: FloatArray) -> tuple[IntArray, FloatArray]:
        """Index of the sample before each time, but never a run's last, and the part of a sample since then."""
        places = (times - self.starts[runs]) * self.rates[runs]
        before = np.clip(np.floor(places), 0, np.diff(self.first)[runs] - 2).astype(np.intp)
        return self.first[:-1][runs] + before, places - before


def _blend(rows: IntArray, weights: FloatArray, samples: FloatArray) -> FloatArray:
    """Sums of samples (N, K) at rows (M,) and the rows after them, with weights (M, 2), shape (M, K)."""
    indices, bounds = np.stack([rows, rows + 1], axis=1).ravel(), 2 * np.arange(len(rows) + 1)
    return csr_matrix((weights.ravel(), indices, bounds), shape=(len(rows), len(samples))) @ samples


def build_splines(values: FloatArray, *, first: IntArray, starts: FloatArray, rates: FloatArray) -> Splines:
    """Splines through runs of two or more samples; the arguments are the fields of `Splines`.

    The slopes s of a run solve s[i-1] + 4 s[i] + s[i+1] = 3 (v[i+1] - v[i-1]), and at both ends the third derivative
    does not jump at the sample next to the last (a parabola through three samples, a line through two).
    """
    count = np.diff(first)
    heads, tails = first[:-1], first[1:] - 1
    steps = np.diff(values, axis=0, append=values[-1:])  # the last of each run is not used
    right = np.zeros_like(values)
    right[1:-1] = 3.0 * (steps[:-2] + steps[1:-1])
    upper, middle, lower = np.ones(len(values)), np.full(len(values), 4.0), np.ones(len(values))
    long, three, two = count >= 4, count == 3, count == 2
    middle[heads] = middle[tails] = 1.0
    upper[heads] = lower[tails] = np.select([long, three], [2.0, 1.0], 0.0)
    lower[heads] = upper[tails] = 0.0
    head, tail = heads[long], tails[long]
    right[head] = 0.5 * (5.0 * steps[head] + steps[head + 1])
    right[tail] = 0.5 * (steps[tail - 2] + 5.0 * steps[tail - 1])
    right[heads[three]], right[tails[three]] = 2.0 * steps[heads[three]], 2.0 * steps[tails[three] - 1]
    right[heads[two]] = right[tails[two]] = steps[heads[two]]
    bands = np.stack([np.roll(upper, 1), middle, np.roll(lower, -1)])
    slopes = solve_banded((1, 1), bands, right, overwrite_ab=True, overwrite_b=True, check_finite=False)
    return Splines(first=first, starts=starts, rates=rates, values=values, slopes=slopes)


def spline_shares(knots: FloatArray | IntArray, places: FloatArray | IntArray) -> FloatArray:
    """Weights of the values at uneven knots in their not-a-knot cubic spline at places between, shape (P, K).

    The slopes s of the values v solve h[i] s[i-1] + 2 (h[i-1] + h[i]) s[i] + h[i-1] s[i+1]
    = 3 (h[i] d[i-1] + h[i-1] d[i]) with h[i] = knots[i+1] - knots[i] and d[i] = (v[i+1] - v[i]) / h[i].

    Args:
        knots: Four or more, increasing, shape (K,).
        places: From the first to the last knot, shape (P,).
    """
    values, spans = np.eye(len(knots)), np.diff(knots).astype(float)
    steps = np.diff(values, axis=0) / spans[:, None]
    left, right = np.zeros_like(values), np.zeros_like(values)
    for knot in range(1, len(knots) - 1):
        before, after = spans[knot - 1 : knot + 1]
        left[knot, knot - 1 : knot + 2] = after, 2.0 * (before + after), before
        right[knot] = 3.0 * (after * steps[knot - 1] + before * steps[knot])
    for end, one in ((0, 1), (-1, -1)):  # the third derivative does not jump at the knot next to the end
        outer, inner = spans[end], spans[end + one]
        left[end, end], left[end, end + one] = inner, outer + inner
        right[end] = (outer + 2.0 * (outer + inner)) * inner * steps[end] + outer**2 * steps[end + one]
        right[end] /= outer + inner
    slopes = np.linalg.solve(left, right)
    rows = np.clip(np.searchsorted(knots, places, side="right") - 1, 0, len(spans) - 1)
    f, span = ((places - knots[rows]) / spans[rows])[:, None], spans[rows, None]
    g = 1.0 - f
    found = (1.0 + 2.0 * f) * g * g * values[rows] + (1.0 + 2.0 * g) * f * f * values[rows + 1]
    return np.asarray(found + span * f * g * (g * slopes[rows] - f * slopes[rows + 1]))
