"""Footing: all that is known of the contacts before any instant is asked for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.analysis.timing import HUMAN_LEG
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.physics.biped import PhysicsBiped
from usdfoot.physics.contact_kernel import (
    AgentRow,
    ContactArrays,
    ContactFooting,
    ContactRow,
    LegArrays,
    lay_footings,
)
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.shared_arrays import empty_rows, shared, shared_record
from usdfoot.physics.yaw_kernel import find_body_yaws

__all__ = ["Footing", "device_contacts", "device_legs", "lay_footing"]


@dataclass(frozen=True, kw_only=True)
class Footing:
    """C contacts on which one biped stands, on the device."""

    contacts: ContactArrays
    legs: LegArrays
    rows: wp.array
    """What each contact means, of `ContactFooting`, shape (C,)."""

    def body_yaws(self, agents: IntArray, times: FloatArray, *, window: float) -> FloatArray:
        """Mean yaw of both feet over the window [s] around each time, continuous, agents and times (F,) [rad], (F,)."""
        yaws = np.empty(len(times))
        wp.launch(
            find_body_yaws,
            dim=len(times),
            inputs=[self.contacts, self.rows, shared(agents, wp.int32), shared(times, wp.float64), window],
            outputs=[shared(yaws, wp.float64)],
            device="cpu",
        )
        return yaws

    def run_shares(self, agents: IntArray, times: FloatArray) -> FloatArray:
        """How much the steps at times [s] (F,) are those of a run, by the flights around the latest contact, (F,)."""
        contacts, footing, ranges = (array.numpy() for array in (self.contacts.rows, self.rows, self.contacts.agents))
        owners = np.repeat(np.arange(len(ranges)), ranges["end"] - ranges["first"])
        rows = locate(owners, contacts["strike"], ranges["start"], agents=agents, times=times)
        shares: FloatArray = np.maximum(footing["lands"], footing["leaps"])[rows]
        return shares


def lay_footing(contacts: ContactTable, biped: PhysicsBiped, options: PhysicsOptions) -> Footing:
    """What the contacts mean for the biped."""
    footing = Footing(
        contacts=device_contacts(contacts),
        legs=device_legs(biped, options),
        rows=wp.empty(len(contacts.sides), dtype=ContactFooting, device="cpu"),
    )
    inputs = [footing.contacts, footing.legs, footing.rows]
    wp.launch(lay_footings, dim=len(contacts.starts), inputs=inputs, device="cpu")
    return footing


def device_contacts(contacts: ContactTable) -> ContactArrays:
    """The contacts for the kernels."""
    rows = empty_rows(ContactRow, len(contacts.sides))
    for name in rows.dtype.names or ():
        rows[name] = getattr(contacts, f"{name}s")
    agents = empty_rows(AgentRow, len(contacts.starts))
    agents["first"], agents["end"] = contacts.first[:-1], contacts.first[1:]
    agents["start"], agents["finish"] = contacts.starts, contacts.ends
    return shared_record(ContactArrays, {"rows": rows, "agents": agents})


def device_legs(biped: PhysicsBiped, options: PhysicsOptions) -> LegArrays:
    """The biped for the kernels."""
    return shared_record(
        LegArrays,
        {
            "hips": biped.hips,
            "ankles": biped.ankles,
            "nominal_length": biped.nominal_length,
            "maximal_length": biped.maximal_length,
            "size": biped.maximal_length / HUMAN_LEG,
            "heel": biped.heel,
            "toe": biped.toe,
            "play": options.leg_play,
            "smooth": options.support == "smooth",
        },
    )
