"""The body's orientation: the moving mean of the feet's headings, or a script ([P] 2.6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.physics.footing import Footing

__all__ = ["OrientationScript", "body_orientations", "heading_of"]


@dataclass(frozen=True, kw_only=True)
class OrientationScript:
    """An agent's body orientation given by the animator; before the first and after the last key it stays."""

    times: FloatArray
    """Increasing [s], shape (T,)."""
    rotations: FloatArray
    """Body frame to world, xyzw, shape (T, 4)."""


def body_orientations(
    footing: Footing,
    scripts: Sequence[OrientationScript | None],
    *,
    agents: IntArray,
    times: FloatArray,
    window: float,
) -> FloatArray:
    """Body frame to world at F times, xyzw, shape (F, 4).

    Args:
        footing: Of all agents.
        scripts: Orientation of each agent that has one, shape (A,); empty = none has.
        agents: Agent of each query, shape (F,).
        times: [s], shape (F,).
        window: Of the moving mean [s].
    """
    rotations = quaternion.yaw_quaternion(footing.body_yaws(agents, times, window=window))
    for agent, script in enumerate(scripts):
        if script is not None:
            own = agents == agent
            rotations[own] = _scripted(script, times[own])
    return rotations


def heading_of(orientations: FloatArray) -> FloatArray:
    """Yaw of body frames (F, 4) [rad]."""
    return planar.yaw_of(quaternion.rotate(orientations, np.array([0.0, 0.0, 1.0]))[:, [0, 2]])


def _scripted(script: OrientationScript, times: FloatArray) -> FloatArray:
    if len(script.times) == 1:
        return np.repeat(script.rotations, len(times), axis=0)
    after = np.clip(np.searchsorted(script.times, times, side="right"), 1, len(script.times) - 1)
    share = (times - script.times[after - 1]) / (script.times[after] - script.times[after - 1])
    return quaternion.slerp(script.rotations[after - 1], script.rotations[after], np.clip(share, 0.0, 1.0))
