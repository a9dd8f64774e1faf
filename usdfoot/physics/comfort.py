"""Where the optimisation begins: in comfort, whatever physics says."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.physics.samples import Samples
from usdfoot.physics.spline import Knots

__all__ = ["comfortable_unknowns"]


def comfortable_unknowns(samples: Samples, knots: Knots, start: FloatArray) -> FloatArray:
    """Position and velocity of knots at rest where the legs are most comfortable, shape (K, 6).

    The leg stands straight up in its nominal length; of two that stand, the mean by the weight on them. Knots in the
    air are where one beside them is.

    Args:
        samples: Of all segments; the instants next to the knots count.
        knots: Of all agents.
        start: Kept where it is fixed, and of agents none of whose knots stands, shape (K, 6).
    """
    instants, count = samples.times.shape[1], len(knots.begins)
    beside = np.arange(count)[:, None] * instants + [0, instants - 1]  # (S, 2)
    loads = samples.leg_shares[beside]
    tops = samples.anchors[beside] + samples.nominal_lengths[beside][..., None] * np.array([0.0, 1.0, 0.0])
    carried = np.concatenate([np.einsum("sil,silx->six", loads, tops), loads.sum(axis=2)[..., None]], axis=2)
    sums = np.zeros((len(start), 4))
    sums[knots.begins] += carried[:, 0]
    sums[knots.begins + 1] += carried[:, 1]
    standing = np.flatnonzero(sums[:, 3] > 0.0)
    if not standing.size:
        return start.copy()
    places = np.searchsorted(standing, np.arange(len(start)), side="right") - 1
    before, after = standing[np.maximum(places, 0)], standing[np.minimum(places + 1, len(standing) - 1)]
    nearest = np.where(knots.agents[before] == knots.agents, before, after)
    kept = np.repeat(knots.fixed | (knots.agents[nearest] != knots.agents)[:, None], 3, axis=1)
    positions = sums[nearest, :3] / sums[nearest, 3:]
    return np.where(kept, start, np.concatenate([positions, np.zeros_like(positions)], axis=1))
