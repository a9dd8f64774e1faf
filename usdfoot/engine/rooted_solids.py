"""Root weights in the space of landing and root speed ([B] 7), which takes the triangle's place.

The root's examples weigh lambda4 and land on r; the tetrahedra are asked for the rest, with the wanted speed: for the
landing p that brings the mix onto the footstep q, q = (1 - lambda4) p + lambda4 r. beta is where p leaves the hull.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

import numpy as np

from usdfoot.engine.landings import blend_landings, blend_twists, with_steps
from usdfoot.engine.mix_kernel import FARTHEST, SETTLES, SLOPE
from usdfoot.engine.poses import Setup, StepBlend
from usdfoot.engine.queries import StepQueries, ask_tetrahedra, step_queries
from usdfoot.engine.reach import beyond_reach
from usdfoot.engine.root_goals import RootGoals
from usdfoot.engine.root_weights import MIX_CORRECTIONS, RootedSteps, root_steps
from usdfoot.maths import planar
from usdfoot.maths.planar import GROUND_AXES
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.spaces.footsteps import solve_footsteps
from usdfoot.spaces.library import FootstepSpaces, SideSpace, left_landings
from usdfoot.spaces.roots import RootSteps
from usdfoot.spaces.segments import cast_on_segments

__all__ = ["weigh_solid"]

ROOT_EXAMPLES = 4
"""Root examples beside the four of a tetrahedron."""
PARTS = np.linspace(0.0, 1.0, 65)[1:]
"""Of the way Newton's method says: where along it the miss turns is looked for."""
INWARD = 1e-6
"""How far along its way a ray is looked at to tell whether it leaves the hull at once."""


@dataclass(frozen=True, kw_only=True)
class _Asked:
    """What is asked of N steps."""

    queries: StepQueries
    root_weights: FloatArray  # lambda4 as wanted (N,)
    roots: RootSteps
    root_landings: FloatArray  # in the heading at the step's end [m], (N, 2)

    def __getitem__(self, rows: IntArray) -> _Asked:
        return _Asked(
            queries=self.queries[rows],
            root_weights=self.root_weights[rows],
            roots=RootSteps(examples=self.roots.examples[rows], weights=self.roots.weights[rows]),
            root_landings=self.root_landings[rows],
        )


@dataclass(frozen=True, kw_only=True)
class _Mix:
    """N steps; vectors in the heading at the step's end [m], (N, 2) each."""

    examples: IntArray  # heaviest first, (N, 8)
    weights: FloatArray  # (N, 8)
    root_weights: FloatArray  # (N,)
    betas: FloatArray  # (N,)
    hull_distances: FloatArray  # (N,)
    expected: FloatArray  # from where they should land to the footstep
    missed: FloatArray  # from where they land as measured to the footstep
    moves: FloatArray  # from the footstep to where the foot is planted instead
    shifts: FloatArray  # what everything was said to land beside where it says

    def __getitem__(self, rows: IntArray) -> _Mix:
        return _Mix(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})

    @property
    def strays(self) -> FloatArray:
        """From where they land as measured to where they should [m], shape (N, 2)."""
        return self.missed - self.expected

    @property
    def distances(self) -> FloatArray:
        """How far that is [m], shape (N,)."""
        return np.asarray(np.linalg.norm(self.strays, axis=1))


def weigh_solid(
    setup: Setup, spaces: FootstepSpaces, goals: RootGoals, blend: StepBlend, *, reach: FloatArray
) -> tuple[Setup, StepBlend, RootedSteps]:
    """As `weigh_rooted`, in the space of landing and root speed; replacement distances mean nothing here."""
    rooted = np.flatnonzero(goals.rooted)
    results = RootedSteps.none(len(setup.segments))
    if not rooted.size:
        return setup, blend, results
    roots = _fewer(root_steps(setup, spaces, goals, rooted, step_queries(setup, rooted)))
    for turn in _in_turn(setup.segments.agents[rooted]):
        rows = rooted[turn]
        speeds = np.linalg.norm(goals.velocities[rows], axis=1)
        queries = replace(step_queries(setup, rows), speeds=speeds)
        own = RootSteps(examples=roots.examples[turn], weights=roots.weights[turn])
        landings = _land(setup, queries, own.examples, own.weights)
        asked = _Asked(queries=queries, root_weights=goals.weights[rows], roots=own, root_landings=landings)
        mix = _mix(setup, spaces, asked)
        blend = with_steps(
            blend, rows, mix.examples, mix.weights, blend_twists(setup, queries, mix.examples, mix.weights)
        )
        headings = queries.headings + queries.turns
        moves = planar.rotate(headings, mix.moves)
        setup = _plant_at(setup, rows, moves)
        excess = beyond_reach(setup, rows, planar.rotate(headings, mix.missed) + moves, reach)
        results.limited[rows] = np.abs(excess).max(axis=1) > 1e-6
        setup = _plant_at(setup, rows, -excess * results.limited[rows, None])
        results.root_weights[rows], results.betas[rows] = mix.root_weights, mix.betas
        results.predicted_errors[rows] = np.linalg.norm(mix.expected, axis=1)
        results.blend_errors[rows] = np.linalg.norm(mix.missed, axis=1)
        results.hull_distances[rows] = mix.hull_distances
        results.given_up[rows] = mix.moves.any(axis=1)
    return setup, blend, results


def _in_turn(agents: IntArray) -> Iterator[IntArray]:
    """Where the first step of every agent is among `agents` (N,), sorted, then the second, and so on."""
    ranks = np.arange(len(agents)) - np.searchsorted(agents, agents)
    for rank in range(int(ranks.max(initial=-1)) + 1):
        yield np.flatnonzero(ranks == rank)


def _plant_at(setup: Setup, rows: IntArray, moves: FloatArray) -> Setup:
    """Setup whose landing contacts of the segments `rows` are moved by (x, z) (N, 2) [m]; its path is not."""
    positions = setup.contacts.positions.copy()
    positions[np.ix_(setup.segments.supports[rows] + 1, GROUND_AXES)] += moves
    return replace(setup, contacts=replace(setup.contacts, positions=positions))


def _fewer(roots: RootSteps) -> RootSteps:
    """The heaviest ROOT_EXAMPLES; what the next one weighs is taken off all of them, so none leaves with a jump."""
    examples, weights = _ordered(roots.examples, roots.weights)
    kept = weights[:, :ROOT_EXAMPLES] - weights[:, ROOT_EXAMPLES:]
    kept = np.where(kept.sum(axis=1, keepdims=True) > 0.0, kept, weights[:, :ROOT_EXAMPLES])
    return RootSteps(examples=examples[:, :ROOT_EXAMPLES], weights=kept / kept.sum(axis=1, keepdims=True))


def _mix(setup: Setup, spaces: FootstepSpaces, asked: _Asked) -> _Mix:
    """The mix whose measured landing is nearest to the one expected.

    A mix of blends lands a little off the mix of their landings; all are weighed as if they landed that much elsewhere,
    which the misses of two rounds correct. Each step is for itself: it is left when it is near, whatever others do.
    """
    options = setup.options
    shifts: FloatArray = np.zeros_like(asked.root_landings)
    best = _try(setup, spaces, asked, shifts)
    missed: FloatArray = best.strays
    moved: FloatArray = missed
    rows = np.arange(len(missed))
    for _ in range(MIX_CORRECTIONS * options.corrections * options.correction):
        far = np.flatnonzero(best.distances[rows] > options.landing_tolerance)
        if not far.size:
            return best
        rows, missed, moved = rows[far], missed[far], moved[far]
        shifts[rows] -= moved
        again = _try(setup, spaces, asked[rows], shifts[rows])
        missed, missed_before = again.strays, missed
        moved = _heading_changes(missed, missed_before, moved)
        best = _nearer(best, rows, again)
    far = rows[best.distances[rows] > options.landing_tolerance]
    for one in far[:, None] if options.correction else ():
        best = _nearer(best, one, _settle(setup, spaces, asked[one], best.shifts[one]))
    return best


def _nearer(mixes: _Mix, rows: IntArray, tried: _Mix) -> _Mix:
    """The mixes, with those tried for `rows` in the place of such as are farther off."""
    better = np.flatnonzero(tried.distances < mixes.distances[rows])
    found = {field.name: getattr(mixes, field.name).copy() for field in fields(_Mix)}
    for name, values in found.items():
        values[rows[better]] = getattr(tried, name)[better]
    return _Mix(**found)


def _settle(setup: Setup, spaces: FootstepSpaces, asked: _Asked, shifts: FloatArray) -> _Mix:
    """The mix of one step that Newton's method finds from shifts (1, 2) [m] on, as `mix_kernel.settle_mix` has it."""
    here = best = _try(setup, spaces, asked, shifts)
    for _ in range(SETTLES):
        if best.distances[0] <= setup.options.landing_tolerance:
            break
        beside = _try(setup, spaces, asked[np.zeros(2, dtype=np.intp)], here.shifts + SLOPE * np.eye(2))
        slopes = (beside.strays - here.strays).T / SLOPE
        way = -np.linalg.lstsq(slopes, here.strays[0], rcond=None)[0]
        way *= min(1.0, FARTHEST * here.distances[0] / max(np.linalg.norm(way), 1e-12))
        ways = _try(setup, spaces, asked[np.zeros(len(PARTS), dtype=np.intp)], here.shifts + PARTS[:, None] * way)
        turns = np.append(np.flatnonzero(ways.strays @ here.strays[0] <= 0.0), len(PARTS) - 1)
        best = _nearer(best, np.zeros(1, dtype=np.intp), ways[np.argsort(ways.distances)[:1]])
        here = ways[turns[:1]]
    return best


def _heading_changes(missed: FloatArray, missed_before: FloatArray, moved: FloatArray) -> FloatArray:
    """By what to move queries next [m], shape (N, 2), as `correction_kernel.heading_change` has it."""
    turns = missed - missed_before
    parts = (missed * turns).sum(axis=1) / np.maximum((turns * turns).sum(axis=1), 1e-30)
    return missed - np.clip(parts, -1.0, 1.0)[:, None] * (moved + turns)


def _try(setup: Setup, spaces: FootstepSpaces, asked: _Asked, shifts: FloatArray) -> _Mix:
    """The mix if everything lands `shifts` (N, 2) [m] beside where it says."""
    queries, wanted, roots, root_landings = asked.queries, asked.root_weights, asked.roots, asked.root_landings
    options, footsteps = setup.options, queries.landings - shifts
    nearest, betas = _find_betas(spaces, queries, footsteps, root_landings)
    lacking, root_weights = footsteps - nearest, wanted.copy()
    if options.root_weight_within is not None:
        within, lengths = options.root_weight_within, np.linalg.norm(root_landings - footsteps, axis=1)
        share = np.where(lengths > within, within / np.maximum(lengths, 1e-12), 1.0)
        root_weights = np.minimum(wanted, betas + (1.0 - betas) * share)
    given_up = np.clip((root_weights - betas) / np.maximum(1.0 - betas, 1e-12), 0.0, 1.0)
    used = (root_weights if options.beyond_beta == "closest" else np.minimum(root_weights, betas))[:, None]
    inner, _ = _project(spaces, queries, nearest + used / np.maximum(1.0 - used, 1e-6) * (nearest - root_landings))
    solved, share = ask_tetrahedra(spaces, queries, inner), root_weights[:, None]
    examples, weights = _ordered(
        np.concatenate([solved.examples, roots.examples], axis=1),
        np.concatenate([(1.0 - share) * solved.weights, share * roots.weights], axis=1),
    )
    landings = (1.0 - share) * inner + share * root_landings
    moves = landings - nearest - given_up[:, None] * lacking
    moves[(given_up <= 0.0) | (np.linalg.norm(moves, axis=1) <= options.landing_tolerance)] = 0.0
    return _Mix(
        examples=examples,
        weights=weights,
        root_weights=root_weights,
        betas=betas,
        hull_distances=np.linalg.norm(lacking, axis=1),
        expected=footsteps - landings,
        missed=queries.landings - _land(setup, queries, examples, weights),
        moves=moves,
        shifts=shifts.copy(),
    )


def _project(spaces: FootstepSpaces, queries: StepQueries, landings: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Nearest landings in the hulls of the steps' spaces (N, 2), and how far they are (N,) [m]."""
    left, projected = left_landings(landings, queries.swing_sides), np.zeros_like(landings)
    for space, steps in _grouped(spaces, queries):
        projected[steps] = solve_footsteps(space.footsteps, left[steps]).projections
    return left_landings(projected, queries.swing_sides), np.linalg.norm(left - projected, axis=1)


def _find_betas(
    spaces: FootstepSpaces, queries: StepQueries, footsteps: FloatArray, roots: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Footsteps or the hull's nearest points to them (N, 2), and the largest lambda4 that still lands there (N,).

    With lambda4 the landing asked of the tetrahedra goes away from the root's: by lambda4 / (1 - lambda4) ways.
    """
    nearest, _ = _project(spaces, queries, footsteps)
    ways = nearest - roots
    _, outside = _project(spaces, queries, nearest + INWARD * ways)
    origins, directions = (left_landings(values, queries.swing_sides) for values in (nearest, ways))
    multiples: FloatArray = np.zeros(len(ways))
    for space, steps in _grouped(spaces, queries):
        edges = space.footsteps.vertices[space.footsteps.edges]
        multiples[steps] = cast_on_segments(edges, origins[steps], directions[steps])
    betas = np.where(np.isinf(multiples), 1.0, multiples / (1.0 + np.where(np.isinf(multiples), 0.0, multiples)))
    return nearest, np.where(outside > 0.5 * INWARD * np.linalg.norm(ways, axis=1), 0.0, betas)


def _grouped(spaces: FootstepSpaces, queries: StepQueries) -> Iterator[tuple[SideSpace, IntArray]]:
    """The spaces of the steps, each with its own."""
    left, sides = left_landings(queries.landings, queries.swing_sides), queries.swing_sides
    return spaces.group(left, swing_sides=sides, flights=queries.flights, styles=queries.styles)


def _ordered(examples: IntArray, weights: FloatArray) -> tuple[IntArray, FloatArray]:
    """Examples and weights (N, K), heaviest first."""
    order = np.argsort(-weights, axis=1, kind="stable")
    return np.take_along_axis(examples, order, axis=1), np.take_along_axis(weights, order, axis=1)


def _land(setup: Setup, queries: StepQueries, examples: IntArray, weights: FloatArray) -> FloatArray:
    """Where blends land, (x, z) in the heading at the step's end [m], shape (N, 2)."""
    examples, weights = _ordered(examples, weights)
    return blend_landings(setup.library, queries.swing_sides, examples, weights)
