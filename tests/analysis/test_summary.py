"""Summaries against the analytic walker."""

from dataclasses import replace

import numpy as np
import pytest

from tests.builders import Gait, build_walker, with_clip
from usdfoot.analysis.summary import summarise
from usdfoot.model.clip import AuthoredEvents


@pytest.mark.parametrize("in_place", [False, True])
def test_walk(in_place: bool) -> None:
    walker = build_walker(Gait(), rate=60.0, in_place=in_place, loop=in_place)
    (summary,) = summarise(walker.library)
    assert summary.name == "/Walker/Clips/walk"
    assert summary.in_place == in_place
    assert (summary.period is not None) == in_place
    assert summary.speed == pytest.approx(1.2, abs=0.03)
    assert summary.direction == pytest.approx(0.0, abs=0.02)
    assert summary.duty_factor == pytest.approx(0.62, abs=0.015)
    assert len(summary.step_lengths) == summary.steps
    np.testing.assert_allclose(summary.step_lengths, np.hypot(0.6, 0.16), atol=0.015)


def test_direction_is_against_the_facing() -> None:
    left = summarise(build_walker(Gait(step_length=0.0, sideways=0.2, step_width=0.3)).library)[0]
    back = summarise(build_walker(Gait(step_length=-0.4)).library)[0]
    assert left.direction == pytest.approx(np.pi / 2.0, abs=0.05)
    assert abs(back.direction) == pytest.approx(np.pi, abs=0.05)


def test_turn_rate() -> None:
    summary = summarise(build_walker(Gait(turn=0.2)).library)[0]
    assert summary.turn_rate == pytest.approx(0.4, abs=0.02)


def test_run_has_a_duty_factor_below_a_half() -> None:
    summary = summarise(build_walker(Gait(step_time=0.35, duty=0.32, step_length=1.0)).library)[0]
    assert summary.duty_factor == pytest.approx(0.32, abs=0.03)


def test_unusable_clip_says_why() -> None:
    walker = build_walker()
    events = AuthoredEvents(strike_times=np.array([0.3, 1.3]), liftoff_times=np.array([1.9]))
    (summary,) = summarise(with_clip(walker, events=(events, AuthoredEvents())))
    assert summary.contacts is None
    assert "without a liftoff" in summary.warnings[0]
    standing = replace(walker.clip, translations=walker.clip.translations[:3], rotations=walker.clip.rotations[:3])
    (summary,) = summarise(replace(walker.library, clips=(standing,)))
    assert summary.steps == 0
    assert "no usable step in its range" in summary.warnings
