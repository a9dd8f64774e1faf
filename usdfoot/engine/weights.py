"""Blend weights of every step: query the footstep space, measure the blended landing, correct ([B] 4.3, Fig. 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.engine.contacts import ContactTable, with_headings
from usdfoot.engine.poses import Setup, StepBlend, device_segments, pose_feet, pose_frames
from usdfoot.engine.queries import ask_spaces, step_queries
from usdfoot.engine.root import lay_root
from usdfoot.engine.segments import cut_segments
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.examples import event_knots
from usdfoot.spaces.library import FootstepSpaces, StepWeights

__all__ = ["Landings", "weigh_steps"]

GROUND_AXES = np.array([0, 2])


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
    """Whether the landing lies farther from the footstep than IK may pull it."""


def weigh_steps(
    setup: Setup, spaces: FootstepSpaces, *, stand: int, reach: FloatArray
) -> tuple[Setup, StepBlend, Landings]:
    """Weights of all segments, footsteps out of reach moved to where they are achieved.

    Args:
        setup: Contacts as planned.
        spaces: Footstep spaces of the setup's examples.
        stand: Index of the example that stands still.
        reach: Largest distance from blended landing to footstep for each agent [m], shape (A,).

    Returns:
        The setup with contacts as executed, the blend of each segment, and how the landings meet.
    """
    limited = np.zeros(len(setup.segments), dtype=bool)
    moved = np.zeros((len(setup.segments), 2))
    setup, blend, landings = _solve(setup, spaces, stand)
    while True:
        excess = _beyond_reach(setup, landings.offsets, reach)
        over = (np.abs(excess).max(axis=1) > 1e-6) & ~limited
        first = _first_of_agent(setup.segments.agents, over)
        if not first.any():
            break
        limited |= first
        shift = excess * first[:, None]
        moved += shift
        setup = _move_targets(setup, shift)
        setup, blend, landings = _solve(setup, spaces, stand)
    return (
        align_events(setup, blend),
        blend,
        Landings(
            blend_error=np.linalg.norm(landings.offsets + moved, axis=1),
            hull_distance=landings.hull_distances,
            time_warp=landings.time_warps,
            limited=limited,
        ),
    )


def _beyond_reach(setup: Setup, offsets: FloatArray, reach: FloatArray) -> FloatArray:
    """How far each landing has to fall short of its footstep, (x, z) [m], shape (M, 2).

    What is left of `offsets` (M, 2) beyond the agents' `reach` (A,), or of the step beyond `longest_step` legs.
    """
    segments, positions = setup.segments, setup.contacts.positions
    distance = np.linalg.norm(offsets, axis=1)
    beyond_ik = offsets * np.maximum(1.0 - reach[segments.agents] / np.maximum(distance, 1e-12), 0.0)[:, None]
    steps = np.flatnonzero(~segments.stands)
    supports = segments.supports[steps]
    grounded = setup.contacts.liftoffs[supports] >= setup.contacts.strikes[supports + 1]
    strides = (positions[supports + 1] - positions[supports])[:, GROUND_AXES]
    longest = np.where(grounded, setup.options.longest_step * setup.leg_length, np.inf)
    beyond_leg = np.zeros_like(offsets)
    lengths = np.linalg.norm(strides, axis=1)
    beyond_leg[steps] = strides * np.maximum(1.0 - longest / np.maximum(lengths, 1e-12), 0.0)[:, None]
    farther = np.linalg.norm(beyond_leg, axis=1) > np.linalg.norm(beyond_ik, axis=1)
    return np.where(farther[:, None], beyond_leg, beyond_ik)


def align_events(setup: Setup, blend: StepBlend) -> Setup:
    """Setup whose events are aligned with the blended examples' as far as that does not hurry the body.

    Where the plan lifts a foot much earlier or later than the examples do, the body keeps its pace and the foot alone
    follows the plan.
    """
    segments, examples = setup.segments, setup.examples
    own, _ = event_knots(
        np.ones(len(examples)),
        examples.swing_liftoffs / examples.durations,
        examples.support_liftoffs / examples.durations,
    )
    blended = np.sum(blend.weights[..., None] * own[blend.examples], axis=1)
    begins = segments.knot_times[:, :1]
    durations = segments.knot_times[:, -1:] - begins
    shares = (segments.knot_times - begins) / durations
    limit = setup.options.event_shift
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


def _solve(setup: Setup, spaces: FootstepSpaces, stand: int) -> tuple[Setup, StepBlend, _Solution]:
    """Weights for contacts as they are; the contacts before the first footsteps are placed by the examples."""
    segments, examples = setup.segments, setup.examples
    steps = np.flatnonzero(~segments.stands)
    blend, offsets, hull = _correct(setup, spaces, steps, _stand_blend(len(segments), stand))
    setup = place_departures(setup, blend)
    blended = np.sum(blend.weights * examples.durations[blend.examples], axis=1)
    planned = segments.knot_times[:, -1] - segments.knot_times[:, 0]
    warps = np.where(segments.stands, 1.0, planned / blended)
    return setup, blend, _Solution(offsets=offsets, hull_distances=hull, time_warps=warps)


def _correct(
    setup: Setup, spaces: FootstepSpaces, steps: IntArray, blend: StepBlend
) -> tuple[StepBlend, FloatArray, FloatArray]:
    """Blend of the steps with what is left of their offsets (M, 2), and the distances from the hull (M,).

    The blended landing is measured and the query moved by what it missed; the chosen examples are weighed anew, twice,
    before others are chosen. Of all tries the best is kept.
    """
    options, count = setup.options, len(setup.segments)
    queries = step_queries(setup, steps)
    offsets, hull, best = np.zeros((count, 2)), np.zeros(count), np.full(len(steps), np.inf)
    landings, chosen = queries.landings, np.zeros((len(steps), 3), dtype=np.intp)
    active = np.arange(len(steps))
    for round_ in range(1 + options.corrections * options.correction):
        asked = queries[active]
        kept = chosen[active] if round_ % 3 else None
        solved = ask_spaces(setup, spaces, asked, landings[active], examples=kept)
        chosen[active] = solved.examples
        if round_ == 0:
            hull[steps] = solved.hull_distances
        rows = steps[active]
        trial = _with_steps(blend, rows, solved, asked.turns, setup.examples.turns)
        missed = _landing_offsets(setup, trial, rows)
        distance = np.linalg.norm(missed, axis=1)
        better = distance < best[active]
        best[active] = np.where(better, distance, best[active])
        blend = _merge(blend, trial, rows[better])
        offsets[rows[better]] = missed[better]
        landings[active] += planar.rotate(-(asked.headings + asked.turns), missed)
        choosing = (round_ + 1) % 3 == 0
        active = active[distance > (options.choice_tolerance if choosing else options.landing_tolerance)]
        if not active.size:
            break
    return blend, offsets, hull


def _stand_blend(count: int, stand: int) -> StepBlend:
    weights = np.zeros((count, 4))
    weights[:, 0] = 1.0
    return StepBlend(examples=np.full((count, 4), stand), weights=weights, twists=np.zeros(count))


def _with_steps(
    blend: StepBlend, steps: IntArray, solved: StepWeights, turns: FloatArray, own_turns: FloatArray
) -> StepBlend:
    """The blend with the steps' three examples, heaviest first, and the twist that their own turns leave."""
    examples, weights, twists = blend.examples.copy(), blend.weights.copy(), blend.twists.copy()
    examples[steps] = solved.examples[:, [0, 1, 2, 0]]
    weights[steps, :3] = solved.weights
    weights[steps, 3] = 0.0
    twists[steps] = planar.wrap_angle(turns - np.sum(solved.weights * own_turns[solved.examples], axis=1))
    return StepBlend(examples=examples, weights=weights, twists=twists)


def _merge(blend: StepBlend, other: StepBlend, rows: IntArray) -> StepBlend:
    """`blend` with the rows of `other`."""
    examples, weights, twists = blend.examples.copy(), blend.weights.copy(), blend.twists.copy()
    examples[rows], weights[rows], twists[rows] = other.examples[rows], other.weights[rows], other.twists[rows]
    return StepBlend(examples=examples, weights=weights, twists=twists)


def _landing_offsets(setup: Setup, blend: StepBlend, steps: IntArray) -> FloatArray:
    """Footstep minus where the blended swing foot is going to be planted, (x, z) [m], shape (N, 2)."""
    contacts, segments, examples = setup.contacts, setup.segments, setup.examples
    poses = pose_frames(
        setup, blend, device_segments(setup, blend), steps, segments.ends[steps], joints=setup.rig.leg_joints
    )
    targets = segments.supports[steps] + 1
    balls = pose_feet(setup.rig, poses).balls[np.arange(len(steps)), contacts.sides[targets]][:, GROUND_AXES]
    settle = examples.landings - examples.swing_balls[:, -1, GROUND_AXES]  # from the strike until the ball is down
    settling = np.sum(blend.weights[steps, :, None] * settle[blend.examples[steps]], axis=1)
    headings = contacts.headings[segments.supports[steps]] + blend.twists[steps]
    landing = balls + planar.rotate(headings, settling)
    target = contacts.positions[targets] - setup.origins[segments.agents[steps]]
    return target[:, GROUND_AXES] - landing


def place_departures(setup: Setup, blend: StepBlend) -> Setup:
    """Puts the contacts before mid-gait starts where, and lets them leave when, the blended swing feet do."""
    contacts, segments, examples = setup.contacts, setup.segments, setup.examples
    first = contacts.first[:-1]
    begins = np.searchsorted(segments.supports, first + 1)
    rows = begins[contacts.steps[first] < 0]
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
    segments = cut_segments(contacts, setup.options)
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
