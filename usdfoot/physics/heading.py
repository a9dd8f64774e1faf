"""The body's orientation: the moving mean of the feet's headings, or a script ([P] 2.6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.maths import planar, quaternion
from usdfoot.maths.runs import sums_within
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable

__all__ = ["FootHeadings", "OrientationScript", "body_orientations", "heading_of", "lay_headings"]


@dataclass(frozen=True, kw_only=True)
class OrientationScript:
    """An agent's body orientation given by the animator; before the first and after the last key it stays."""

    times: FloatArray
    """Increasing [s], shape (T,)."""
    rotations: FloatArray
    """Body frame to world, xyzw, shape (T, 4)."""


@dataclass(frozen=True, kw_only=True)
class FootHeadings:
    """Yaw of both feet of A agents as integrals over time, so that any moving mean is a difference.

    A foot keeps the heading of its print in a contact and turns smoothly to the next print in the swing. One row a
    contact, sorted by foot (agent times two plus side) and time, shape (C,) each.
    """

    feet: IntArray
    begins: FloatArray
    """Strike [s]."""
    liftoffs: FloatArray
    """[s]."""
    swings: FloatArray
    """Duration of the swing after the contact [s], 1 where there is none."""
    yaws: FloatArray
    """Of the print, continuous along the plan [rad]."""
    turns: FloatArray
    """Turn in the swing [rad]."""
    integrals: FloatArray
    """Integral of the yaw over time up to the strike [rad s]."""
    origins: FloatArray
    """A time near each foot's first contact [s], shape (2 A,)."""

    def moving_means(self, agents: IntArray, times: FloatArray, *, window: float) -> FloatArray:
        """Mean yaw of both feet over the window [s] around each time, continuous [rad], shape (F,)."""
        feet = 2 * agents + np.arange(2)[:, None]  # (2, F)
        edges = times + np.array([0.5, -0.5])[:, None, None] * window  # (2, 1, F)
        feet, edges = np.broadcast_arrays(feet, edges)
        later, earlier = self._integral(feet.ravel(), edges.ravel()).reshape(feet.shape)
        return (later - earlier).sum(axis=0) / (2.0 * window)

    def _integral(self, feet: IntArray, times: FloatArray) -> FloatArray:
        rows = locate(self.feet, self.begins, self.origins, feet, times)
        swung = np.maximum(times - self.liftoffs[rows], 0.0)
        share = np.minimum(swung / self.swings[rows], 1.0)
        turned = self.swings[rows] * share**3 * (1.0 - 0.5 * share) + np.maximum(swung - self.swings[rows], 0.0)
        return self.integrals[rows] + self.yaws[rows] * (times - self.begins[rows]) + self.turns[rows] * turned


def lay_headings(contacts: ContactTable) -> FootHeadings:
    """Headings of the feet of all agents over their contacts."""
    first = contacts.first[:-1]
    steps = planar.wrap_angle(np.diff(contacts.yaws, prepend=0.0))
    steps[first] = contacts.yaws[first]
    yaws = sums_within(steps, contacts.first)
    feet = 2 * contacts.agents + contacts.sides
    order = np.lexsort((contacts.strikes, feet))
    feet, begins, liftoffs, yaws = feet[order], contacts.strikes[order], contacts.liftoffs[order], yaws[order]
    follows = np.append(feet[1:] == feet[:-1], False)
    after = np.minimum(np.arange(len(feet)) + 1, len(feet) - 1)
    swings = np.where(follows, np.maximum(begins[after] - liftoffs, 1e-6), 1.0)
    turns = np.where(follows, yaws[after] - yaws, 0.0)
    spans = np.where(follows, yaws * (begins[after] - begins) + 0.5 * turns * swings, 0.0)
    integrals = sums_within(spans, np.searchsorted(feet, np.arange(2 * len(contacts.starts) + 1))) - spans
    return FootHeadings(
        feet=feet,
        begins=begins,
        liftoffs=liftoffs,
        swings=swings,
        yaws=yaws,
        turns=turns,
        integrals=integrals,
        origins=np.repeat(contacts.starts, 2),
    )


def body_orientations(
    headings: FootHeadings,
    scripts: Sequence[OrientationScript | None],
    agents: IntArray,
    times: FloatArray,
    *,
    window: float,
) -> FloatArray:
    """Body frame to world at F times, xyzw, shape (F, 4).

    Args:
        headings: Of the feet.
        scripts: Orientation of each agent that has one, shape (A,); empty = none has.
        agents: Agent of each query, shape (F,).
        times: [s], shape (F,).
        window: Of the moving mean [s].
    """
    rotations = quaternion.yaw_quaternion(headings.moving_means(agents, times, window=window))
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
