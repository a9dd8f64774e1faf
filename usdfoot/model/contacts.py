"""Contacts: when and where the feet of a clip or motion stand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import BoolArray, FloatArray

__all__ = ["Contacts", "FootContacts"]


@dataclass(frozen=True, kw_only=True)
class FootContacts:
    """Contacts of one foot in order of time (design.md section 2: strike, flat, liftoff)."""

    strike_times: FloatArray
    """First contact of heel or ball [s], shape (K,); -inf where the clip starts within the contact."""
    flat_times: FloatArray
    """Ball down, from here to the liftoff the foot is planted [s], shape (K,)."""
    liftoff_times: FloatArray
    """Ball leaves the ground [s], shape (K,); +inf where the clip ends within the contact."""
    positions: FloatArray
    """Point of the ground under the planted ball [m], world of the clip or stage, shape (K, 3)."""
    yaws: FloatArray
    """Direction from ankle to ball while planted, as yaw [rad], shape (K,)."""
    ball_first: BoolArray
    """Whether the ball came down before the heel (backward steps, forefoot runs), shape (K,)."""

    @property
    def only_stands(self) -> bool:
        """Whether the foot stands from the clip's first sample to its last."""
        only = len(self.strike_times) == 1
        return only and bool(np.isneginf(self.strike_times[0]) and np.isposinf(self.liftoff_times[0]))


@dataclass(frozen=True, kw_only=True)
class Contacts:
    """Contacts of both feet."""

    left: FootContacts
    right: FootContacts

    def __getitem__(self, side: int) -> FootContacts:
        return (self.left, self.right)[side]

    @property
    def only_stand(self) -> bool:
        """Whether both feet stand from the clip's first sample to its last."""
        return self.left.only_stands and self.right.only_stands
