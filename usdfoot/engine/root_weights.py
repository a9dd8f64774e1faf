"""Steps that follow the root's velocity as well as their footsteps, weighed by lambda4 ([B] 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import warp as wp

from usdfoot.engine.corrections import correct_steps, empty_blends
from usdfoot.engine.landing_kernel import BlendArrays
from usdfoot.engine.landings import blend_twists, with_steps
from usdfoot.engine.mix_kernel import WIDTH, MixOptions, RootedStep
from usdfoot.engine.poses import Setup, StepBlend
from usdfoot.engine.queries import StepQueries, step_queries
from usdfoot.engine.root_goals import RootGoals
from usdfoot.engine.rooted_kernel import MixedStep, mix_in_turn
from usdfoot.engine.styles import continue_styles
from usdfoot.maths.planar import GROUND_AXES
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.spaces.features import step_coordinates
from usdfoot.spaces.landings import left_landings
from usdfoot.spaces.library import FootstepSpaces
from usdfoot.spaces.roots import RootSteps, fewer_roots, find_roots
from usdfoot.spaces.tetrahedra import SPEED_SCALE

__all__ = ["MIX_CORRECTIONS", "RootedSteps", "root_steps", "weigh_rooted"]


MIX_CORRECTIONS = 2
"""A mix, whose weights are bent at beta, is corrected so many times as often as other blends at most."""


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

    @classmethod
    def of_steps(cls, mixed: Any, rooted: IntArray, count: int) -> RootedSteps:
        """What the device says of the steps `rooted` (N,) among `count` segments, an array of `MixedStep` (N,)."""

        def spread(values: FloatArray | BoolArray) -> Any:
            whole = np.zeros(count, dtype=values.dtype)
            whole[rooted] = values
            return whole

        return cls(
            root_weights=spread(mixed["root_weight"]),
            betas=spread(mixed["beta"]),
            predicted_errors=spread(np.linalg.norm(mixed["expected"], axis=1)),
            blend_errors=spread(np.linalg.norm(mixed["missed"], axis=1)),
            hull_distances=spread(mixed["hull_distance"]),
            given_up=spread(mixed["move"].any(axis=1)),
            limited=spread(mixed["limited"].astype(bool)),
        )


def weigh_rooted(
    setup: Setup, spaces: FootstepSpaces, goals: RootGoals, *, blend: StepBlend, reach: FloatArray
) -> tuple[Setup, StepBlend, RootedSteps]:
    """Weights of the rooted steps.

    Each step is first brought onto its footstep; then the root's examples are mixed in. Where lambda4 goes beyond beta
    the footstep is given up: the foot is planted where the mix lands and the next step starts there. Outside the hull
    IK pulls less and less of what is missing, nothing at lambda4 = 1. Root examples are the plan's wherever a step
    starts, and so are those around its footstep as long as this lies between them.

    Args:
        setup: Contacts as planned.
        spaces: Footstep spaces of the setup's examples.
        goals: Of all segments.
        blend: Takes eight examples a segment where there are rooted steps.
        reach: Largest distance from blended landing to footstep for each agent [m], shape (A,).

    Returns:
        The setup with the rooted steps' contacts as executed, the blend with theirs, and how they land.
    """
    rooted, count = np.flatnonzero(goals.rooted), len(setup.segments)
    if not rooted.size:
        return setup, blend, RootedSteps.none(count)
    queries = replace(step_queries(setup, rooted), speeds=np.linalg.norm(goals.velocities[rooted], axis=1))
    roots = root_steps(setup, spaces, goals, rows=rooted, queries=queries)
    steps = _device_steps(setup, spaces, goals, rooted, queries, roots, reach=reach)
    positions, blends, mixed = _mix(setup, spaces, rooted, queries, steps)
    examples, weights = blends.examples.numpy().astype(np.intp), blends.weights.numpy()
    twists = blend_twists(setup, queries, examples=examples, weights=weights)
    return (
        _planted(setup, positions),
        with_steps(blend, rooted, examples=examples, weights=weights, twists=twists),
        RootedSteps.of_steps(mixed, rooted, count),
    )


def _mix(
    setup: Setup, spaces: FootstepSpaces, rooted: IntArray, queries: StepQueries, steps: wp.array
) -> tuple[FloatArray, BlendArrays, Any]:
    """Where the contacts stand then, (x, z) [m] (C, 2), blends of the segments `rooted` (N,), and what became of them.

    Agents are mixed beside each other, the steps of one in turn: each starts where the last one landed.
    """
    coordinates = step_coordinates(
        left_landings(queries.landings, queries.swing_sides),
        queries.features.as_left(queries.swing_sides),
        spaces.scales,
    )
    firsts = np.flatnonzero(np.diff(setup.segments.agents[rooted], prepend=-1))
    planned = setup.contacts.positions[:, GROUND_AXES]
    positions = wp.array(planned, dtype=wp.vec2d)
    blends, mixed = empty_blends(len(rooted), WIDTH), wp.empty(len(rooted), dtype=MixedStep)
    wp.launch(
        mix_in_turn,
        dim=len(firsts),
        inputs=[
            wp.array(np.append(firsts, len(rooted)), dtype=wp.int32),
            steps,
            spaces.device,
            setup.library,
            _mix_options(setup, spaces),
            wp.array(planned, dtype=wp.vec2d),
        ],
        outputs=[positions, wp.array(coordinates, dtype=wp.float64), blends, mixed],
    )
    return positions.numpy(), blends, mixed.numpy()


def root_steps(
    setup: Setup, spaces: FootstepSpaces, goals: RootGoals, *, rows: IntArray, queries: StepQueries
) -> RootSteps:
    """Root examples of the segments `rows`."""
    return find_roots(
        spaces,
        goals.velocities[rows],
        queries.landings,
        features=queries.features,
        swing_sides=queries.swing_sides,
        flights=queries.flights,
        styles=queries.styles,
        meet=setup.options.correction,
    )


def _planted(setup: Setup, positions: FloatArray) -> Setup:
    """Setup whose contacts stand at (x, z) (C, 2) [m]; its path is not changed."""
    whole = setup.contacts.positions.copy()
    whole[:, GROUND_AXES] = positions
    return replace(setup, contacts=replace(setup.contacts, positions=whole))


def _device_steps(
    setup: Setup,
    spaces: FootstepSpaces,
    goals: RootGoals,
    rows: IntArray,
    queries: StepQueries,
    roots: RootSteps,
    *,
    reach: FloatArray,
) -> wp.array:
    """The rooted segments `rows` as planned, with the examples that land on their footsteps."""
    segments, contacts, sides = setup.segments, setup.contacts, queries.swing_sides
    supports, left = segments.supports[rows], left_landings(queries.landings, sides)
    corrected = correct_steps(setup, spaces, queries, corrections=setup.options.corrections)
    corrected = continue_styles(setup, spaces, rows, queries=queries, corrected=corrected)
    grounded = contacts.liftoffs[supports] >= contacts.strikes[supports + 1]
    table: Any = np.zeros(len(rows), dtype=RootedStep.numpy_dtype())  # type: ignore[attr-defined]
    table["support"], table["swing_side"] = supports, sides
    table["space"] = spaces.numbers(left, swing_sides=sides, flights=queries.flights, styles=queries.styles)
    table["start"], table["end"] = queries.headings, queries.headings + queries.turns
    solid = setup.options.space == "3d"
    table["wanted"], table["epsilon"] = goals.weights[rows], -1.0 if solid else goals.replace_distances[rows]
    table["reach"] = reach[segments.agents[rows]]
    table["longest"] = np.where(grounded, setup.longest_step, np.inf)
    table["corners"], table["hull_distance"] = corrected.examples[:, :3], corrected.hull_distances
    table["speed"] = SPEED_SCALE * queries.speeds
    table["bias"] = corrected.biases
    if solid:
        roots = fewer_roots(roots, WIDTH - 4)
    count = roots.examples.shape[1]
    table["roots"][:, :count], table["root_weights"][:, :count] = roots.examples, roots.weights
    return wp.array(table, dtype=RootedStep)


def _mix_options(setup: Setup, spaces: FootstepSpaces) -> MixOptions:
    options, chosen = setup.options, MixOptions()
    chosen.by_features, chosen.solid = options.space == "neighbours", options.space == "3d"
    chosen.closest = options.beyond_beta == "closest"
    chosen.tolerance = -1.0 if options.root_weight_within is None else options.root_weight_within
    chosen.corrections = MIX_CORRECTIONS * options.corrections * options.correction
    chosen.near = options.landing_tolerance
    chosen.landing_scale, chosen.departure_scale = spaces.scales.landing, spaces.scales.departure
    return chosen
