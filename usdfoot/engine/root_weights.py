"""Steps that follow the root's velocity as well as their footsteps, weighed by lambda4 ([B] 5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from usdfoot.engine.corrections import CorrectedSteps, correct_steps
from usdfoot.engine.landings import GROUND_AXES, beyond_reach, landing_offsets, with_steps
from usdfoot.engine.poses import Setup, StepBlend
from usdfoot.engine.queries import StepQueries, step_queries
from usdfoot.engine.root_goals import RootGoals
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.spaces.library import FootstepSpaces, left_landings
from usdfoot.spaces.root_weight import (
    RootWeighted,
    find_largest_root_weight,
    replace_corners,
    root_landing,
    solve_root_weight,
)
from usdfoot.spaces.roots import RootSteps, solve_roots
from usdfoot.spaces.triples import weigh_triples

__all__ = ["RootedSteps", "weigh_rooted"]


@dataclass(frozen=True, kw_only=True)
class RootedSteps:
    """What became of the rooted steps; 0 for other segments. Shape (M,) each."""

    root_weights: FloatArray
    """lambda4 as used."""
    betas: FloatArray
    """Largest lambda4 that still lands on the footstep; 0 where lambda4 is 0, as no root examples are looked for."""
    predicted_errors: FloatArray
    """Landing to footstep as the closed form says [m]."""
    blend_errors: FloatArray
    """Landing to footstep as measured, before IK [m]."""
    hull_distances: FloatArray
    """Footstep to the hull of the space [m]."""
    velocity_errors: FloatArray
    """Mean root velocity of the root examples to the wanted one [m/s]."""
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
            velocity_errors=np.zeros(count),
            given_up=np.zeros(count, dtype=bool),
            limited=np.zeros(count, dtype=bool),
        )


@dataclass(frozen=True, kw_only=True)
class _Mix:
    """N steps mixed from the corners of their footstep and the root's examples."""

    examples: IntArray  # (N, 8)
    weights: FloatArray  # (N, 8)
    twists: FloatArray
    solved: RootWeighted
    short: FloatArray  # from what the corners reach to the footstep, left-swing coordinates [m], (N, 2)
    missed: FloatArray  # footstep minus measured landing, world (x, z) [m], (N, 2)
    rest: FloatArray  # of `missed` what the closed form does not say, left-swing coordinates [m], (N, 2)


def weigh_rooted(
    setup: Setup, spaces: FootstepSpaces, goals: RootGoals, blend: StepBlend, *, reach: FloatArray
) -> tuple[Setup, StepBlend, RootedSteps]:
    """Weights of the rooted steps, one after the other, since each starts where the last one landed.

    Each step is first brought onto its footstep; then the root's examples are mixed in. Where lambda4 goes beyond beta
    the footstep is given up: the foot is planted where the mix lands and the next step starts there. Outside the hull
    IK pulls less and less of what is missing, nothing at lambda4 = 1.

    Args:
        setup: Contacts as planned.
        spaces: Footstep spaces of the setup's examples.
        goals: Of all segments.
        blend: Takes eight examples a segment where there are rooted steps.
        reach: Largest distance from blended landing to footstep for each agent [m], shape (A,).

    Returns:
        The setup with the rooted steps' contacts as executed, the blend with theirs, and how they land.
    """
    results = RootedSteps.none(len(setup.segments))
    for rows in _in_turn(setup, goals.rooted):
        corrected = correct_steps(setup, spaces, rows, blend)
        blend = corrected.blend
        missed, moves = corrected.offsets[rows], np.zeros((len(rows), 2))
        results.hull_distances[rows] = corrected.hull_distances[rows]
        results.predicted_errors[rows] = np.linalg.norm(missed, axis=1)
        mixed = np.flatnonzero((goals.weights[rows] > 0.0) | (goals.replace_distances[rows] > 0.0))
        if mixed.size:
            own = rows[mixed]
            queries = step_queries(setup, own)
            roots = _ask_roots(setup, spaces, goals, own, queries)
            mix = _correct_mix(setup, spaces, goals, own, queries, roots, corrected)
            blend = with_steps(blend, own, mix.examples, mix.weights, mix.twists)
            missed[mixed], moves[mixed] = mix.missed, _moves(mix, queries, setup.options.landing_tolerance)
            results.root_weights[own], results.betas[own] = mix.solved.root_weights, mix.solved.betas
            results.predicted_errors[own] = np.linalg.norm(mix.short - mix.solved.shifts, axis=1)
            results.velocity_errors[own] = roots.errors
        results.given_up[rows] = moves.any(axis=1)
        results.blend_errors[rows] = np.linalg.norm(missed, axis=1)
        setup = _plant_at(setup, rows, moves)
        left = np.zeros((len(setup.segments), 2))  # for IK
        left[rows] = missed + moves
        excess = beyond_reach(setup, left, reach)[rows]
        results.limited[rows] = np.abs(excess).max(axis=1) > 1e-6
        setup = _plant_at(setup, rows, -excess)
    return setup, blend, results


def _in_turn(setup: Setup, rooted: BoolArray) -> Iterator[IntArray]:
    """The first rooted step of every agent, then the second, and so on."""
    rows = np.flatnonzero(rooted)
    agents = setup.segments.agents[rows]
    ranks = np.arange(len(rows)) - np.searchsorted(agents, agents)
    for rank in range(int(ranks.max(initial=-1)) + 1):
        yield rows[ranks == rank]


def _plant_at(setup: Setup, rows: IntArray, moves: FloatArray) -> Setup:
    """Setup whose landing contacts of the segments `rows` are moved by (x, z) (N, 2) [m]; its path is not."""
    positions = setup.contacts.positions.copy()
    positions[np.ix_(setup.segments.supports[rows] + 1, GROUND_AXES)] += moves
    return replace(setup, contacts=replace(setup.contacts, positions=positions))


def _ask_roots(
    setup: Setup, spaces: FootstepSpaces, goals: RootGoals, rows: IntArray, queries: StepQueries
) -> RootSteps:
    return solve_roots(
        spaces,
        goals.velocities[rows],
        queries.landings,
        swing_sides=queries.swing_sides,
        flights=queries.flights,
        styles=(setup.style,) * len(rows),
    )


def _correct_mix(
    setup: Setup,
    spaces: FootstepSpaces,
    goals: RootGoals,
    rows: IntArray,
    queries: StepQueries,
    roots: RootSteps,
    corrected: CorrectedSteps,
) -> _Mix:
    """The mix whose measured landing is nearest to the one the closed form says.

    A blend of poses lands a little off the blend of the landings. This bias is measured, and the corners are weighed
    for the footstep less the bias, which also moves beta; the root's examples keep their weights.
    """
    options, sides = setup.options, queries.swing_sides
    wanted = left_landings(queries.landings, sides)
    examples = corrected.blend.examples[rows, :3]
    corners, others = spaces.landings[examples], spaces.landings[roots.examples]
    _, nearest = weigh_triples(corners, left_landings(corrected.landings[rows], sides))
    bias = wanted - _to_left(queries, corrected.offsets[rows]) - nearest
    corners, replaced = replace_corners(corners, wanted - bias, others, goals.replace_distances[rows])
    found = np.take_along_axis(roots.examples, np.maximum(replaced, 0), axis=1)
    examples = np.where(replaced >= 0, found, examples)
    landings = root_landing(others, roots.weights)

    def mixed(bias: FloatArray) -> _Mix:
        weights, nearest = weigh_triples(corners, wanted - bias)
        short = wanted - bias - nearest
        solved = _solve_weights(setup, goals.weights[rows], corners, weights, landings, short)
        return _measure(setup, rows, queries, examples, roots, solved, short, corrected.blend)

    best = last = mixed(bias)
    for _ in range(options.corrections * options.correction):
        if np.all(np.linalg.norm(best.rest, axis=1) <= options.landing_tolerance):
            break
        bias = bias - last.rest
        last = mixed(bias)
        best = _better(best, last)
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


def _measure(
    setup: Setup,
    rows: IntArray,
    queries: StepQueries,
    examples: IntArray,
    roots: RootSteps,
    solved: RootWeighted,
    short: FloatArray,
    blend: StepBlend,
) -> _Mix:
    """The mix with its landing measured; its examples heaviest first."""
    own = np.concatenate([examples, roots.examples], axis=1)
    weights = np.concatenate([solved.weights, solved.root_weights[:, None] * roots.weights], axis=1)
    order = np.argsort(-weights, axis=1, kind="stable")
    own, weights = np.take_along_axis(own, order, axis=1), np.take_along_axis(weights, order, axis=1)
    twists = planar.wrap_angle(queries.turns - np.sum(weights * setup.examples.turns[own], axis=1))
    missed = landing_offsets(setup, with_steps(blend, rows, own, weights, twists), rows)
    rest = _to_left(queries, missed) - (short - solved.shifts)
    return _Mix(examples=own, weights=weights, twists=twists, solved=solved, short=short, missed=missed, rest=rest)


def _better(first: _Mix, second: _Mix) -> _Mix:
    """Of each step the mix that lands nearer to where the closed form says."""
    chosen = np.linalg.norm(second.rest, axis=1) < np.linalg.norm(first.rest, axis=1)
    rows = chosen[:, None]
    return _Mix(
        examples=np.where(rows, second.examples, first.examples),
        weights=np.where(rows, second.weights, first.weights),
        twists=np.where(chosen, second.twists, first.twists),
        solved=RootWeighted(
            weights=np.where(rows, second.solved.weights, first.solved.weights),
            root_weights=np.where(chosen, second.solved.root_weights, first.solved.root_weights),
            betas=np.where(chosen, second.solved.betas, first.solved.betas),
            given_up=np.where(chosen, second.solved.given_up, first.solved.given_up),
            shifts=np.where(rows, second.solved.shifts, first.solved.shifts),
        ),
        short=np.where(rows, second.short, first.short),
        missed=np.where(rows, second.missed, first.missed),
        rest=np.where(rows, second.rest, first.rest),
    )


def _moves(mix: _Mix, queries: StepQueries, tolerance: float) -> FloatArray:
    """From each footstep to where the foot is planted instead, world (x, z) [m], shape (N, 2); 0 up to beta."""
    moves = mix.solved.shifts - mix.solved.given_up[:, None] * mix.short
    moves[(mix.solved.given_up <= 0.0) | (np.linalg.norm(moves, axis=1) <= tolerance)] = 0.0
    return planar.rotate(queries.headings + queries.turns, left_landings(moves, queries.swing_sides))


def _to_left(queries: StepQueries, vectors: FloatArray) -> FloatArray:
    """World ground vectors (N, 2) in the heading at each step's end, as if the left foot swung."""
    return left_landings(planar.rotate(-(queries.headings + queries.turns), vectors), queries.swing_sides)
