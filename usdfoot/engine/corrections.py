"""Blends that land on their footsteps: query the footstep space, measure the landing, correct ([B] 4.3, Fig. 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.engine.landings import landing_offsets, merge_blends, with_steps
from usdfoot.engine.poses import Setup, StepBlend
from usdfoot.engine.queries import ask_spaces, step_queries
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.spaces.library import FootstepSpaces

__all__ = ["CorrectedSteps", "correct_steps"]


@dataclass(frozen=True, kw_only=True)
class CorrectedSteps:
    """Blend of the steps asked for, and what is left to miss; 0 for other segments."""

    blend: StepBlend
    offsets: FloatArray
    """Footstep minus blended landing, (x, z) [m], shape (M, 2)."""
    hull_distances: FloatArray
    """Footstep to the hull of the space [m], shape (M,)."""
    landings: FloatArray
    """Landing the weights were solved for, (x, z) in the heading at the step's end [m], shape (M, 2)."""


def correct_steps(setup: Setup, spaces: FootstepSpaces, steps: IntArray, blend: StepBlend) -> CorrectedSteps:
    """The blend with the `steps` solved.

    The blended landing is measured and the query moved by what it missed; the chosen examples are weighed anew, twice,
    before others are chosen. Of all tries the best is kept.
    """
    options, count = setup.options, len(setup.segments)
    queries = step_queries(setup, steps)
    offsets, hull, best = np.zeros((count, 2)), np.zeros(count), np.full(len(steps), np.inf)
    landings, chosen = queries.landings, np.zeros((len(steps), 3), dtype=np.intp)
    kept_landings = np.zeros((count, 2))
    active = np.arange(len(steps))
    for round_ in range(1 + options.corrections * options.correction):
        asked = queries[active]
        kept = chosen[active] if round_ % 3 else None
        solved = ask_spaces(setup, spaces, asked, landings[active], examples=kept)
        chosen[active] = solved.examples
        if round_ == 0:
            hull[steps] = solved.hull_distances
        rows = steps[active]
        own_turns = np.sum(solved.weights * setup.examples.turns[solved.examples], axis=1)
        twists = planar.wrap_angle(asked.turns - own_turns)
        trial = with_steps(blend, rows, solved.examples, solved.weights, twists)
        missed = landing_offsets(setup, trial, rows)
        distance = np.linalg.norm(missed, axis=1)
        better = distance < best[active]
        best[active] = np.where(better, distance, best[active])
        blend = merge_blends(blend, trial, rows[better])
        offsets[rows[better]] = missed[better]
        kept_landings[rows[better]] = landings[active[better]]
        landings[active] += planar.rotate(-(asked.headings + asked.turns), missed)
        choosing = (round_ + 1) % 3 == 0
        active = active[distance > (options.choice_tolerance if choosing else options.landing_tolerance)]
        if not active.size:
            break
    return CorrectedSteps(blend=blend, offsets=offsets, hull_distances=hull, landings=kept_landings)
