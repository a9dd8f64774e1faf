"""Tables: the stretch of some agents' windows that the engine prepares at once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.engine.animate import PreparedLibrary
from usdfoot.engine.landings import stand_blend
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.planting import Due
from usdfoot.engine.poses import Setup, StepBlend
from usdfoot.engine.root import lay_root
from usdfoot.engine.segments import cut_segments
from usdfoot.engine.time_warps import longest_step
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable, with_headings
from usdfoot.realtime.windows import RING, Windows

__all__ = ["REACH_BACK", "Stretch", "cut_stretch"]

REACH_BACK = 5
"""Contacts before the first changed one that the changes are prepared from: the swing that ends two before it is the
first whose end they move, and its segment's root path begins with the slope of another segment."""
UPRIGHT = np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """Contacts of some agents, each from REACH_BACK before its first change to its last."""

    agents: IntArray
    """Of the controller, shape (A,)."""
    dirty: IntArray
    """First changed contact of each, shape (A,)."""
    last: IntArray
    """Last contact prepared so far that a segment stands on, shape (A,)."""
    numbers: IntArray
    """Of each contact in its agent's window, shape (C,)."""
    setup: Setup
    blend: StepBlend
    """Of the steps that have not changed; the others stand."""

    @property
    def owners(self) -> IntArray:
        """Agent of the controller of each contact, shape (C,)."""
        return self.agents[self.setup.contacts.agents]

    @property
    def places(self) -> tuple[IntArray, IntArray]:
        """Where the contacts are in the windows' rings."""
        return self.owners, self.numbers % RING

    @property
    def changed(self) -> BoolArray:
        """Segments that depend on a changed contact, shape (M,)."""
        segments = self.setup.segments
        return self.numbers[segments.supports] >= self.dirty[segments.agents] - 1

    @property
    def due(self) -> Due:
        """Contacts whose feet the changes move, as far as the poses of their segments are known."""
        owners, numbers = self.setup.contacts.agents, self.numbers
        dirty, last = self.dirty[owners], self.last[owners]
        halted = last == self._known[owners]
        return Due(
            strikes=np.flatnonzero((numbers >= dirty - 1) & (numbers <= last)),
            flats=np.flatnonzero((numbers >= dirty - 2) & (numbers <= last - ~halted)),
            leaves=np.flatnonzero((numbers >= dirty - 3) & (numbers <= last - 1)),
            swings=np.flatnonzero((numbers >= dirty - 3) & (numbers <= last - 2)),
        )

    @property
    def _known(self) -> IntArray:
        return self.numbers[self.setup.contacts.first[1:] - 1]


def cut_stretch(
    windows: Windows,
    agents: IntArray,
    firsts: IntArray,
    *,
    library: PreparedLibrary,
    blends: tuple[IntArray, FloatArray, FloatArray],
    origins: FloatArray,
    starts: FloatArray,
    options: EngineOptions,
) -> Stretch:
    """The contacts of `agents` (A,) from numbers `firsts` (A,) on, with what is known of their steps.

    Args:
        windows: Of all agents.
        agents: Those to prepare, increasing.
        firsts: First contact of each.
        library: Prepared.
        blends: Examples and weights (N, RING, 4) and twists [rad] (N, RING) of the steps over each contact.
        origins: Each agent's origin [m], shape (A, 3).
        starts: Zero of each agent's clock [s], shape (A,).
        options: Of the engine.
    """
    counts = windows.last[agents] - firsts + 1
    first = np.concatenate([[0], np.cumsum(counts)])
    owners = np.repeat(np.arange(len(agents)), counts)
    numbers = np.arange(first[-1]) - first[owners] + firsts[owners]
    places = agents[owners], numbers % RING
    strikes, liftoffs = windows.strikes[places], windows.liftoffs[places]
    halted = windows.halted[agents]
    contacts = with_headings(
        ContactTable(
            first=first,
            agents=owners,
            steps=numbers,
            sides=windows.sides[places],
            positions=windows.positions[places],
            yaws=windows.yaws[places],
            normals=np.tile(UPRIGHT, (len(owners), 1)),
            strikes=strikes,
            liftoffs=liftoffs,
            headings=np.zeros(len(owners)),
            starts=starts,
            ends=np.where(halted, liftoffs[first[1:] - 1], strikes[first[1:] - 1]),
        )
    )
    segments = cut_segments(contacts, options, longest_step=longest_step(library.examples, options))
    stand = stand_blend(len(segments), len(library.examples) - 1, width=4)
    examples, weights, twists = (values[places][segments.supports] for values in blends)
    steps = ~segments.stands[:, None]
    setup = Setup(
        skeleton=library.source.skeleton,
        pelvis=library.source.biped.pelvis,
        rig=library.rig,
        contacts=contacts,
        segments=segments,
        path=lay_root(contacts, segments, step_height_share=options.step_height_share),
        origins=origins,
        options=options,
        examples=library.examples,
        library=library.device,
        leg_length=library.source.biped.maximal_leg_length,
        hip_width=library.hip_width,
        styles=np.full(len(owners), library.style, dtype=object),
    )
    return Stretch(
        agents=agents,
        dirty=windows.dirty[agents],
        last=windows.last[agents] - ~halted,
        numbers=numbers,
        setup=setup,
        blend=replace(
            stand,
            examples=np.where(steps, examples, stand.examples),
            weights=np.where(steps, weights, stand.weights),
            twists=np.where(steps[:, 0], twists, 0.0),
        ),
    )
