"""Options of contact detection."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["LEG_LENGTH", "ContactOptions"]

LEG_LENGTH = 0.8
"""Leg that lengths and speeds of the options are for; they scale with the leg [m]."""


@dataclass(frozen=True, kw_only=True)
class ContactOptions:
    """Thresholds of contact detection; lengths and speeds are for a leg of LEG_LENGTH and scale with the leg."""

    fine_rate: float = 240.0
    """Least number of samples a second the events are looked for in [Hz]."""
    smoothing: float = 0.003
    """Standard deviation of the smoothing of positions where instants are found [s]."""
    calming: float = 0.012
    """The same where contacts are told from swings [s]."""
    still_fraction: float = 0.08
    """A point is still below this fraction of the fastest it moves nearby."""
    still_limits: tuple[float, float] = (0.1, 0.8)
    """Least and greatest speed below which a point is still [m/s]."""
    neighbourhood: float = 0.5
    """How far to look for the fastest motion [s]."""
    hysteresis: float = 1.6
    """A contact goes on until the speed exceeds this multiple of the threshold."""
    shortest_contact: float = 0.05
    """Shorter contacts are dropped [s]."""
    touch_spacing: float = 0.15
    """A shorter stillness of a foot at its lowest counts too where no contact is this near [s]."""
    shortest_swing: float = 0.07
    """Shorter gaps between contacts are closed [s]."""
    median_width: float = 0.03
    """Width of the median filter [s]."""
    lift: float = 0.015
    """The ball has left the ground when it is this much above its height in the contact [m]."""
    heel_lift: float = 0.03
    """The heel is down when it is no more than this above its lowest in the contact [m]."""
    raised: float = 0.05
    """A still foot so much above the other standing one must carry the body alone at some time [m]."""
    longest_roll: float = 0.12
    """Flat is at most this long after the strike [s] (design.md section 2)."""
    roll_fraction: float = 0.25
    """Flat is at most this part of the contact after the strike (design.md section 2)."""
