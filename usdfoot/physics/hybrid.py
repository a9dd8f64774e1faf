"""Hybrid: the optimised centre of mass carries the pelvis of blended clips, whose posture stays theirs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.engine.poses import ClipPoses, Poses
from usdfoot.maths import quaternion
from usdfoot.maths.runs import sums_within
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.physics.optimise import ComMotion
from usdfoot.physics.pelvis import hung_pelvises

__all__ = ["HybridPoses", "Posture", "carry_pelvis"]

SPACING = 0.05
"""Time between the samples of a posture, at most [s]."""
WINDOW = 1.2
"""About a stride: what changes more quickly is physics, what changes more slowly is posture [s]."""


@dataclass(frozen=True, kw_only=True)
class Posture:
    """Where the clips hold the pelvis, from where it hangs on the centre of mass in the rest pose, stride by stride.

    People who stoop have their pelvis behind their centre of mass, which footprints cannot tell.
    """

    first: IntArray
    """Index of each agent's first sample, shape (A + 1,)."""
    starts: FloatArray
    ends: FloatArray
    """Each agent's interval [s], shape (A,)."""
    integrals: FloatArray
    """Of the offset in the body's frame over time, from each agent's start [m s], shape (N, 3)."""

    def at(self, agents: IntArray, times: FloatArray) -> FloatArray:
        """Mean offset over a stride around each time, in the body's frame [m], shape (F, 3)."""
        first, last = self.starts[agents], self.ends[agents]
        times = np.clip(times, first, last)
        begins, ends = np.maximum(times - 0.5 * WINDOW, first), np.minimum(times + 0.5 * WINDOW, last)
        return (self._integral(agents, ends) - self._integral(agents, begins)) / (ends - begins)[:, None]

    def _integral(self, agents: IntArray, times: FloatArray) -> FloatArray:
        count = np.diff(self.first)[agents]
        places = (times - self.starts[agents]) / (self.ends - self.starts)[agents] * (count - 1)
        before = np.clip(places.astype(int), 0, count - 2)
        share, rows = (places - before)[:, None], self.first[agents] + before
        return (1.0 - share) * self.integrals[rows] + share * self.integrals[rows + 1]


@dataclass(frozen=True, kw_only=True)
class HybridPoses:
    """Poses blended from clips on a pelvis that the optimised centre of mass carries."""

    clips: ClipPoses
    com: ComMotion
    posture: Posture

    def pose(self, rows: IntArray, times: FloatArray, *, joints: IntArray) -> Poses:
        """Poses of segments `rows` (F,) at `times` [s] (F,)."""
        setup = self.clips.setup
        agents = setup.segments.agents[rows]
        poses = self.clips.pose(rows, times, joints=joints)
        pelvis = hung_pelvises(self.com, agents, times, self.posture.at(agents, times))
        positions = wp.array((pelvis - setup.origins[agents]).astype(np.float32), dtype=wp.vec3f)
        return Poses(pelvis_positions=positions, pelvis_rotations=poses.pelvis_rotations, rotations=poses.rotations)


def carry_pelvis(clips: ClipPoses, com: ComMotion) -> HybridPoses:
    """Poses of clips on an optimised centre of mass, with the posture of the clips."""
    setup = clips.setup
    contacts = setup.contacts
    lasting = contacts.ends - contacts.starts
    counts = np.ceil(lasting / SPACING).astype(int) + 2
    first = np.concatenate([[0], np.cumsum(counts)])
    agents = np.repeat(np.arange(len(counts)), counts)
    steps = (lasting / (counts - 1))[agents]
    times = contacts.starts[agents] + steps * (np.arange(first[-1]) - first[agents])
    rows = locate(setup.segments.agents, setup.segments.begins, contacts.starts, agents, times)
    blended = clips.pose(rows, times, joints=setup.rig.leg_joints).pelvis_positions.numpy() + setup.origins[agents]
    turns = com.evaluate(agents, times).orientations
    apart = quaternion.rotate(quaternion.inverse(turns), blended - hung_pelvises(com, agents, times, np.zeros(3)))
    areas = np.zeros_like(apart)
    areas[1:] = 0.5 * steps[1:, None] * (apart[1:] + apart[:-1])
    areas[first[:-1]] = 0.0
    integrals = sums_within(areas, first)
    posture = Posture(first=first, starts=contacts.starts, ends=contacts.ends, integrals=integrals)
    return HybridPoses(clips=clips, com=com, posture=posture)
