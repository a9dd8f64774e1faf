"""Blend shapes of clips go along with their steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.engine.plans import way
from usdfoot.engine.animate import PreparedLibrary
from usdfoot.engine.blend_shapes import sample_shapes
from usdfoot.model.clip import ShapeTrack


@pytest.fixture(scope="module")
def with_shapes(walker_library: PreparedLibrary) -> PreparedLibrary:
    """A smile that stays; in every second clip also a blink whose weight is the time since the clip began."""
    clips = []
    for number, clip in enumerate(walker_library.source.clips):
        smile, time = np.full(len(clip.times), 0.25), clip.times - clip.start_time
        names, columns = (("smile",), [smile]) if number % 2 else (("blink", "smile"), [time, smile])
        clips.append(replace(clip, shapes=ShapeTrack(names=names, weights=np.stack(columns, axis=1))))
    source = replace(walker_library.source, clips=tuple(clips))
    return replace(walker_library, source=source, shapes=sample_shapes(source, walker_library.examples))


def test_shapes_are_blended_as_the_steps_and_pass_through_seams(animate, with_shapes):
    (motion,) = animate([way(stand_first=0.6, stand_last=0.6, length=0.6)], library=with_shapes, rate=120.0)
    blink, smile = np.moveaxis(motion.shapes.weights, 1, 0)
    assert motion.shapes.names == ("blink", "smile") and len(blink) == len(motion.times)
    assert_allclose(smile, 0.25, atol=1e-6)
    longest = max(clip.times[-1] - clip.start_time for clip in with_shapes.source.clips)
    assert np.ptp(blink) > 0.05 and np.abs(np.diff(blink)).max() < 2.0 * longest / (0.1 * 120.0)


def test_without_shapes_there_are_none(animate, walker_library):
    assert walker_library.shapes is None and animate([way()])[0].shapes is None
