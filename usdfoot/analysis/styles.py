"""Styles for clips that have none, from what their bodies do ([B] 7)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage

from usdfoot.analysis.summary import ClipSummary
from usdfoot.maths.types import BoolArray, FloatArray

__all__ = ["NO_STYLE", "group_styles"]

NO_STYLE = "default"
"""Style of clips that name none."""
HEIGHT_GAP, SPEED_GAP = 0.12, 1.2
"""Leg lengths and m/s between neighbours from which on clips are of two styles."""
FLYING = 0.4
"""Part of a stride a foot stands below which a clip flies: by ball contacts even quick walks come near 0.4."""
LOW = 0.12
"""Groups whose roots are this much lower than the highest group's [leg lengths] are called low."""
STILL = 0.15
"""Slower groups stand [m/s]."""


def group_styles(summaries: Sequence[ClipSummary]) -> dict[str, str]:
    """Styles by clip name, of the clips with steps whose style is NO_STYLE.

    Clips with flight (going backward the ball leaves the ground early without any) are apart from those without. Among
    either, groups part where height of the root or speed has a gap (single linkage), so walks of all speeds stay
    together as long as there are some in between. A group is named after what it does: idle, walk or run, "low_"
    before it if the root is low, and a number from the slowest on if that is the name of several.

    Args:
        summaries: Of the clips of one skeleton.
    """
    clips = [summary for summary in summaries if summary.steps and summary.style == NO_STYLE]
    if not clips:
        return {}
    flies = np.array([clip.duty_factor < FLYING and abs(clip.direction) < 0.5 * np.pi for clip in clips])
    heights = np.array([clip.root_height for clip in clips])
    speeds = np.array([clip.speed for clip in clips])
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


def _gait(flies: BoolArray, low: BoolArray, speeds: FloatArray) -> str:
    gait = "run" if flies.all() else "walk" if speeds.mean() > STILL else "idle"
    return f"low_{gait}" if low.mean() > 0.5 else gait
