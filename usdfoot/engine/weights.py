"""Blend weights of every step, and how its landing meets the footstep ([B] 4.3, 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.engine.flight import centre_flights, natural_flights
from usdfoot.engine.landings import stand_blend
from usdfoot.engine.poses import Setup, StepBlend
from usdfoot.engine.reach import find_high_steps, find_long_steps
from usdfoot.engine.reaching import reach_footsteps
from usdfoot.engine.root_goals import RootGoals
from usdfoot.engine.root_weights import RootedSteps, weigh_rooted
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.examples import event_knots
from usdfoot.spaces.landings import left_landings
from usdfoot.spaces.library import FootstepSpaces

__all__ = ["Landings", "align_events", "weigh_steps"]


@dataclass(frozen=True, kw_only=True)
class Landings:
    """How each segment's blended landing meets its footstep; zero for stands. Shape (M,) each."""

    blend_error: FloatArray
    """Blended landing to footstep, horizontal, before IK [m]."""
    hull_distance: FloatArray
    """Footstep to the hull of the space, 0 inside [m]."""
    time_warp: FloatArray
    """Planned duration over the blended one."""
    limited: BoolArray
    """Whether the footstep is given up: IK may not pull so far from the landing, or no leg reaches it."""
    beyond_legs: BoolArray
    """Whether the legs do not reach it."""
    velocity_error: FloatArray
    """Mean root velocity of the blended examples, at their own pace, to the wanted one [m/s]."""
    rooted: RootedSteps
    """Root weights, and what became of the steps that have one."""


def weigh_steps(
    setup: Setup, spaces: FootstepSpaces, goals: RootGoals, *, stand: int, reach: FloatArray
) -> tuple[Setup, StepBlend, Landings]:
    """Weights of all segments, footsteps out of reach moved to where they are achieved.

    Args:
        setup: Contacts as planned.
        spaces: Footstep spaces of the setup's examples.
        goals: What the steps are asked of their root.
        stand: Index of the example that stands still.
        reach: Largest distance from blended landing to footstep for each agent [m], shape (A,).

    Returns:
        The setup with contacts as executed, the blend of each segment, and how the landings meet.
    """
    blend = stand_blend(len(setup.segments), stand, width=8 if goals.rooted.any() else 4)
    planned = setup.contacts.positions
    setup, blend, rooted = weigh_rooted(setup, spaces, goals, blend=blend, reach=reach)
    setup, blend, reached = reach_footsteps(
        setup, spaces, ~setup.segments.stands & ~goals.rooted, blend=blend, reach=reach
    )
    offsets, limited = np.linalg.norm(reached.offsets, axis=1), reached.limited | rooted.limited
    high, long = (np.zeros(len(setup.segments), dtype=bool) for _ in range(2))
    steps = np.flatnonzero(~setup.segments.stands)
    high[steps], long[steps] = find_high_steps(setup, steps), find_long_steps(setup, steps, planned)
    return (
        align_events(setup, blend),
        blend,
        Landings(
            blend_error=np.where(goals.rooted, rooted.blend_errors, offsets),
            hull_distance=np.where(goals.rooted, rooted.hull_distances, reached.hull_distances),
            time_warp=reached.time_warps,
            limited=limited,
            beyond_legs=high | limited & long,
            velocity_error=_velocity_errors(setup, spaces, goals, blend),
            rooted=rooted,
        ),
    )


def _velocity_errors(setup: Setup, spaces: FootstepSpaces, goals: RootGoals, blend: StepBlend) -> FloatArray:
    """Mean root velocity of the blended examples to the wanted one [m/s], shape (M,)."""
    errors = np.zeros(len(setup.segments))
    steps = np.flatnonzero(~setup.segments.stands)
    sides = setup.contacts.sides[setup.segments.supports[steps] + 1]
    wanted = left_landings(goals.velocities[steps], sides)
    blended = np.einsum("nk,nkd->nd", blend.weights[steps], spaces.velocities[blend.examples[steps]])
    errors[steps] = np.linalg.norm(blended - wanted, axis=1)
    return errors


def align_events(setup: Setup, blend: StepBlend) -> Setup:
    """Setup whose events are aligned with the blended examples' as far as that does not hurry the body.

    Where the plan lifts the swinging foot much earlier or later than the examples do, the body keeps its pace and the
    foot alone follows the plan. Flights are centred on the plan's and keep their pace whatever the plan's last.
    """
    natural = natural_flights(setup.examples, blend.examples, blend.weights)
    segments, examples = centre_flights(setup.contacts, setup.segments, natural), setup.examples
    own, _ = event_knots(
        np.ones(len(examples)),
        examples.swing_liftoffs / examples.durations,
        examples.support_liftoffs / examples.durations,
    )
    blended = np.sum(blend.weights[..., None] * own[blend.examples], axis=1)
    begins = segments.knot_times[:, :1]
    durations = segments.knot_times[:, -1:] - begins
    shares = (segments.knot_times - begins) / durations
    limit = setup.options.event_shift * np.array([0.0, 1.0, 0.0, 0.0])
    limited = blended + np.clip(shares - blended, -limit, limit)
    whole = ~segments.stands & (segments.begins == segments.knot_times[:, 0])
    times = np.where(whole[:, None], begins + durations * limited, segments.knot_times)
    blended = np.where(segments.stands[:, None], segments.knot_shares, blended)
    return replace(setup, segments=replace(segments, knot_times=times, knot_shares=blended))
