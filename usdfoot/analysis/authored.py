"""Authored events: contact times an artist corrected, which replace the detected ones."""

from __future__ import annotations

import numpy as np

from usdfoot.analysis.contact_options import ContactOptions
from usdfoot.analysis.contacts import flat_times
from usdfoot.analysis.motion import FootMotion
from usdfoot.errors import ClipError
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import SIDES
from usdfoot.model.clip import AuthoredEvents, Clip
from usdfoot.model.contacts import Contacts, FootContacts

__all__ = ["with_authored_events"]


def with_authored_events(
    contacts: Contacts,
    clip: Clip,
    motion: FootMotion,
    *,
    period: float | None,
    ball_heights: FloatArray,
    options: ContactOptions,
) -> Contacts:
    """Contacts in which authored strikes, flats and liftoffs stand in for the detected ones of the same foot.

    Args:
        contacts: Detected contacts.
        clip: The clip as it was read, with its authored events.
        motion: World trajectories of the feet, of a loop for three cycles.
        period: Duration of a cycle [s]; None if the clip is no loop.
        ball_heights: Ball joints above the sole [m], shape (2,).
        options: Thresholds.

    Raises:
        ClipError: If authored events are out of order.
    """
    feet = []
    for side in range(2):
        events = clip.events[side]
        authored = (events.strike_times, events.flat_times, events.liftoff_times)
        if all(times is None for times in authored):
            feet.append(contacts[side])
            continue
        strikes, liftoffs = _paired(clip, SIDES[side], events, contacts[side], period)
        flats = _flats(strikes, liftoffs, _tiled(events.flat_times, period), contacts[side], options)
        feet.append(_placed(strikes, flats, liftoffs, contacts[side], motion, side, ball_heights[side]))
    return Contacts(left=feet[0], right=feet[1])


def _tiled(times: FloatArray | None, period: float | None) -> FloatArray | None:
    """Times in order, of a loop those of the cycle before and after added."""
    if times is None:
        return None
    times = np.sort(np.asarray(times, dtype=float))
    return times if period is None else np.unique(np.concatenate([times - period, times, times + period]).round(9))


def _paired(
    clip: Clip, label: str, events: AuthoredEvents, detected: FootContacts, period: float | None
) -> tuple[FloatArray, FloatArray]:
    """Strikes and the liftoff that ends each contact [s], (K,) each, -inf and +inf where the clip cuts them off."""
    strikes, liftoffs = _tiled(events.strike_times, period), _tiled(events.liftoff_times, period)
    both = strikes is not None and liftoffs is not None
    strikes = detected.strike_times[np.isfinite(detected.strike_times)] if strikes is None else strikes
    liftoffs = detected.liftoff_times[np.isfinite(detected.liftoff_times)] if liftoffs is None else liftoffs
    limits = np.append(strikes[1:], np.inf)
    following = np.append(liftoffs, np.inf)[np.searchsorted(liftoffs, strikes, side="right")]
    missing = following > limits
    if both and missing.any():
        raise ClipError(
            clip.name,
            f"two {label} strikes without a liftoff between them",
            f"author one of usdfoot:clip:{label}:liftoffTimes after each of usdfoot:clip:{label}:strikeTimes",
            [f"{time:.4g} s" for time in strikes[missing]],
        )
    ends = np.where(missing, strikes + 0.6 * (limits - strikes), following)
    early = liftoffs[liftoffs <= (strikes[0] if strikes.size else np.inf)]
    if early.size:
        strikes, ends = np.append(-np.inf, strikes), np.append(early[-1], ends)
    return strikes, ends


def _flats(
    strikes: FloatArray,
    liftoffs: FloatArray,
    authored: FloatArray | None,
    detected: FootContacts,
    options: ContactOptions,
) -> FloatArray:
    """Flat of each contact: the authored, else the detected one inside it, else the latest allowed."""
    known = authored if authored is not None else detected.flat_times[np.isfinite(detected.flat_times)]
    candidates = np.append(known, np.inf)[np.searchsorted(known, strikes)]
    inside = candidates <= liftoffs
    if authored is not None:
        return np.where(inside & np.isfinite(candidates) & np.isfinite(strikes), candidates, strikes)
    return flat_times(strikes, np.where(inside, candidates, liftoffs), liftoffs, options=options)


def _placed(
    strikes: FloatArray,
    flats: FloatArray,
    liftoffs: FloatArray,
    detected: FootContacts,
    motion: FootMotion,
    side: int,
    ball_height: float,
) -> FootContacts:
    """Contacts with the mean place of the ball while planted."""
    balls, forward = motion.balls[:, side], (motion.balls - motion.ankles)[:, side][:, [0, 2]]
    positions, yaws, ball_first = [], [], []
    for start, end in zip(flats, liftoffs, strict=True):
        inside = (motion.times >= start) & (motion.times <= end)
        if not inside.any():
            nearest = np.clip(0.5 * (start + end), motion.times[0], motion.times[-1])
            inside[np.argmin(np.abs(motion.times - nearest))] = True
        positions.append(balls[inside].mean(axis=0) - np.array([0.0, ball_height, 0.0]))
        yaws.append(planar.circular_mean(planar.yaw_of(forward[inside])))
        overlap = np.minimum(end, detected.liftoff_times) - np.maximum(start, detected.strike_times)
        ball_first.append(bool(overlap.size and overlap.max() > 0.0 and detected.ball_first[np.argmax(overlap)]))
    return FootContacts(
        strike_times=strikes,
        flat_times=flats,
        liftoff_times=liftoffs,
        positions=np.array(positions).reshape(-1, 3),
        yaws=np.array(yaws, dtype=float),
        ball_first=np.array(ball_first, dtype=bool),
    )
