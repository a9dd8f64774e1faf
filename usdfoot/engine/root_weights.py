"""Steps that follow the root's velocity as well as their footsteps, weighed by lambda4 ([B] 5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import TypeVar

import numpy as np

from usdfoot.engine.corrections import correct_steps
from usdfoot.engine.landings import GROUND_AXES, blend_landings, blend_twists, with_steps
from usdfoot.engine.poses import Setup, StepBlend
from usdfoot.engine.queries import StepQueries, step_queries
from usdfoot.engine.reach import beyond_reach
from usdfoot.engine.root_goals import RootGoals
from usdfoot.engine.styles import continue_styles
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.spaces.library import FootstepSpaces, left_landings
from usdfoot.spaces.root_weight import (
    RootWeighted,
    find_largest_root_weight,
    is_in_triangle,
    replace_corners,
    solve_root_weight,
)
from usdfoot.spaces.roots import find_roots
from usdfoot.spaces.triples import weigh_triples

__all__ = ["RootedSteps", "weigh_rooted"]

_Table = TypeVar("_Table", "_Corners", "_Roots", "_Mix")


@dataclass(frozen=True, kw_only=True)
class RootedSteps:
    """What became of the rooted steps; 0 for other segments. Shape (M,) each."""

    root_weights: FloatArray
    """lambda4 as used."""
    betas: FloatArray
    """Largest lambda4 that still lands on the footstep."""
    predicted_errors: FloatArray
    """Landing to footstep as the closed form says [m]."""
    blend_errors: FloatArray
    """Landing to footstep as measured, before IK [m]."""
    hull_distances: FloatArray
    """Footstep to the hull of the space [m]."""
    given_up: BoolArray
    """Whether the foot stands where it lands instead of on its footstep."""
    limited: BoolArray
    """Whether IK would have had to pull farther than it may."""

    @classmethod
    def none(cls, count: int) -> RootedSteps:
        """No rooted step among `count` segments."""
        return cls(
            root_weights=np.zeros(count),
            betas=np.zeros(count),
            predicted_errors=np.zeros(count),
            blend_errors=np.zeros(count),
            hull_distances=np.zeros(count),
            given_up=np.zeros(count, dtype=bool),
            limited=np.zeros(count, dtype=bool),
        )


@dataclass(frozen=True, kw_only=True)
class _Corners:
    """Examples around the footsteps of N steps."""

    examples: IntArray  # (N, 3)
    biases: FloatArray  # from their mean landing to where their blend lands, left-swing coordinates [m], (N, 2)
    hull_distances: FloatArray  # [m], (N,)


@dataclass(frozen=True, kw_only=True)
class _Roots:
    """Root examples of N steps."""

    examples: IntArray  # (N, 5)
    weights: FloatArray  # (N, 5)
    landings: FloatArray  # where their blend lands as measured, left-swing coordinates [m], (N, 2)


@dataclass(frozen=True, kw_only=True)
class _Mix:
    """N steps mixed from the corners of their footstep and the root's examples; vectors in left-swing coordinates."""

    examples: IntArray  # heaviest first, (N, 8)
    weights: FloatArray  # (N, 8)
    root_weights: FloatArray  # (N,)
    betas: FloatArray  # (N,)
    given_up: FloatArray  # (N,)
    short: FloatArray  # from where the closed form says they land to the footstep [m], (N, 2)
    missed: FloatArray  # from where they land as measured to the footstep [m], (N, 2)
    moves: FloatArray  # from the footstep to where the foot is planted instead [m], 0 up to beta, (N, 2)


def weigh_rooted(
    setup: Setup, spaces: FootstepSpaces, goals: RootGoals, blend: StepBlend, *, reach: FloatArray
) -> tuple[Setup, StepBlend, RootedSteps]:
    """Weights of the rooted steps.

    Each step is first brought onto its footstep; then the root's examples are mixed in. Where lambda4 goes beyond beta
    the footstep is given up: the foot is planted where the mix lands and the next step starts there. Outside the hull
    IK pulls less and less of what is missing, nothing at lambda4 = 1. All steps are mixed at once as planned; then,
    in turn, those that start elsewhere than planned are mixed again.

    Args:
        setup: Contacts as planned.
        spaces: Footstep spaces of the setup's examples.
        goals: Of all segments.
        blend: Takes eight examples a segment where there are rooted steps.
        reach: Largest distance from blended landing to footstep for each agent [m], shape (A,).

    Returns:
        The setup with the rooted steps' contacts as executed, the blend with theirs, and how they land.
    """
    rooted = np.flatnonzero(goals.rooted)
    results = RootedSteps.none(len(setup.segments))
    if not rooted.size:
        return setup, blend, results
    planned, supports = setup.contacts.positions, setup.segments.supports[rooted]
    queries = step_queries(setup, rooted)
    roots = _find_roots(setup, spaces, goals.velocities[rooted], queries)
    corners = _find_corners(setup, spaces, queries, rooted, corrections=setup.options.corrections)
    mix = _mix(setup, spaces, goals, rooted, queries, roots, corners)
    for turn in _in_turn(setup.segments.agents[rooted]):
        moved = np.any(setup.contacts.positions != planned, axis=1)
        stale = turn[moved[supports[turn]] | moved[supports[turn] - 1]]
        if stale.size:
            own = step_queries(setup, rooted[stale])
            kept = _keep_corners(setup, spaces, own, _rows(corners, stale))
            corners = _put(corners, stale, kept)
            again = _mix(setup, spaces, goals, rooted[stale], own, _rows(roots, stale), kept)
            mix = _put(mix, stale, again)
        rows, headings = rooted[turn], (queries.headings + queries.turns)[turn]
        sides = queries.swing_sides[turn]
        moves = planar.rotate(headings, left_landings(mix.moves[turn], sides))
        left = planar.rotate(headings, left_landings(mix.missed[turn], sides)) + moves
        setup = _plant_at(setup, rows, moves)
        excess = beyond_reach(setup, rows, left, reach)
        results.limited[rows] = np.abs(excess).max(axis=1) > 1e-6
        setup = _plant_at(setup, rows, -excess * results.limited[rows, None])
    results.hull_distances[rooted] = corners.hull_distances
    results.root_weights[rooted], results.betas[rooted] = mix.root_weights, mix.betas
    results.predicted_errors[rooted] = np.linalg.norm(mix.short, axis=1)
    results.blend_errors[rooted] = np.linalg.norm(mix.missed, axis=1)
    results.given_up[rooted] = mix.moves.any(axis=1)
    twists = blend_twists(setup, queries, mix.examples, mix.weights)
    return setup, with_steps(blend, rooted, mix.examples, mix.weights, twists), results


def _in_turn(agents: IntArray) -> Iterator[IntArray]:
    """Where the first step of every agent is among `agents` (N,), sorted, then the second, and so on."""
    ranks = np.arange(len(agents)) - np.searchsorted(agents, agents)
    for rank in range(int(ranks.max()) + 1):
        yield np.flatnonzero(ranks == rank)


def _plant_at(setup: Setup, rows: IntArray, moves: FloatArray) -> Setup:
    """Setup whose landing contacts of the segments `rows` are moved by (x, z) (N, 2) [m]; its path is not."""
    if not moves.any():
        return setup
    positions = setup.contacts.positions.copy()
    positions[np.ix_(setup.segments.supports[rows] + 1, GROUND_AXES)] += moves
    return replace(setup, contacts=replace(setup.contacts, positions=positions))


def _rows(table: _Table, rows: IntArray) -> _Table:
    """The rows of all arrays of a table."""
    return replace(table, **{field.name: getattr(table, field.name)[rows] for field in fields(table)})


def _put(table: _Table, rows: IntArray, other: _Table) -> _Table:
    """The table with `rows` replaced by those of another."""
    arrays = {}
    for field in fields(table):
        values = getattr(table, field.name).copy()
        values[rows] = getattr(other, field.name)
        arrays[field.name] = values
    return replace(table, **arrays)


def _find_roots(setup: Setup, spaces: FootstepSpaces, velocities: FloatArray, queries: StepQueries) -> _Roots:
    """Root examples of all rooted steps; they are the plan's wherever a step starts."""
    sides = queries.swing_sides
    found = find_roots(
        spaces,
        velocities,
        queries.landings,
        features=queries.features,
        swing_sides=sides,
        flights=queries.flights,
        styles=queries.styles,
        meet=setup.options.correction,
    )
    landed = left_landings(blend_landings(setup.examples, setup.library, sides, found.examples, found.weights), sides)
    return _Roots(examples=found.examples, weights=found.weights, landings=landed)


def _find_corners(
    setup: Setup, spaces: FootstepSpaces, queries: StepQueries, rows: IntArray, *, corrections: int
) -> _Corners:
    """The examples that land on the footsteps, and how much nearer their blend lands than their landings say."""
    corrected = correct_steps(setup, spaces, queries, corrections=corrections)
    if corrections:
        corrected = continue_styles(setup, spaces, rows, queries, corrected)
    sides = queries.swing_sides
    _, nearest = weigh_triples(spaces.landings[corrected.examples], left_landings(corrected.landings, sides))
    landed = left_landings(queries.landings - corrected.missed, sides)
    return _Corners(examples=corrected.examples, biases=landed - nearest, hull_distances=corrected.hull_distances)


def _keep_corners(setup: Setup, spaces: FootstepSpaces, queries: StepQueries, corners: _Corners) -> _Corners:
    """The corners where they still are around footsteps that have moved, else others."""
    wanted = left_landings(queries.landings, queries.swing_sides) - corners.biases
    outside = np.flatnonzero(~is_in_triangle(wanted, spaces.landings[corners.examples]))
    if not outside.size:
        return corners
    return _put(corners, outside, _find_corners(setup, spaces, queries[outside], outside, corrections=0))


def _mix(
    setup: Setup,
    spaces: FootstepSpaces,
    goals: RootGoals,
    rows: IntArray,
    queries: StepQueries,
    roots: _Roots,
    corners: _Corners,
) -> _Mix:
    """The mix whose measured landing is nearest to the one the closed form says.

    A blend of poses lands a little off the blend of the landings: the corners' and the root's own blends are measured
    beforehand, what their mix adds is measured here, and all are weighed as if they landed that much elsewhere.
    """
    options, sides = setup.options, queries.swing_sides
    wanted = left_landings(queries.landings, sides)
    own, replaced = replace_corners(
        spaces.landings[corners.examples],
        wanted - corners.biases,
        spaces.landings[roots.examples],
        goals.replace_distances[rows],
    )
    found = np.take_along_axis(roots.examples, np.maximum(replaced, 0), axis=1)
    examples = np.where(replaced >= 0, found, corners.examples)
    own, shifts = own + corners.biases[:, None], np.zeros_like(wanted)

    def mixed(part: IntArray) -> _Mix:
        around, root = own[part] + shifts[part, None], roots.landings[part] + shifts[part]
        weights, nearest = weigh_triples(around, wanted[part])
        short = wanted[part] - nearest
        solved = _solve_weights(setup, goals.weights[rows[part]], around, weights, root, short)
        moves = solved.shifts - solved.given_up[:, None] * short
        near = np.linalg.norm(moves, axis=1) <= options.landing_tolerance
        moves[near | (solved.given_up <= 0.0)] = 0.0
        all_examples = np.concatenate([examples[part], roots.examples[part]], axis=1)
        all_weights = np.concatenate([solved.weights, solved.root_weights[:, None] * roots.weights[part]], axis=1)
        order = np.argsort(-all_weights, axis=1, kind="stable")
        chosen, weighed = (np.take_along_axis(values, order, axis=1) for values in (all_examples, all_weights))
        landed = left_landings(blend_landings(setup.examples, setup.library, sides[part], chosen, weighed), sides[part])
        return _Mix(
            examples=chosen,
            weights=weighed,
            root_weights=solved.root_weights,
            betas=solved.betas,
            given_up=solved.given_up,
            short=short - solved.shifts,
            missed=wanted[part] - landed,
            moves=moves,
        )

    active = np.arange(len(rows))
    best = mixed(active)
    rests, least = best.missed - best.short, np.linalg.norm(best.missed - best.short, axis=1)
    for _ in range(options.corrections * options.correction):
        active = active[np.linalg.norm(rests, axis=1) > options.landing_tolerance]
        if not active.size:
            break
        shifts[active] -= rests[np.linalg.norm(rests, axis=1) > options.landing_tolerance]
        again = mixed(active)
        rests = again.missed - again.short
        lengths = np.linalg.norm(rests, axis=1)
        better = np.flatnonzero(lengths < least[active])
        least[active[better]] = lengths[better]
        best = _put(best, active[better], _rows(again, better))
    return best


def _solve_weights(
    setup: Setup,
    wanted: FloatArray,
    corners: FloatArray,
    weights: FloatArray,
    landings: FloatArray,
    short: FloatArray,
) -> RootWeighted:
    """lambda_1..4 of steps that want lambda4 (N,), less where a tolerance limits it."""
    options = setup.options
    if options.root_weight_within is not None:
        tolerances = np.full(len(wanted), options.root_weight_within)
        largest = find_largest_root_weight(
            corners, weights, landings, tolerances, offsets=-short, beyond=options.beyond_beta
        )
        wanted = np.minimum(wanted, largest)
    return solve_root_weight(corners, weights, landings, wanted, beyond=options.beyond_beta)
