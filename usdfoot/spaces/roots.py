"""The root examples of steps: which of a library's examples move the root as wanted, and where they land."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.spaces.library import FootstepSpaces, left_landings
from usdfoot.spaces.root_velocity import pick_heaviest, solve_root_velocities

__all__ = ["ROOT_EXAMPLES", "RootSteps", "solve_roots"]

ROOT_EXAMPLES = 5
"""Root examples a step is blended from: with the three of its footstep, as many as the kernels take."""


@dataclass(frozen=True, kw_only=True)
class RootSteps:
    """Root examples of N steps, heaviest first."""

    examples: IntArray
    """Index into the library's examples, shape (N, ROOT_EXAMPLES)."""
    weights: FloatArray
    """Not negative, sum 1, shape (N, ROOT_EXAMPLES)."""
    errors: FloatArray
    """Distance of their mean root velocity from the wanted one [m/s], shape (N,)."""


def solve_roots(
    spaces: FootstepSpaces,
    velocities: FloatArray,
    landings: FloatArray,
    *,
    swing_sides: IntArray,
    flights: BoolArray,
    styles: Sequence[str],
) -> RootSteps:
    """Root examples and weights of steps, from the same style, gait and swing side as their footstep's examples.

    Of examples with nearly the same root velocity, wide and narrow steps for example, it is the one that lands nearest
    to the footstep.

    Args:
        spaces: From `build_spaces`.
        velocities: Wanted root velocities, (x, z) in the heading at the step's end [m/s], shape (N, 2).
        landings: Of the footsteps, (x, z) in the heading at the step's end [m], shape (N, 2).
        swing_sides: 0 = left, 1 = right, shape (N,).
        flights: Whether the support foot lifts off before the swing foot strikes, shape (N,).
        styles: Style of each step, N of them.

    Raises:
        ClipError: If a style has no step of a swing side.
    """
    count = len(velocities)
    queries = left_landings(velocities, swing_sides)
    examples, weights = np.zeros((count, ROOT_EXAMPLES), dtype=np.intp), np.zeros((count, ROOT_EXAMPLES))
    errors = np.zeros(count)
    left = left_landings(landings, swing_sides)
    for space, steps in spaces.group(left, swing_sides=swing_sides, flights=flights, styles=styles):
        solved = solve_root_velocities(space.roots, queries[steps])
        vertices, weights[steps] = pick_heaviest(solved.weights[:, space.roots.vertices], ROOT_EXAMPLES)
        members = space.roots.members[vertices]  # (n, ROOT_EXAMPLES, most)
        away = np.sum((spaces.landings[space.examples[members]] - left[steps][:, None, None]) ** 2, axis=-1)
        nearest = np.argmin(np.where(members >= 0, away, np.inf), axis=2)
        picked = np.take_along_axis(members, nearest[..., None], axis=2)[..., 0]
        examples[steps] = space.examples[picked]
        blended = np.einsum("nk,nkd->nd", weights[steps], space.roots.velocities[picked])
        errors[steps] = np.linalg.norm(blended - queries[steps], axis=1)
    return RootSteps(examples=examples, weights=weights, errors=errors)
