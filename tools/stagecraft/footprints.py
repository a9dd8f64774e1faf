"""Footprints: where each foot stands, when, and how it rolls there; laid one step after the other.

Canonical space: metres, seconds, radians, +Y up, facing +Z, yaw from +Z to +X, left is +X of someone facing +Z.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stagecraft.rotation import FloatArray

LEFT, RIGHT = 0, 1
OUT_TOE = np.radians(6.0)
"""How far each foot points outward: 5 to 7 degrees (Murray, Drought and Kory 1964, Walking patterns of normal men)."""


@dataclass(frozen=True, kw_only=True)
class Roll:
    """How a foot comes to its footprint, rolls over it and leaves; pitch is positive with the heel up."""

    strike_pitch: float = np.radians(-18.0)
    """Pitch at the strike [rad]; negative: the heel comes first."""
    settle: float = 0.1
    """From the strike until the foot is flat, at most 0.12 s and a quarter of the contact [s]."""
    heel_off: float = 0.45
    """Part of the time from flat to liftoff after which the heel rises."""
    liftoff_pitch: float = np.radians(45.0)
    """Pitch when the ball leaves [rad]."""
    swing_pitch: float = np.radians(52.0)
    """Largest pitch in the swing after this contact [rad]."""
    middle_pitch: float = np.radians(8.0)
    """Pitch in the middle of that swing [rad]."""
    clearance: float = 0.032
    """Height of the lowest point of the sole over the ground in the middle of that swing [m]."""
    lift: float = 0.04
    """The whole foot is carried higher by [m], most in early swing; more in runs and high steps."""


@dataclass(frozen=True, kw_only=True)
class Footprint:
    """One planted placement of one foot."""

    side: int
    position: FloatArray
    """Ground under the ball [m], shape (3,)."""
    yaw: float
    """Heading of the foot [rad]."""
    strike: float
    """First contact [s]."""
    liftoff: float
    """The ball leaves [s]."""
    roll: Roll

    @property
    def settle(self) -> float:
        """Time from the strike to flat [s]; none where the ball comes first."""
        if self.roll.strike_pitch >= 0.0:
            return 0.0
        return min(self.roll.settle, 0.12, 0.25 * (self.liftoff - self.strike))

    @property
    def flat(self) -> float:
        """When the whole foot is down or, ball first, the strike [s]."""
        return self.strike + self.settle


@dataclass(frozen=True, kw_only=True)
class Step:
    """One step of the body: from the strike of one foot to that of the other."""

    duration: float
    """Strike to strike [s]."""
    overlap: float
    """Time both feet stand after the landing [s]; negative: flight before it."""
    forward: float = 0.0
    """Travel of the body ahead [m]."""
    left: float = 0.0
    """Travel of the body to its left [m]."""
    width: float = 0.12
    """Distance of the feet to the sides [m]."""
    turn: float = 0.0
    """Change of heading [rad]."""
    rise: float = 0.0
    """The ground under the landing is higher by [m]."""
    roll: Roll = field(default_factory=Roll)
    """How the landing foot rolls."""


def lay_footprints(steps: Sequence[Step], *, first_side: int, last_contact: float = 0.6) -> list[Footprint]:
    """Footprints of `steps`; the first step places its foot at time 0 without travel.

    Args:
        steps: the first gives the first footprint (only width, overlap and roll matter), each other one more.
        first_side: foot of the first footprint; the feet alternate.
        last_contact: how long the last foot stands [s].
    """
    strikes = np.concatenate([[0.0], np.cumsum([step.duration for step in steps[1:]])])
    centre, heading, ground = np.zeros(2), 0.0, 0.0
    prints: list[Footprint] = []
    for number, (step, strike) in enumerate(zip(steps, strikes, strict=True)):
        if number:
            centre = centre + _planar(heading + step.turn / 2, left=step.left, forward=step.forward)
            heading, ground = heading + step.turn, ground + step.rise
        side = (first_side + number) % 2
        outward = 1.0 if side == LEFT else -1.0
        x, z = centre + _planar(heading, left=outward * step.width / 2, forward=0.0)
        following = steps[number + 1] if number + 1 < len(steps) else None
        liftoff = strikes[number + 1] + following.overlap if following else strike + last_contact
        prints.append(
            Footprint(
                side=side,
                position=np.array([x, ground, z]),
                yaw=heading + outward * OUT_TOE,
                strike=float(strike),
                liftoff=float(liftoff),
                roll=step.roll,
            )
        )
    return prints


def end_standing(prints: Sequence[Footprint], hold: float) -> list[Footprint]:
    """The same footprints, the last two staying until `hold` [s] after the last strike."""
    end = prints[-1].strike + hold
    still = replace(prints[-1].roll, liftoff_pitch=0.0)
    return [
        *prints[:-2],
        replace(prints[-2], liftoff=end, roll=replace(prints[-2].roll, liftoff_pitch=0.0)),
        replace(prints[-1], liftoff=end, roll=still),
    ]


def _planar(heading: float, *, left: float, forward: float) -> FloatArray:
    """Planar vector (x, z) of a move in the frame of `heading`."""
    return np.array(
        [np.cos(heading) * left + np.sin(heading) * forward, np.cos(heading) * forward - np.sin(heading) * left]
    )
