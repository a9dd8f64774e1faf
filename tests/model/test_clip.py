"""Clips: their clock, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from usdfoot.errors import ClipError
from usdfoot.model.clip import Clip


def clip(frames: int, *, joints: int = 2, value: float = 0.0) -> Clip:
    return Clip(
        name="/Clips/Walk",
        rate=30.0,
        start_time=2.0,
        translations=np.full((frames, 2, 3), value),
        rotations=np.tile([0.0, 0.0, 0.0, 1.0], (frames, joints, 1)),
    )


def test_samples_are_on_the_stages_clock() -> None:
    assert_allclose(clip(4).times, 2.0 + np.arange(4) / 30.0)


@pytest.mark.parametrize(
    ("frames", "changes", "message"),
    [
        (1, {}, r"/Clips/Walk: has 1 sample\(s\). a clip needs at least two"),
        (4, {"joints": 3}, r"translations \(4, 2, 3\) do not match rotations \(4, 3, 4\)"),
        (4, {"value": np.inf}, "has values that are not finite"),
    ],
)
def test_inconsistent_clips_are_refused(frames: int, changes: dict, message: str) -> None:
    with pytest.raises(ClipError, match=message):
        clip(frames, **changes)
