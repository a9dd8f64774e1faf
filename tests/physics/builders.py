"""Plans and bipeds with known proportions."""

import numpy as np

from usdfoot.analysis.footstep_times import time_footsteps
from usdfoot.maths import quaternion
from usdfoot.model.plan import FootstepPlan
from usdfoot.physics.biped import PhysicsBiped


def human() -> PhysicsBiped:
    """Proportions of a person of 1.75 m."""
    return PhysicsBiped(
        name="/Human",
        hips=np.array([[0.09, -0.047, 0.0], [-0.09, -0.047, 0.0]]),
        pelvis=np.array([0.0, 0.03, 0.0]),
        pelvis_rotation=np.array([0.0, 0.0, 0.0, 1.0]),
        nominal_length=0.82,
        maximal_length=0.86,
        ankles=np.tile([0.0, 0.08, -0.12], (2, 1)),
        heel=-0.17,
        toe=0.06,
    )


def plan_of(positions, *, yaws=None, strikes=None, liftoffs=None, first_side=0, **timing) -> FootstepPlan:
    """A plan through positions (N, 3), timed from the footprints alone unless times are given."""
    positions = np.asarray(positions, dtype=float)
    count = len(positions)
    times = time_footsteps(positions, **timing) if strikes is None else None
    return FootstepPlan(
        name="/Plan",
        sides=(np.arange(count) + first_side) % 2,
        positions=positions,
        orientations=quaternion.yaw_quaternion(np.zeros(count) if yaws is None else yaws),
        strike_times=times.strike_times if times else np.asarray(strikes, dtype=float),
        liftoff_times=times.liftoff_times if times else np.asarray(liftoffs, dtype=float),
        root_weights=np.zeros(count),
    )


def walk(count=12, *, length=0.7, width=0.12, rise=0.0, turn=0.0, lengths=None, **timing) -> FootstepPlan:
    """Steps straight ahead, up stairs, along an arc, or of single lengths (count - 1,)."""
    headings = turn * np.arange(count)
    strides = np.full(count, length) if lengths is None else np.append(lengths, 0.0)
    ahead = strides[:, None] * np.column_stack([np.sin(headings), np.cos(headings)])
    middle = np.concatenate([np.zeros((1, 2)), np.cumsum(ahead, axis=0)[:-1]])
    aside = np.where(np.arange(count) % 2 == 0, 0.5, -0.5) * width
    across = np.column_stack([np.cos(headings), -np.sin(headings)])
    ground = middle + aside[:, None] * across
    positions = np.column_stack([ground[:, 0], rise * np.arange(count), ground[:, 1]])
    return plan_of(positions, yaws=headings, **timing)
