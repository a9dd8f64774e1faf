"""Steps are no quicker than the clips they are blended from can be hurried."""

import numpy as np
import pytest

from tests.builders import Gait
from tests.engine.walkers import library_of
from usdfoot.analysis.examples import build_examples
from usdfoot.planning.gait import derive_gait
from usdfoot.planning.habits import find_habits
from usdfoot.planning.hurry import MOST_HURRY, unhurried_time
from usdfoot.planning.proportions import Proportions
from usdfoot.spaces.library import build_spaces

SLOW, BRISK = 0.6, 0.48
"""Times of the steps of 0.3 to 0.5 m, and of those of 0.8 m [s]."""


@pytest.fixture(scope="module")
def quickest():
    """The least time of steps of a length [m] that are to take a time [s]."""
    walks = [Gait(step_length=length, step_time=SLOW) for length in (0.3, 0.5)]
    library = library_of([*walks, Gait(step_length=0.8, step_time=BRISK), Gait(step_length=0.5, step_width=0.4)])
    leg_length = library.biped.maximal_leg_length
    examples, _ = build_examples(library, samples=31)
    spaces = build_spaces(examples, leg_length=leg_length)
    body = Proportions(leg_length=leg_length, habits=find_habits(examples, leg_length=leg_length))

    def find(step_length, step_time):
        gait = derive_gait(body, speed=step_length / step_time, step_length=step_length)
        durations = np.asarray(examples.durations, dtype=float)
        return unhurried_time(gait, spaces, durations, style=examples.default_style)

    return find


@pytest.mark.parametrize(("length", "clip_time"), [(0.3, SLOW), (0.4, SLOW), (0.8, BRISK)])
def test_steps_take_no_less_than_their_clips_hurried(quickest, length, clip_time):
    for asked in (0.2, 0.3, 0.37):
        assert quickest(length, asked) == pytest.approx(clip_time / MOST_HURRY, rel=0.025)
    for asked in (0.52, 0.7, 1.0):
        assert quickest(length, asked) == asked


def test_what_is_quick_for_short_steps_is_not_for_long_ones(quickest):
    assert quickest(0.4, 0.42) > 0.42 == quickest(0.8, 0.42)
