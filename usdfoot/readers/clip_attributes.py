"""What UsdfootClipAPI authors on a SkelAnimation: style, range, root motion and contact events."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pxr import Usd

from usdfoot.bridge.tokens import Clip as Token
from usdfoot.bridge.tokens import ClipSource, RootMotion
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import ClipError
from usdfoot.maths.types import FloatArray
from usdfoot.model.clip import AuthoredEvents
from usdfoot.readers.authored import authored

__all__ = ["ClipAttributes", "read_clip_attributes"]


@dataclass(frozen=True, kw_only=True)
class ClipAttributes:
    """Authored values, or what stands for their absence; fields as in `usdfoot.model.clip.Clip`."""

    style: str
    root_motion: str
    cyclic: bool | None
    range_start: float | None
    """[s]"""
    range_end: float | None
    """[s]"""
    mirror: bool
    events: tuple[AuthoredEvents, AuthoredEvents]
    synthetic: bool


def read_clip_attributes(prim: Usd.Prim, times: FloatArray, units: StageUnits) -> ClipAttributes:
    """The attributes of a clip whose samples are at `times` [s], with or without UsdfootClipAPI.

    Raises:
        ClipError: If a token is unknown, the range or all events lie outside the samples, or events are out of order.
    """
    start, end = _range(prim, times, units)
    return ClipAttributes(
        style=str(authored(prim, Token.STYLE) or "default"),
        root_motion=_root_motion(prim),
        cyclic=_optional_bool(prim, Token.CYCLIC),
        range_start=start,
        range_end=end,
        mirror=_optional_bool(prim, Token.MIRROR) is not False,
        events=_events_inside(prim, times, units),
        synthetic=_is_synthetic(prim),
    )


def _is_synthetic(prim: Usd.Prim) -> bool:
    """Whether a program made the clip: by its attribute or, where that is not authored, by its customData."""
    value = authored(prim, Token.SOURCE)
    if value is None:
        return bool(prim.GetCustomDataByKey("synthetic"))
    if str(value) not in ClipSource.ALL:
        raise ClipError(prim.GetPath(), f"{Token.SOURCE} is {value}", f"author one of {', '.join(ClipSource.ALL)}")
    return str(value) == ClipSource.SYNTHETIC


def _root_motion(prim: Usd.Prim) -> str:
    value = str(authored(prim, Token.ROOT_MOTION) or RootMotion.AUTO)
    if value not in RootMotion.ALL:
        raise ClipError(prim.GetPath(), f"{Token.ROOT_MOTION} is {value}", f"author one of {', '.join(RootMotion.ALL)}")
    return value


def _optional_bool(prim: Usd.Prim, name: str) -> bool | None:
    value = authored(prim, name)
    return None if value is None else bool(value)


def _range(prim: Usd.Prim, times: FloatArray, units: StageUnits) -> tuple[float | None, float | None]:
    """Authored start and end of the range to use [s]."""
    start, end = _time(prim, Token.START, units), _time(prim, Token.END, units)
    first, last = times[0] if start is None else start, times[-1] if end is None else end
    if not first < last or first >= times[-1] or last <= times[0]:
        raise ClipError(
            prim.GetPath(),
            f"has the range {first:.4g} to {last:.4g} s but samples from {times[0]:.4g} to {times[-1]:.4g} s",
            f"author {Token.START} before {Token.END}, both within the samples",
        )
    return start, end


def _time(prim: Usd.Prim, name: str, units: StageUnits) -> float | None:
    value = authored(prim, name)
    return None if value is None else float(units.codes_to_times(np.array(value, dtype=float)))


def _events_inside(prim: Usd.Prim, samples: FloatArray, units: StageUnits) -> tuple[AuthoredEvents, AuthoredEvents]:
    """Contact events of both feet. The last may end beyond the samples, but not all of them lie there."""
    left, right = _events(prim, 0, units), _events(prim, 1, units)
    given = [events for foot in (left, right) for events in vars(foot).values() if events is not None]
    times = np.sort(np.concatenate(given)) if given else np.zeros(0)
    if len(times) and not ((times >= samples[0]) & (times <= samples[-1])).any():
        span = f"from {samples[0]:.4g} to {samples[-1]:.4g} s"
        what = f"contact times from {times[0]:.4g} to {times[-1]:.4g} s lie outside its samples {span}"
        raise ClipError(prim.GetPath(), what, "author them in the time codes of the clip")
    return left, right


def _events(prim: Usd.Prim, side: int, units: StageUnits) -> AuthoredEvents:
    """Contact events an artist authored for one foot."""
    return AuthoredEvents(
        strike_times=_event_times(prim, Token.STRIKE_TIMES[side], units),
        flat_times=_event_times(prim, Token.FLAT_TIMES[side], units),
        liftoff_times=_event_times(prim, Token.LIFTOFF_TIMES[side], units),
    )


def _event_times(prim: Usd.Prim, name: str, units: StageUnits) -> FloatArray | None:
    value = authored(prim, name)
    if value is None:
        return None
    times = units.codes_to_times(np.array(value, dtype=float))
    if not np.isfinite(times).all() or np.any(np.diff(times) <= 0.0):
        raise ClipError(prim.GetPath(), f"{name} do not increase", "author event times in order")
    return times
