"""What the legs offer at any time: which stand, where they press, where the ankles are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.physics.footing import Footing
from usdfoot.physics.shared_arrays import shared, shared_record
from usdfoot.physics.stance_kernel import StanceArrays, find_instants

__all__ = ["Stance", "empty_stance", "find_stance"]


@dataclass(frozen=True, kw_only=True)
class Stance:
    """Both legs at M instants; the last axes are (left, right)."""

    contacts: IntArray
    """Contact that the foot carries in, or carried in last, its first before that, shape (M, 2)."""
    standing: BoolArray
    """Whether the foot carries weight, shape (M, 2)."""
    leg_shares: FloatArray
    """Weight of each leg's comfort, of a leg of 0.86 m: its share of the body's weight, shape (M, 2)."""
    supports: FloatArray
    """[P]'s point of support: where the foot presses on the ground [m], world, shape (M, 2, 3)."""
    anchors: FloatArray
    """Ankle of the rolling foot, or of the flat one as in [P], minus the hip's place relative to the centre of mass:
    the virtual leg leads from there to the centre of mass [m], world, shape (M, 2, 3)."""
    nominal_lengths: FloatArray
    """Comfortable lengths of the virtual legs [m], shape (M, 2)."""


def empty_stance(count: int) -> Stance:
    """Room for `count` instants."""
    return Stance(
        contacts=np.empty((count, 2), dtype=np.int32),
        standing=np.empty((count, 2), dtype=bool),
        leg_shares=np.empty((count, 2)),
        supports=np.empty((count, 2, 3)),
        anchors=np.empty((count, 2, 3)),
        nominal_lengths=np.empty((count, 2)),
    )


def find_stance(footing: Footing, *, agents: IntArray, times: FloatArray, bodies: FloatArray) -> Stance:
    """Both legs of the agents (M,) at times (M,) [s] with their bodies turned by quaternions (M, 4)."""
    stance = empty_stance(len(times))
    wp.launch(
        find_instants,
        dim=len(times),
        inputs=[
            footing.contacts, footing.legs, footing.rows,
            shared(agents, wp.int32), shared(times, wp.float64), shared(bodies, wp.quatd),
            shared_record(StanceArrays, vars(stance)),
        ],
        device="cpu",
    )  # fmt: skip
    return stance
