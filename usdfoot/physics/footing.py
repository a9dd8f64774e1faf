"""Footing: all that is known of the contacts before any instant is asked for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.physics.biped import PhysicsBiped
from usdfoot.physics.leg_profile import ContactGaits, measure_gaits
from usdfoot.physics.loading import Loading, ball_loading, lay_loading
from usdfoot.physics.options import PhysicsOptions

__all__ = ["Footing", "lay_footing"]


@dataclass(frozen=True, kw_only=True)
class Footing:
    """C contacts on which one biped stands."""

    contacts: ContactTable
    biped: PhysicsBiped
    options: PhysicsOptions
    gaits: ContactGaits
    loading: Loading
    turns: FloatArray
    """Print frames to world, xyzw, shape (C, 4): +Y along the ground's normal, +Z the foot's heading."""


def lay_footing(contacts: ContactTable, biped: PhysicsBiped, options: PhysicsOptions) -> Footing:
    """What the contacts mean for the biped."""
    gaits = measure_gaits(contacts, biped.maximal_length)
    smooth = options.support == "smooth"
    return Footing(
        contacts=contacts,
        biped=biped,
        options=options,
        gaits=gaits,
        loading=lay_loading(contacts, gaits, biped.maximal_length) if smooth else ball_loading(contacts),
        turns=_print_turns(contacts),
    )


def _print_turns(contacts: ContactTable) -> FloatArray:
    x, y, z = contacts.normals.T
    tilt = quaternion.normalised(np.stack([z, np.zeros_like(x), -x, 1.0 + y], axis=1))
    return quaternion.compose(tilt, quaternion.yaw_quaternion(contacts.yaws))
