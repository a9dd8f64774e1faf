"""Rows: prepared steps and contacts of all agents on the device, each in a row of its own for as long as it matters.

Contact n of agent a is row a * RING + n % RING of the feet. Of the segments, the body's stand on that contact is row
2 (a * RING + n % RING), its step over it the next.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import warp as wp

from usdfoot.engine.clock_kernel import ClockArrays
from usdfoot.engine.contact_feet import ContactFeet, device_feet, foot_table, unplanted_feet
from usdfoot.engine.foot_rows import FootArrays
from usdfoot.engine.kernels import SegmentArrays
from usdfoot.engine.planting import Planting
from usdfoot.engine.pose_source import Poses
from usdfoot.engine.poses import Seams, Setup, blend_frames
from usdfoot.engine.root import RootPath
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.realtime.tables import Stretch
from usdfoot.realtime.windows import RING

__all__ = ["RowPoses", "Rows"]

SEAMS = tuple(field.name for field in fields(Seams))
PATHS = tuple(field.name for field in fields(RootPath))
TIMES = ("stand_ends", "strikes", "begins", "sides", "numbers")
Views = dict[str, np.ndarray]
"""Arrays of a device struct as the host sees them, by name."""


@dataclass(frozen=True, kw_only=True)
class RowPoses:
    """Poses of a stretch's segments from the rows they were put in: a source for planting."""

    setup: Setup
    segments: SegmentArrays
    rows: IntArray
    """Row of each segment of the setup, shape (M,)."""

    def pose(self, rows: IntArray, times: FloatArray, *, joints: IntArray) -> Poses:
        """Blended poses of segments `rows` (F,) of the setup at `times` [s] (F,)."""
        clock = times - self.setup.contacts.starts[self.setup.segments.agents[rows]]
        return blend_frames(self.setup.library, self.segments, rows=self.rows[rows], clock=clock, joints=joints)


class Rows:
    """What is prepared, on the host for the next preparation and on the device for the next frames.

    Args:
        agents: Number of agents.
    """

    def __init__(self, agents: int) -> None:
        self.blends = (
            np.zeros((agents, RING, 4), dtype=np.intp),
            np.zeros((agents, RING, 4)),
            np.zeros((agents, RING)),
        )
        """Examples, weights and twists [rad] of the step over each contact."""
        self.stand_ends = np.full((agents, RING), -np.inf)
        """Until when the body stands on each contact [s]."""
        self.strikes = np.full((agents, RING), np.inf)
        self.begins = np.full((agents, RING), np.inf)
        """When the body steps onto each contact [s]: not at its strike where a flight is centred on the planned one."""
        self.sides = np.zeros((agents, RING), dtype=np.intp)
        self.numbers = np.full((agents, RING), -1)
        """Of the contacts, -1 where there is none."""
        self._feet = {name: _rings(values, agents) for name, values in vars(unplanted_feet(1)).items()}
        self._detours: FloatArray = np.zeros((agents, RING, 0, 3))
        self._paths: dict[str, FloatArray] = {}
        self.segments, self.feet = SegmentArrays(), FootArrays()
        self._segment_views: Views = {}
        self._clock_views: Views = {}
        self._foot_views: Views = {}

    def open(self, agents: IntArray) -> None:
        """Has agents (M,), also new ones, begin as if nothing had ever been prepared of them."""
        self._make_room(int(agents.max()) + 1)
        fresh = Rows(len(agents))
        for kept, values in zip(self._tables(), fresh._tables(), strict=True):
            kept[agents] = values
        self._detours[agents] = 0.0

    def _tables(self) -> list[np.ndarray]:
        """What the host has of every contact, shape (N, RING, ...) each; without the detours, whose size is found."""
        return [*self.blends, *(getattr(self, name) for name in TIMES), *self._feet.values()]

    def _make_room(self, agents: int) -> None:
        """Has room for so many agents; where there is none for half as many again, since all is copied."""
        before = len(self.numbers)
        if agents <= before:
            return
        larger = Rows(max(agents, before + before // 2))
        for new, values in zip(larger._tables(), self._tables(), strict=True):
            new[:before] = values
        self.blends, self._feet = larger.blends, larger._feet
        for name in TIMES:
            setattr(self, name, getattr(larger, name))
        added = len(self.numbers) - before
        self._detours = _lengthened(self._detours, added)
        if not self._paths:
            return
        none = 2 * RING * before  # all zeros, and so a row of nobody
        count, feet = 2 * RING * len(self.numbers) + 1, RING * len(self.numbers)
        self._paths = {name: _lengthened(values, count - none - 1) for name, values in self._paths.items()}
        self._segment_views = _allocate(self.segments, self.segments, count, kind=SegmentArrays)
        self._clock_views = _allocate(self.segments.clocks, self.segments.clocks, count, kind=ClockArrays)
        self._foot_views = _allocate(self.feet, self.feet, feet, kind=FootArrays)
        after = self._segment_views["seams_after"]
        after[after == none] = count - 1

    def known(self, stretch: Stretch, source: RowPoses) -> Planting | None:
        """What was prepared of a stretch's contacts; None before the first preparation."""
        if not self._detours.shape[2]:
            return None
        feet: dict[str, Any] = {name: values[stretch.places] for name, values in self._feet.items()}
        return Planting(
            layout=stretch.setup, source=source, feet=ContactFeet(**feet), detours=self._detours[stretch.places]
        )

    def put_segments(self, stretch: Stretch, arrays: SegmentArrays, seams: Seams, *, remade: IntArray) -> RowPoses:
        """Takes over the segments of a stretch, and the seams before the segments `remade`.

        The first segment of an agent that has others before it is left as it is.
        """
        setup, segments = stretch.setup, stretch.setup.segments
        places = stretch.owners[segments.supports] * RING + stretch.numbers[segments.supports] % RING
        rows = 2 * places + ~segments.stands
        if not self._paths:
            self._allocate(arrays, setup)
        valid = np.flatnonzero(self._prepared(stretch))
        _copy_rows(self._segment_views, arrays, rows[valid], valid, but=(*SEAMS, "seams_after"))
        _copy_rows(self._clock_views, arrays.clocks, rows[valid], valid, but=())
        none = 2 * self.stand_ends.size
        after = np.where(segments.joined[1:], np.append(rows[1:], 0), none)
        self._segment_views["seams_after"][rows[valid]] = after[valid]
        for name in SEAMS:
            self._segment_views[name][rows[remade]] = getattr(seams, name).numpy()[remade]
        for name in PATHS:
            self._paths[name][rows[valid]] = getattr(setup.path, name)[valid]
        self.stand_ends[stretch.places] = -np.inf
        stands = segments.stands
        self.stand_ends.ravel()[places[stands]] = segments.ends[stands]
        return RowPoses(setup=setup, segments=self.segments, rows=rows)

    def _prepared(self, stretch: Stretch) -> BoolArray:
        """Segments of a stretch (M,) whose begin is known: not the first of an agent that has others before it."""
        segments = stretch.setup.segments
        return np.asarray(segments.joined[:-1] | (stretch.numbers[segments.supports] == 1))

    def put_blends(self, stretch: Stretch) -> None:
        """Keeps the blends of a stretch's steps."""
        steps = np.flatnonzero(~stretch.setup.segments.stands)
        owners, numbers = (values[stretch.setup.segments.supports[steps]] for values in stretch.places)
        blend = stretch.blend
        for kept, values in zip(self.blends, (blend.examples, blend.weights, blend.twists), strict=True):
            kept[owners, numbers] = values[steps]

    def put_feet(self, stretch: Stretch, planting: Planting) -> None:
        """Takes over the feet of a stretch's contacts."""
        if not self._detours.shape[2]:
            self._detours = np.zeros((*self.stand_ends.shape, *planting.detours.shape[1:]))
        for name, values in self._feet.items():
            values[stretch.places] = getattr(planting.feet, name)
        self._detours[stretch.places] = planting.detours
        contacts = stretch.setup.contacts
        later = self.numbers[stretch.agents] > stretch.numbers[contacts.first[1:] - 1][:, None]
        for times in (self.strikes, self.begins):
            times[stretch.agents] = np.where(later, np.inf, times[stretch.agents])
        self.strikes[stretch.places], self.sides[stretch.places] = contacts.strikes, contacts.sides
        self.begins[stretch.places] = self._body_begins(stretch)
        self.numbers[stretch.places] = stretch.numbers
        owners, numbers = stretch.places
        rows = owners * RING + numbers
        if not self._foot_views:
            like = device_feet(stretch.setup, planting.feet, planting.detours)
            self._foot_views = _allocate(self.feet, like, self.stand_ends.size, kind=FootArrays)
        table = foot_table(stretch.setup, planting.feet)
        table["following"] = owners * RING + (numbers + 2) % RING
        self._foot_views["rows"][rows], self._foot_views["detours"][rows] = table, planting.detours

    def _body_begins(self, stretch: Stretch) -> FloatArray:
        """When bodies step onto the contacts of a stretch [s], shape (C,); as it was where that is not told."""
        segments, strikes = stretch.setup.segments, stretch.setup.contacts.strikes
        supports, first = np.unique(segments.supports, return_index=True)  # a stand comes before the step from it
        told = self._prepared(stretch)[first]
        same = self.numbers[stretch.places] == stretch.numbers
        begins = np.where(same, self.begins[stretch.places], strikes)
        begins[supports[told]] = segments.begins[first[told]]
        return begins

    def struck(self, agents: IntArray, time: float) -> tuple[IntArray, IntArray, IntArray]:
        """Where agents are at `time` [s].

        Returns:
            Row of the segment, shape (N,), rows of the latest contacts of both feet, shape (N, 2), and number of the
            later one, shape (N,).
        """
        latest, stepped = (
            np.max(np.where(times[agents] <= time, self.numbers[agents], 1), axis=1)
            for times in (self.strikes, self.begins)
        )
        places = latest % RING, (latest - 1) % RING
        steps = time >= self.stand_ends[agents, stepped % RING]
        left = self.sides[agents, places[0]] == 0
        feet = np.stack([np.where(left, *places), np.where(left, *places[::-1])], axis=1)
        return 2 * (agents * RING + stepped % RING) + steps, agents[:, None] * RING + feet, latest

    def path(self, rows: IntArray) -> RootPath:
        """Root path of the segments in `rows` (F,)."""
        return RootPath(**{name: values[rows] for name, values in self._paths.items()})

    def _allocate(self, arrays: SegmentArrays, setup: Setup) -> None:
        """Room for all segments, shaped as those given, and one row more for the seam that is none."""
        count = 2 * self.stand_ends.size + 1
        self._segment_views = _allocate(self.segments, arrays, count, kind=SegmentArrays)
        self._clock_views = _allocate(self.segments.clocks, arrays.clocks, count, kind=ClockArrays)
        self.segments.clocks.seam_kind = arrays.clocks.seam_kind
        self._paths = {name: np.zeros((count, *getattr(setup.path, name).shape[1:])) for name in PATHS}


def _rings(values: FloatArray, agents: int) -> FloatArray:
    """The one value (1, ...) for every contact of all agents, shape (N, RING, ...)."""
    return np.tile(values[None], (agents, RING, *[1] * (values.ndim - 1)))


def _lengthened(values: FloatArray, more: int) -> FloatArray:
    """Values (N, ...) with so many rows of zeros after them."""
    return np.concatenate([values, np.zeros((more, *values.shape[1:]), dtype=values.dtype)])


def _allocate(target: object, like: object, count: int, *, kind: wp.struct) -> Views:
    """Arrays of `count` rows for every array of a device struct, with those it has itself; shows them to the host."""
    views: Views = {}
    for name in kind.vars:
        values = getattr(like, name)
        if isinstance(values, wp.array):
            rows = wp.zeros((count, *values.shape[1:]), dtype=values.dtype)
            views[name] = rows.numpy()
            if target is like:
                views[name][: len(values)] = values.numpy()
            setattr(target, name, rows)
    return views


def _copy_rows(views: Views, source: object, rows: IntArray, chosen: IntArray, *, but: tuple[str, ...]) -> None:
    """Rows `chosen` of a device struct's arrays, but for some, into `rows` of those shown."""
    for name, values in views.items():
        if name not in but:
            values[rows] = getattr(source, name).numpy()[chosen]
