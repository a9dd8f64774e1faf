"""Clips without a style are grouped by flight, height of the root and speed."""

from __future__ import annotations

import numpy as np

from usdfoot.analysis.styles import group_styles
from usdfoot.analysis.summary import ClipSummary


def clip(name: str, *, speed: float, duty: float = 0.6, height: float = 1.1, **about: object) -> ClipSummary:
    facts: dict = {"style": "default", "steps": 2, "direction": 0.0, **about}
    return ClipSummary(
        name=name,
        contacts=None,
        speed=speed,
        turn_rate=0.0,
        step_lengths=np.zeros(0),
        root_height=height,
        leg_length=0.85,
        duty_factor=duty,
        period=None,
        in_place=False,
        warnings=(),
        **facts,
    )


def test_walks_runs_crawls_and_stands_part() -> None:
    walks = [clip(f"walk{speed}", speed=speed) for speed in (0.2, 0.9, 1.6, 2.2)]
    runs = [clip(f"run{speed}", speed=speed, duty=0.33) for speed in (1.8, 2.9)]
    crawls = [clip(f"crawl{height}", speed=0.5, height=height) for height in (0.55, 0.6)]
    sprint = clip("sprint", speed=6.0, duty=0.25)
    styles = group_styles([*walks, *runs, *crawls, sprint])
    assert {styles[own.name] for own in walks} == {"walk"}
    assert {styles[own.name] for own in runs} == {"run_1"} and styles["sprint"] == "run_2"
    assert {styles[own.name] for own in crawls} == {"low_walk"}


def test_clips_with_a_style_or_without_steps_are_left_alone() -> None:
    named, empty = clip("named", speed=1.0, style="sad"), clip("empty", speed=np.nan, steps=0)
    assert group_styles([named, empty]) == {}
    assert group_styles([named, empty, clip("walk", speed=1.0)]) == {"walk": "walk"}


def test_backward_the_ball_leaves_early_without_flight() -> None:
    back = clip("back", speed=1.0, duty=0.35, direction=np.pi)
    assert group_styles([clip("walk", speed=1.0), back]) == {"walk": "walk", "back": "walk"}


def test_a_run_with_long_contacts_is_told_by_its_pace() -> None:
    walks = [clip("walk", speed=1.4), clip("quick walk", speed=1.8, duty=0.43)]
    assert group_styles([*walks, clip("run", speed=2.6, duty=0.43)])["run"] == "run"
    assert set(group_styles(walks).values()) == {"walk"}
