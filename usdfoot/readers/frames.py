"""Frames: the time codes at which a crowd has samples."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from usdfoot.bridge.scene import StageInfo
from usdfoot.errors import SceneError
from usdfoot.maths.types import FloatArray
from usdfoot.model.limits import check_limit
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.trajectory import RootTrajectory

__all__ = ["find_frames", "frames_problems", "rate_problems", "spans_of"]

_ROUNDING = 1e-6
_FEWEST, _MOST = 10.0, 240.0
"""Samples a second: fewer than any film has, more than any camera takes."""
_ORDINARY = 30.0


def spans_of(walks: Iterable[FootstepPlan | RootTrajectory], info: StageInfo) -> FloatArray:
    """Time codes at which each of W walks begins and ends, a plan with its first strike and last liftoff, (W, 2)."""
    return info.units.times_to_codes(np.array([(walk.start, walk.end) for walk in walks]).reshape(-1, 2))


def find_frames(spans: FloatArray, info: StageInfo, frames: tuple[int, int] | None, *, most: int) -> FloatArray:
    """Whole time codes, those asked for or those around all walks, shape (F,)."""
    if frames is not None:
        if frames[1] < frames[0]:
            raise SceneError("frames", f"{frames[0]}:{frames[1]} is empty", "give the first and the last time code")
        check_limit("frames", "frames", frames[1] - frames[0] + 1, limit=most)
        return np.arange(frames[0], frames[1] + 1, dtype=float)
    if not len(spans):
        return np.zeros(1)
    start, end = spans.min(), spans.max()
    check_limit(info.identifier, "frames", end - start + 1, limit=most)
    return np.arange(np.floor(start + _ROUNDING), np.ceil(end - _ROUNDING) + 1.0)


def frames_problems(spans: FloatArray, codes: FloatArray) -> list[Problem]:
    """A warning if nobody walks in the frames."""
    if not len(spans) or ((spans[:, 0] <= codes[-1]) & (spans[:, 1] >= codes[0])).any():
        return []
    message = (
        f"frames: nobody walks in {codes[0]:g}:{codes[-1]:g}, all hold a pose. plans and trajectories lie in "
        f"{spans.min():g}:{spans.max():g}"
    )
    return [Problem(severity="warning", where="frames", message=message)]


def rate_problems(info: StageInfo, every: int) -> list[Problem]:
    """A warning where samples are so many that files burst, or so few that planted feet drift between them.

    There is one at each time code: framesPerSecond is only how fast viewers play.

    Args:
        info: Of the stage.
        every: Of how many frames one is taken of those who are far.
    """
    rate = info.units.time_codes_per_second
    if rate > _MOST * every:
        remedy = f"take fewer with --every {rate / _ORDINARY:.0f}, or author a lower rate with times that fit it"
        what = "each agent has a sample at each of them"
    elif rate < _FEWEST:
        remedy, what = "author 24 or more, with times that fit it", "feet drift between samples that far apart"
    else:
        return []
    message = f"{info.identifier}: has {rate:g} time codes a second, {what}. {remedy}"
    return [Problem(severity="warning", where=info.identifier, message=message)]
