"""Hurry: how quickly steps of a length can be taken, as the clips show it."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.planning.gait import Gait, overlap_shares
from usdfoot.spaces.features import StepFeatures
from usdfoot.spaces.library import FootstepSpaces, solve_steps

__all__ = ["MOST_HURRY", "unhurried_time"]

MOST_HURRY = 1.2
"""A step is at most so many times as quick as the clips it is blended from: hurried on more, joints jerk more than 1.2
times as much as theirs (design.md section 10), whatever the length of the steps."""
LONGER = 1.02 ** np.arange(150)
"""Times that are tried over what is asked, the quickest first."""


def unhurried_time(gait: Gait, spaces: FootstepSpaces, durations: FloatArray, *, style: str) -> float:
    """The least time of the even steps of a gait for which no clip has to be hurried too much, or theirs [s].

    Args:
        gait: Steps as asked for.
        spaces: Of the walker's clips.
        durations: Of the examples in the spaces [s], shape (E,).
        style: To walk in.

    Raises:
        ClipError: If the style has no step.
    """
    times, steps = gait.step_time * LONGER, np.ones((len(LONGER), 1))
    overlaps = overlap_shares(gait.step_length / times, gait.rule) * times
    found = solve_steps(
        spaces,
        steps * [gait.step_width, gait.step_length],
        swing_sides=np.zeros(len(times), dtype=np.intp),
        flights=overlaps < 0.0,
        styles=(style,) * len(times),
        features=StepFeatures(
            durations=times,
            swing_liftoffs=overlaps,
            turns=np.zeros(len(times)),
            landing_heights=np.zeros(len(times)),
            departures=steps * [gait.step_width, -gait.step_length],
        ),
    )
    unhurried = MOST_HURRY * times >= np.sum(found.weights * durations[found.examples], axis=1)
    return float(times[np.argmax(unhurried)])
