"""Output frames of all agents: whole samples of the scene's clock, each within its agent's own interval."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.engine.segments import Segments
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable

__all__ = ["Frames", "frames_at", "lay_frames"]


@dataclass(frozen=True, kw_only=True)
class Frames:
    """F frames, each agent's in a row."""

    first: IntArray
    """Index of each agent's first frame, shape (A + 1,)."""
    agents: IntArray
    """Shape (F,)."""
    stamps: FloatArray
    """Times of the samples [s], shape (F,)."""
    times: FloatArray
    """The same, held at the agent's first strike and last liftoff, shape (F,)."""
    segments: IntArray
    """Shape (F,)."""
    contacts: IntArray
    """Latest contact of the left and the right foot, shape (F, 2)."""


def lay_frames(contacts: ContactTable, segments: Segments, sample_times: FloatArray) -> Frames:
    """Frames of each agent from the last sample before its first strike to the first after its last liftoff."""
    tolerance = 1e-6
    begins = np.searchsorted(sample_times, contacts.starts + tolerance, side="right") - 1
    begins = np.clip(begins, 0, len(sample_times) - 1)
    ends = np.searchsorted(sample_times, contacts.ends - tolerance, side="left")
    ends = np.clip(ends, begins, len(sample_times) - 1)
    counts = ends - begins + 1
    first = np.concatenate([[0], np.cumsum(counts)])
    agents = np.repeat(np.arange(len(counts)), counts)
    stamps = sample_times[np.arange(first[-1]) - first[agents] + begins[agents]]
    return frames_at(contacts, segments, agents=agents, stamps=stamps)


def frames_at(contacts: ContactTable, segments: Segments, *, agents: IntArray, stamps: FloatArray) -> Frames:
    """Frames of `agents` (F,), not decreasing, at `stamps` [s] (F,)."""
    first = np.searchsorted(agents, np.arange(len(contacts.starts) + 1))
    times = np.clip(stamps, contacts.starts[agents], contacts.ends[agents])
    rows = locate(segments.agents, segments.begins, contacts.starts, agents=agents, times=times)
    latest = np.zeros((len(agents), 2), dtype=np.intp)
    for side in (0, 1):
        own = np.flatnonzero(contacts.sides == side)
        found = locate(contacts.agents[own], contacts.strikes[own], contacts.starts, agents=agents, times=times)
        latest[:, side] = own[found]
    return Frames(first=first, agents=agents, stamps=stamps, times=times, segments=rows, contacts=latest)
