"""Blend weights of every step; footsteps out of reach are moved to where they are achieved ([B] 4.3, 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.engine.corrections import correct_steps
from usdfoot.engine.flight import centre_flights, natural_flights
from usdfoot.engine.landings import blend_twists, stand_blend, with_steps
from usdfoot.engine.poses import Setup, StepBlend
from usdfoot.engine.queries import step_queries
from usdfoot.engine.reach import beyond_reach, find_high_steps, find_long_steps, give_way
from usdfoot.engine.root import lay_root
from usdfoot.engine.root_goals import RootGoals
from usdfoot.engine.root_weights import RootedSteps, weigh_rooted
from usdfoot.engine.segments import cut_segments
from usdfoot.engine.styles import continue_styles
from usdfoot.engine.time_warps import blended_durations, longest_step
from usdfoot.maths import planar
from usdfoot.maths.planar import GROUND_AXES
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable, with_headings
from usdfoot.model.examples import event_knots
from usdfoot.spaces.landings import left_landings
from usdfoot.spaces.library import FootstepSpaces

GIVE_WAYS = 5
"""How often a foot that was moved comes back farther at most."""

__all__ = ["Landings", "align_events", "reach_footsteps", "weigh_steps"]


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


@dataclass(frozen=True, kw_only=True)
class Reached:
    """How the blended landings of M segments meet their footsteps; zero for those that are not asked for."""

    offsets: FloatArray
    """Footstep as planned minus blended landing, (x, z) [m], shape (M, 2)."""
    hull_distances: FloatArray
    """Footstep as planned to the hull of the space, 0 inside [m], shape (M,)."""
    time_warps: FloatArray
    """Planned duration over the blended one, of all segments, shape (M,)."""
    limited: BoolArray
    """Whether IK may not pull as far as the footstep lies, which is moved then, shape (M,)."""


def reach_footsteps(
    setup: Setup, spaces: FootstepSpaces, wanted: BoolArray, *, blend: StepBlend, reach: FloatArray
) -> tuple[Setup, StepBlend, Reached]:
    """Weights of the `wanted` (M,) segments, none of them a stand; footsteps out of reach are moved.

    A foot that was moved comes back farther where that lets the next footstep be kept.

    Args:
        setup: Contacts as planned.
        spaces: Footstep spaces of the setup's examples.
        wanted: Segments to weigh.
        blend: Of the others.
        reach: Largest distance from blended landing to footstep for each agent [m], shape (A,).
    """
    segments, count, steps = setup.segments, len(setup.segments), np.flatnonzero(wanted)
    limited, moved, given = np.zeros(count, dtype=bool), np.zeros((count, 2)), np.zeros(count, dtype=int)
    hull_distances = np.zeros(count)  # of footsteps that were moved, as planned
    setup, blend, landings = _solve(setup, spaces, steps, blend)
    while True:
        excess = np.zeros((count, 2))
        excess[steps] = beyond_reach(setup, steps, landings.offsets[steps], reach=reach)
        over = wanted & (np.abs(excess).max(axis=1) > setup.options.landing_tolerance) & ~limited
        first = _first_of_agent(segments.agents, over)
        if not first.any():
            break
        excess *= first[:, None]
        shift = np.where(given[:, None] < GIVE_WAYS, give_way(setup, moved, excess), 0.0)
        given += shift.any(axis=1)
        held = first & ~np.isin(segments.agents, segments.agents[shift.any(axis=1)])
        limited |= held
        hull_distances[held] = landings.hull_distances[held]
        shift += excess * held[:, None]
        moved += shift
        setup = _move_targets(setup, shift)
        again = wanted & np.isin(segments.agents, segments.agents[first])
        setup, blend, anew = _solve(setup, spaces, np.flatnonzero(again), blend)
        landings = _merged(landings, anew, again)
    reached = Reached(
        offsets=landings.offsets + moved,
        hull_distances=np.where(limited, hull_distances, landings.hull_distances),
        time_warps=landings.time_warps,
        limited=limited,
    )
    return setup, blend, reached


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


@dataclass(frozen=True, kw_only=True)
class _Solution:
    offsets: FloatArray  # footstep minus blended landing, (x, z) [m], shape (M, 2)
    hull_distances: FloatArray
    time_warps: FloatArray


def _merged(solution: _Solution, other: _Solution, rows: BoolArray) -> _Solution:
    """The solution with the other's values of some segments."""
    return _Solution(
        offsets=np.where(rows[:, None], other.offsets, solution.offsets),
        hull_distances=np.where(rows, other.hull_distances, solution.hull_distances),
        time_warps=np.where(rows, other.time_warps, solution.time_warps),
    )


def _first_of_agent(agents: IntArray, flags: BoolArray) -> BoolArray:
    """Keeps the first flag of each agent only."""
    rows = np.flatnonzero(flags)
    _, index = np.unique(agents[rows], return_index=True)
    first = np.zeros(len(flags), dtype=bool)
    first[rows[index]] = True
    return first


def _move_targets(setup: Setup, shifts: FloatArray) -> Setup:
    """Setup whose landing contacts are moved back by `shifts` (x, z) (M, 2) of the segments that lead to them."""
    positions = setup.contacts.positions.copy()
    steps = np.flatnonzero(~setup.segments.stands)
    targets = setup.segments.supports[steps] + 1
    positions[np.ix_(targets, GROUND_AXES)] -= shifts[steps]
    contacts = replace(setup.contacts, positions=positions)
    return replace(
        setup,
        contacts=contacts,
        path=lay_root(contacts, setup.segments, step_height_share=setup.options.step_height_share),
    )


def _solve(
    setup: Setup, spaces: FootstepSpaces, steps: IntArray, blend: StepBlend
) -> tuple[Setup, StepBlend, _Solution]:
    """Weights of `steps` for contacts as they are; those before the first footsteps are placed by the examples."""
    segments, examples, count = setup.segments, setup.examples, len(setup.segments)
    offsets, hull_distances = np.zeros((count, 2)), np.zeros(count)
    if steps.size:
        queries = step_queries(setup, steps)
        corrected = correct_steps(setup, spaces, queries, corrections=setup.options.corrections)
        corrected = continue_styles(setup, spaces, steps, queries=queries, corrected=corrected)
        offsets[steps] = planar.rotate(queries.headings + queries.turns, corrected.missed)
        hull_distances[steps] = corrected.hull_distances
        twists = blend_twists(setup, queries, examples=corrected.examples, weights=corrected.weights)
        blend = with_steps(blend, steps, examples=corrected.examples, weights=corrected.weights, twists=twists)
    setup = place_departures(setup, blend)
    blended = blended_durations(examples, blend.examples, blend.weights)
    planned = segments.knot_times[:, -1] - segments.knot_times[:, 0]
    warps = np.where(segments.stands, 1.0, planned / blended)
    return setup, blend, _Solution(offsets=offsets, hull_distances=hull_distances, time_warps=warps)


def place_departures(setup: Setup, blend: StepBlend) -> Setup:
    """Puts the contacts before mid-gait starts where, and lets them leave when, the blended swing feet do."""
    contacts, segments, examples = setup.contacts, setup.segments, setup.examples
    first = contacts.first[:-1]
    begins = np.searchsorted(segments.supports, first + 1)
    rows = begins[contacts.steps[first] < 0]
    if not rows.size:
        return setup
    supports = segments.supports[rows]
    weights, chosen = blend.weights[rows], blend.examples[rows]
    departures = np.sum(weights[..., None] * examples.departures[chosen], axis=1)
    headings = contacts.headings[supports]
    positions, yaws, liftoffs = contacts.positions.copy(), contacts.yaws.copy(), contacts.liftoffs.copy()
    positions[np.ix_(supports - 1, GROUND_AXES)] = positions[np.ix_(supports, GROUND_AXES)] + planar.rotate(
        headings, departures
    )
    yaws[supports - 1] = headings + np.sum(weights * examples.departure_yaws[chosen], axis=1)
    durations = segments.ends[rows] - segments.begins[rows]
    share = np.sum(weights * (examples.swing_liftoffs / examples.durations)[chosen], axis=1)
    released = np.minimum(np.clip(share, -0.5, 0.5) * durations, 0.9 * setup.options.stand_time)
    liftoffs[supports - 1] = segments.begins[rows] + released
    contacts = replace(contacts, positions=positions, yaws=yaws, liftoffs=liftoffs)
    contacts = replace(contacts, headings=_keep_start(with_headings(contacts).headings, contacts, supports))
    segments = cut_segments(contacts, setup.options, longest_step=longest_step(examples, setup.options))
    return replace(
        setup,
        contacts=contacts,
        segments=segments,
        path=lay_root(contacts, segments, step_height_share=setup.options.step_height_share),
    )


def _keep_start(headings: FloatArray, contacts: ContactTable, supports: IntArray) -> FloatArray:
    """Headings at the first strikes stay those the weights were found with."""
    kept = headings.copy()
    kept[supports] = contacts.headings[supports]
    kept[supports - 1] = contacts.headings[supports - 1]
    return kept
