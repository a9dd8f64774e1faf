"""Nudges: what a change of the footsteps ahead would make jump decays instead (inertialisation, Bollo 2018).

A swing that is given another end, or a body that finds it has to stop, goes on from where it is: the difference of the
poses before and after the change is added to the new one and fades. A foot's is gone when it strikes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.engine.legs import rotation_by
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.realtime.slots import Slots

__all__ = ["Nudges", "Snapshot"]

NUDGE_TIME = 0.3
"""Time in which a difference fades [s]."""


@dataclass(frozen=True, kw_only=True)
class Snapshot:
    """N bodies at an instant, in the world."""

    pelvis_positions: FloatArray
    """Before the feet are planted [m], shape (N, 3)."""
    rotations: FloatArray
    """Of the joints, likewise, joint-local but for the pelvis's, shape (N, J, 4)."""
    balls: FloatArray
    """Planted [m], shape (N, 2, 3)."""
    ankles: FloatArray
    """Rotations of the planted ankles, shape (N, 2, 4)."""
    roots: FloatArray
    """Position on the ground [m] and yaw [rad], shape (N, 4)."""


@wp.kernel(enable_backward=False)
def nudge_bodies(
    frames: wp.array(dtype=wp.int32),
    agents: wp.array(dtype=wp.int32),
    shares: wp.array(dtype=wp.float32),
    shifts: wp.array(dtype=wp.vec3f),
    turns: wp.array2d(dtype=wp.vec3f),
    pelvis: int,
    pelvis_positions: wp.array(dtype=wp.vec3f),
    pelvis_rotations: wp.array(dtype=wp.quatf),
    rotations: wp.array2d(dtype=wp.quatf),
) -> None:
    """Adds the shares of the agents' differences to some frames, in place."""
    k = wp.tid()
    frame = frames[k]
    agent = agents[k]
    share = shares[k]
    pelvis_positions[frame] = pelvis_positions[frame] + share * shifts[agent]
    pelvis_rotations[frame] = rotation_by(share * turns[agent, pelvis]) * pelvis_rotations[frame]
    for joint in range(turns.shape[1]):
        if joint != pelvis:
            rotations[frame, joint] = rotation_by(share * turns[agent, joint]) * rotations[frame, joint]


class Nudges(Slots):
    """Differences of all agents and when they began to fade.

    Args:
        agents: Number of agents.
        joints: Of the skeleton.
        pelvis: Index of the pelvis.
    """

    def __init__(self, agents: int, joints: int, *, pelvis: int) -> None:
        self._pelvis = pelvis
        self._shifts = np.zeros((agents, 3), dtype=np.float32)
        self._turns = np.zeros((agents, joints, 3), dtype=np.float32)
        self._ball_shifts = np.zeros((agents, 2, 3))
        self._foot_turns = np.zeros((agents, 2, 3))
        self._roots = np.zeros((agents, 4))
        self._since = np.full(agents, -np.inf)
        self._foot_times = np.full((agents, 2), NUDGE_TIME)

    def add_bodies(self, agents: IntArray, before: Snapshot, after: Snapshot, *, time: float) -> None:
        """Has the bodies of agents go on from `before` a change instead of from `after` it, their feet as they come.

        Args:
            agents: Shape (N,).
            before: As they are seen, nudges before included.
            after: Without any nudge.
            time: Of both [s].
        """
        self._shifts[agents] = before.pelvis_positions - after.pelvis_positions
        self._turns[agents] = _turns(before.rotations, after.rotations)
        roots = before.roots - after.roots
        roots[:, 3] = planar.wrap_angle(roots[:, 3])
        self._roots[agents] = roots
        self._since[agents] = time
        self._ball_shifts[agents] = self._foot_turns[agents] = 0.0

    def add_feet(self, agents: IntArray, before: Snapshot, after: Snapshot, *, landings: FloatArray) -> None:
        """The same for their feet, `after` with the bodies' nudges.

        Args:
            agents: Shape (N,).
            before: As they are seen.
            after: With the nudges of `add_bodies`.
            landings: When their feet are down again, shape (N, 2) [s]; those that stand now, infinite.
        """
        self._ball_shifts[agents] = before.balls - after.balls
        self._foot_turns[agents] = _turns(before.ankles, after.ankles)
        self._foot_times[agents] = np.clip(landings - self._since[agents][:, None], 1e-6, NUDGE_TIME)

    def move_bodies(self, agents: IntArray, time: float, bodies: tuple[wp.array, wp.array, wp.array]) -> None:
        """Adds the differences of agents (N,) to pelvis positions, pelvis rotations and all rotations, in place."""
        frames = np.flatnonzero(time < self._since[agents] + NUDGE_TIME)
        if not frames.size:
            return
        own = agents[frames]
        shares = _left(time - self._since[own], NUDGE_TIME)
        wp.launch(
            nudge_bodies,
            dim=len(frames),
            inputs=[
                wp.array(frames.astype(np.int32), dtype=wp.int32, copy=False),
                wp.array(own.astype(np.int32), dtype=wp.int32, copy=False),
                wp.array(shares.astype(np.float32), dtype=wp.float32, copy=False),
                wp.array(self._shifts, dtype=wp.vec3f, copy=False),
                wp.array(self._turns, dtype=wp.vec3f, copy=False),
                self._pelvis,
                *bodies,
            ],
        )

    def feet(self, agents: IntArray, time: float) -> tuple[FloatArray, FloatArray]:
        """What to shift [m] and turn [rad] the agents' feet by, float32, shape (N, 2, 3) each."""
        shares = _left((time - self._since[agents])[:, None], self._foot_times[agents])[..., None]
        shifts, turns = shares * self._ball_shifts[agents], shares * self._foot_turns[agents]
        return shifts.astype(np.float32), turns.astype(np.float32)

    def roots(self, agents: IntArray, time: float) -> FloatArray:
        """What to add to the agents' roots, shape (N, 4)."""
        return _left(time - self._since[agents], NUDGE_TIME)[:, None] * self._roots[agents]


def _turns(before: FloatArray, after: FloatArray) -> FloatArray:
    """Rotation vectors from the rotations after to those before."""
    return quaternion.to_rotation_vector(quaternion.compose(before, quaternion.inverse(after)))


def _left(elapsed: FloatArray, durations: FloatArray | float) -> FloatArray:
    """From 1 to 0 over the durations, without velocity or acceleration at the ends."""
    x = np.clip(elapsed / durations, 0.0, 1.0)
    left: FloatArray = 1.0 - x * x * x * (10.0 + x * (6.0 * x - 15.0))
    return left
