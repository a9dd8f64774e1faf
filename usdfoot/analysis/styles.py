"""Styles for clips that have none, from what their bodies do ([B] 7)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage

from usdfoot.analysis.gaits import has_flight
from usdfoot.analysis.summary import ClipSummary
from usdfoot.maths.types import BoolArray, FloatArray

__all__ = ["NO_STYLE", "group_styles"]

NO_STYLE = "default"
"""Style of clips that name none."""
HEIGHT_GAP, SPEED_GAP = 0.12, 1.2
"""Leg lengths and m/s between neighbours from which on clips are of two styles."""
LOW = 0.12
"""Groups whose roots are this much lower than the highest group's [leg lengths] are called low."""
STILL = 0.15
"""Slower groups stand [m/s]."""


def group_styles(summaries: Sequence[ClipSummary]) -> dict[str, str]:
    """Styles by clip name, of the clips with steps whose style is NO_STYLE.

    Clips with flight (`has_flight`; going backward the ball leaves the ground early without any) are apart from those
    without. Among
    either, groups part where height of the root or speed has a gap (single linkage), so walks of all speeds stay
    together as long as there are some in between. A group is named after what it does: idle, walk or run, "low_"
    before it if the root is low, and a number from the slowest on if that is the name of several.

    Args:
        summaries: Of the clips of one skeleton.
    """
    clips = [summary for summary in summaries if summary.steps and summary.style == NO_STYLE]
    if not clips:
        return {}
    heights = np.array([clip.root_height for clip in clips])
    speeds = np.array([clip.speed for clip in clips])
    flies = _fly(clips)
    features = np.column_stack([2.0 * flies, heights / HEIGHT_GAP, speeds / SPEED_GAP])
    groups = np.ones(1, dtype=int)
    if len(clips) > 1:
        groups = fcluster(linkage(features, method="single", metric="chebyshev"), 1.0, criterion="distance")
    order = sorted(set(groups), key=lambda group: float(speeds[groups == group].mean()))
    highest = max(float(heights[groups == group].mean()) for group in order)
    gaits = [_gait(flies[own], heights[own] < highest - LOW, speeds[own]) for own in (groups == g for g in order)]
    names = {}
    for index, (group, gait) in enumerate(zip(order, gaits, strict=True)):
        names[group] = gait if gaits.count(gait) == 1 else f"{gait}_{gaits[:index].count(gait) + 1}"
    return {clip.name: names[group] for clip, group in zip(clips, groups, strict=True)}


def _fly(clips: Sequence[ClipSummary]) -> BoolArray:
    """Which clips fly, taking each as even steps of its mean speed and contact, shape (N,)."""
    stances, speeds, directions, legs = np.array(
        [(2.0 * clip.duty_factor, clip.speed, clip.direction, clip.leg_length) for clip in clips]
    ).T
    landings = np.column_stack([np.zeros_like(speeds), speeds])  # of steps of 1 s
    flights = has_flight(np.ones_like(speeds), stances, landings, leg_length=legs)
    return np.asarray(flights & (np.abs(directions) < 0.5 * np.pi))


def _gait(flies: BoolArray, low: BoolArray, speeds: FloatArray) -> str:
    gait = "run" if flies.all() else "walk" if speeds.mean() > STILL else "idle"
    return f"low_{gait}" if low.mean() > 0.5 else gait
