"""Segments: what carries the body when, steps over a support foot and stands on both."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.engine.options import EngineOptions
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable
from usdfoot.model.examples import LIFTOFF_PHASES, event_knots

__all__ = ["SHORTEST_STAND", "Segments", "cut_segments"]


SHORTEST_STAND = 0.25
"""Double supports shorter than this are part of the step however long that takes [s]."""


@dataclass(frozen=True, kw_only=True)
class Segments:
    """M segments in order of agent and time."""

    agents: IntArray
    """Shape (M,)."""
    supports: IntArray
    """Contact the body stands on, or the later one of the two in a stand, shape (M,)."""
    stands: BoolArray
    """Whether both feet carry a body at rest, shape (M,)."""
    begins: FloatArray
    ends: FloatArray
    """[s], shape (M,) each."""
    knot_times: FloatArray
    """Times of the events inside the step [s], shape (M, 4)."""
    knot_shares: FloatArray
    """When they come in the blended examples, as parts of the step's duration, shape (M, 4)."""
    joined: BoolArray
    """Whether the seam before the segment joins it to another of the same agent, shape (M + 1,)."""

    def __len__(self) -> int:
        return len(self.supports)


def cut_segments(contacts: ContactTable, options: EngineOptions, *, longest_step: float = np.inf) -> Segments:
    """Cuts every agent's time into steps (strike to strike) and stands (long double supports).

    Args:
        contacts: Of all agents.
        options: Say how long a double support is stood through.
        longest_step: In steps that take longer [s], shorter double supports than that are stood through.
    """
    candidates = np.flatnonzero(contacts.has_previous)
    has_next = contacts.has_next[candidates]
    strikes = contacts.strikes[candidates]
    released = contacts.liftoffs[candidates - 1]
    ends = contacts.ends[contacts.agents[candidates]]
    standing_start = (strikes == contacts.strikes[candidates - 1]) & ~contacts.has_previous[candidates - 1]
    following = contacts.strikes[np.minimum(candidates + 1, len(contacts.sides) - 1)]
    known = contacts.steps[candidates - 1] >= 0  # before a mid-gait start the clips say when it lifts off
    drawn_out = (following - strikes > longest_step) & (released - strikes > SHORTEST_STAND)
    waits = known & ((released - strikes > options.stand_time) | drawn_out) | standing_start
    stands = np.where(has_next, waits, ends > strikes)
    stand_ends = np.where(has_next, np.minimum(released, following), ends)
    step_begins = np.where(stands, released, strikes)
    step_ends = np.where(has_next, following, -np.inf)
    supports = np.concatenate([candidates[stands], candidates[has_next]])
    kinds = np.concatenate([np.ones(stands.sum(), bool), np.zeros(has_next.sum(), bool)])
    begins = np.concatenate([strikes[stands], step_begins[has_next]])
    finishes = np.concatenate([stand_ends[stands], step_ends[has_next]])
    order = np.lexsort((~kinds, supports))
    supports, kinds, begins, finishes = supports[order], kinds[order], begins[order], finishes[order]
    agents = contacts.agents[supports]
    knot_times = _knots(contacts, supports, kinds, begins, finishes)
    joined = np.concatenate([[False], agents[1:] == agents[:-1], [False]])
    return Segments(
        agents=agents,
        supports=supports,
        stands=kinds,
        begins=begins,
        ends=finishes,
        knot_times=knot_times,
        knot_shares=(knot_times - knot_times[:, :1]) / (knot_times[:, -1:] - knot_times[:, :1]),
        joined=joined,
    )


def _knots(
    contacts: ContactTable, supports: IntArray, stands: BoolArray, begins: FloatArray, ends: FloatArray
) -> FloatArray:
    """Event times of each segment, shape (M, 4); a step after a stand starts at the phase of the swing liftoff."""
    strikes = contacts.strikes[supports]
    after_stand = ~stands & (begins > strikes)
    first = LIFTOFF_PHASES[0]
    starts = np.where(after_stand, begins - first / (1.0 - first) * (ends - begins), begins)
    durations = np.where(stands, np.maximum(ends - begins, 1e-3), ends - starts)
    swing = np.where(after_stand, begins, contacts.liftoffs[supports - 1]) - starts
    times, _ = event_knots(durations, swing, contacts.liftoffs[supports] - starts)
    return starts[:, None] + times
