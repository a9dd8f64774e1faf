"""Edges: footsteps of many people that come down in the edges of treads are moved off them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.model.ground import Ground
from usdfoot.planning.collisions import find_collisions
from usdfoot.planning.foot_table import FootTable
from usdfoot.planning.prints import settle_on_treads

__all__ = ["keep_off_edges"]


def keep_off_edges(feet: FootTable, ground: Ground) -> FootTable:
    """The table with feet moved off the edges of treads, where that brings them into nobody else's."""
    points, near = feet.positions[:, [0, 2]], feet.positions[:, 1]
    settled = settle_on_treads(
        ground, points, feet.yaws, near=near, heels=feet.heels, toes=feet.toes, half_widths=feet.half_widths
    )
    return _where_free(feet, settled)


def _where_free(feet: FootTable, points: FloatArray) -> FootTable:
    """The table with feet moved to points (S, 2), where that brings them into nobody else's."""
    before, near = feet.positions[:, [0, 2]], feet.positions[:, 1]
    if np.array_equal(points, before):
        return feet
    moved = replace(feet, positions=np.insert(points, 1, near, axis=1))
    met = find_collisions(moved).steps.ravel()
    back = np.concatenate([met, np.minimum(met + 2, len(near) - 1)])
    settled = points.copy()
    settled[back] = before[back]
    return replace(feet, positions=np.insert(settled, 1, near, axis=1))
