"""Clip plans: the footsteps that a clip left, as a plan."""

from __future__ import annotations

import numpy as np

from usdfoot.analysis.world import WorldClip
from usdfoot.maths import quaternion
from usdfoot.model.plan import FootstepPlan

__all__ = ["plan_of"]


def plan_of(world: WorldClip, *, scale: float = 1.0, whole: bool = False) -> FootstepPlan:
    """The longest row of alternating footsteps in a clip, on a clock that starts with its first sample.

    Args:
        world: The clip.
        scale: Factor on its lengths.
        whole: All of the clip; otherwise its range and one stride on either side.

    Raises:
        PlanError: If the footsteps are no plan, for want of them or in their order.
    """
    feet = [world.contacts[side] for side in (0, 1)]
    sides = np.repeat([0, 1], [len(foot.strike_times) for foot in feet])
    strikes, liftoffs, yaws, positions = (
        np.concatenate([getattr(foot, name) for foot in feet])
        for name in ("strike_times", "liftoff_times", "yaws", "positions")
    )
    finite = np.isfinite(strikes) & np.isfinite(liftoffs)
    if not whole:
        clip = world.clip
        begin = world.start if clip.range_start is None else clip.range_start
        end = world.end if clip.range_end is None else clip.range_end
        stride = 2.0 * float(np.median(np.diff(np.sort(strikes[finite])))) if finite.sum() > 1 else 0.0
        finite &= (strikes > begin - 1.05 * stride) & (strikes < end + 1.05 * stride)
    order = np.flatnonzero(finite)
    order = order[np.argsort(strikes[order], kind="stable")]
    breaks = np.flatnonzero(np.diff(sides[order]) == 0) + 1
    rows = max(np.split(order, breaks), key=len)
    clock = float(world.clip.times[0])
    return FootstepPlan(
        name=world.clip.name,
        sides=sides[rows],
        positions=scale * positions[rows],
        orientations=quaternion.yaw_quaternion(yaws[rows]),
        strike_times=strikes[rows] - clock,
        liftoff_times=liftoffs[rows] - clock,
        root_weights=np.zeros(len(rows)),
    )
