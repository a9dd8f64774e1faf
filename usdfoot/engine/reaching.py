"""Footsteps as they are reached: their steps weighed, those out of reach moved to where they are achieved ([B] 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.engine.corrections import correct_steps
from usdfoot.engine.landings import blend_twists
from usdfoot.engine.poses import Setup, StepBlend
from usdfoot.engine.queries import step_queries
from usdfoot.engine.reach import beyond_reach, give_way
from usdfoot.engine.root import lay_root
from usdfoot.engine.segments import cut_segments
from usdfoot.engine.styles import continue_styles
from usdfoot.engine.time_warps import blended_durations, longest_step
from usdfoot.maths import planar
from usdfoot.maths.planar import GROUND_AXES
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable, with_headings
from usdfoot.spaces.library import FootstepSpaces

__all__ = ["Reached", "reach_footsteps"]

GIVE_WAYS = 5
"""How often a foot that was moved comes back farther at most."""


@dataclass(frozen=True, kw_only=True)
class Reached:
    """How the blended landings of M segments meet their footsteps; zero for those that are not asked for."""

    offsets: FloatArray
    """Footstep as planned minus blended landing, (x, z) [m], shape (M, 2)."""
    hull_distances: FloatArray
    """Footstep as planned to the hull of the space, 0 inside [m], shape (M,)."""
    time_warps: FloatArray
    """Planned duration over the blended one, of all segments, shape (M,)."""
    limited: BoolArray
    """Whether IK may not pull as far as the footstep lies, which is moved then, shape (M,)."""


def reach_footsteps(
    setup: Setup, spaces: FootstepSpaces, wanted: BoolArray, *, blend: StepBlend, reach: FloatArray
) -> tuple[Setup, StepBlend, Reached]:
    """Weights of the `wanted` (M,) segments, none of them a stand; footsteps out of reach are moved.

    A foot that was moved comes back farther where that lets the next footstep be kept. In each round the first footstep
    of every agent that is out of reach is dealt with, and the few steps beside it are weighed anew.

    Args:
        setup: Contacts as planned.
        spaces: Footstep spaces of the setup's examples.
        wanted: Segments to weigh.
        blend: Of the others.
        reach: Largest distance from blended landing to footstep for each agent [m], shape (A,).
    """
    search = _Search(setup, spaces, wanted, blend=blend, reach=reach)
    while True:
        first = search.first_beyond()
        if not first.size:
            return search.laid(), search.blend, search.reached()
        search.weigh_beside(search.move_targets(first))


class _Search:
    """Steps as far as they are weighed. The arrays are its own and change in place: a round costs what it changes."""

    def __init__(
        self, setup: Setup, spaces: FootstepSpaces, wanted: BoolArray, *, blend: StepBlend, reach: FloatArray
    ) -> None:
        segments, count = setup.segments, len(setup.segments)
        contacts = replace(setup.contacts, positions=setup.contacts.positions.copy())
        self.setup = replace(setup, contacts=contacts)
        self.blend = StepBlend(**{name: values.copy() for name, values in vars(blend).items()})
        self._spaces, self._wanted, self._reach = spaces, wanted, reach
        self._offsets, self._excess, self._moved = (np.zeros((count, 2)) for _ in range(3))
        self._hull_distances, self._given = np.zeros(count), np.zeros(count, dtype=int)
        self._beyond, self._limited = (np.zeros(count, dtype=bool) for _ in range(2))
        steps = np.flatnonzero(~segments.stands)
        self._step_over = np.full(len(contacts.sides), -1)  # the step that each contact supports
        self._step_over[segments.supports[steps]] = steps
        self._weigh(np.flatnonzero(wanted))
        starts = contacts.first[:-1]
        starts = starts[contacts.steps[starts] < 0]
        self._place_departures(np.searchsorted(segments.supports, starts + 1))

    def first_beyond(self) -> IntArray:
        """The first segment of each agent whose footstep is out of reach and was not given up, shape (N,)."""
        rows = np.flatnonzero(self._beyond)
        return rows[np.diff(self.setup.segments.agents[rows], prepend=-1) != 0]

    def move_targets(self, first: IntArray) -> IntArray:
        """Moves what the segments `first` (N,), one an agent, cannot reach, or the foot before it; which were moved."""
        excess, supports = self._excess[first], self.setup.segments.supports
        before = self._step_over[supports[first] - 1]
        shifts = give_way(self.setup, first, before, moved=self._moved[before], excess=excess)
        shifts[self._given[before] >= GIVE_WAYS] = 0.0
        gives: BoolArray = np.any(shifts != 0.0, axis=1)
        self._given[before[gives]] += 1
        held = first[~gives]
        self._limited[held] = True
        rows = np.where(gives, before, first)
        shifts = np.where(gives[:, None], shifts, excess)
        self._moved[rows] += shifts
        self.setup.contacts.positions[np.ix_(supports[rows] + 1, GROUND_AXES)] -= shifts
        return rows

    def weigh_beside(self, rows: IntArray) -> None:
        """Weighs anew the steps that start, end or lift off where `rows` (N,), one an agent, end, and the next ones.

        Those follow in a style from the poses these end in; the one before them is there for the same reason.
        """
        segments = self.setup.segments
        targets = segments.supports[rows, None] + 1 + np.arange(-2, 3)
        beside = self._step_over[np.minimum(targets, len(self._step_over) - 1)]
        own: BoolArray = segments.agents[beside] == segments.agents[rows, None]
        asked: BoolArray = (beside >= 0) & own & self._wanted[beside]
        changed = asked & (np.arange(5) > 0)
        steps, kept = beside[asked], changed[asked]
        self._weigh(steps, kept=kept)
        self._place_departures(steps[kept & (self.setup.contacts.steps[segments.supports[steps] - 1] < 0)])

    def laid(self) -> Setup:
        """The setup with contacts as executed."""
        contacts, segments, share = self.setup.contacts, self.setup.segments, self.setup.options.step_height_share
        return replace(self.setup, path=lay_root(contacts, segments, step_height_share=share))

    def reached(self) -> Reached:
        """How the landings meet their footsteps."""
        segments = self.setup.segments
        planned = segments.knot_times[:, -1] - segments.knot_times[:, 0]
        blended = blended_durations(self.setup.examples, self.blend.examples, self.blend.weights)
        return Reached(
            offsets=self._offsets + self._moved,
            hull_distances=self._hull_distances,
            time_warps=np.where(segments.stands, 1.0, planned / blended),
            limited=self._limited,
        )

    def _weigh(self, steps: IntArray, *, kept: BoolArray | None = None) -> None:
        """Weighs `steps` (N,) for contacts as they are, and keeps what comes of the `kept` (N,) ones, None = of all."""
        if not steps.size:
            return
        setup = self.setup
        queries = step_queries(setup, steps)
        corrected = correct_steps(setup, self._spaces, queries, corrections=setup.options.corrections)
        corrected = continue_styles(setup, self._spaces, steps, queries=queries, corrected=corrected)
        twists = blend_twists(setup, queries, examples=corrected.examples, weights=corrected.weights)
        offsets = planar.rotate(queries.headings + queries.turns, corrected.missed)
        excess = beyond_reach(setup, steps, offsets, reach=self._reach)
        kept = np.ones(len(steps), dtype=bool) if kept is None else kept
        rows, used = steps[kept], corrected.examples.shape[1]
        self.blend.examples[rows] = corrected.examples[kept, :1]
        self.blend.examples[rows, :used] = corrected.examples[kept]
        self.blend.weights[rows] = 0.0
        self.blend.weights[rows, :used] = corrected.weights[kept]
        self.blend.twists[rows] = twists[kept]
        self._offsets[rows], self._excess[rows] = offsets[kept], excess[kept]
        as_planned = ~self._limited[rows]
        self._hull_distances[rows[as_planned]] = corrected.hull_distances[kept][as_planned]
        self._beyond[rows] = as_planned & (np.abs(excess[kept]).max(axis=1) > setup.options.landing_tolerance)

    def _place_departures(self, rows: IntArray) -> None:
        """Puts the contacts before mid-gait starts where, and lets them leave when, the swing feet of `rows` (N,) do.

        These are the first segments of their agents, blended.
        """
        if not rows.size:
            return
        setup, weights, chosen = self.setup, self.blend.weights[rows], self.blend.examples[rows]
        contacts, segments, examples = setup.contacts, setup.segments, setup.examples
        supports = segments.supports[rows]
        departures = np.sum(weights[..., None] * examples.departures[chosen], axis=1)
        headings = contacts.headings[supports]
        positions, yaws, liftoffs = contacts.positions.copy(), contacts.yaws.copy(), contacts.liftoffs.copy()
        positions[np.ix_(supports - 1, GROUND_AXES)] = positions[np.ix_(supports, GROUND_AXES)] + planar.rotate(
            headings, departures
        )
        yaws[supports - 1] = headings + np.sum(weights * examples.departure_yaws[chosen], axis=1)
        durations = segments.ends[rows] - segments.begins[rows]
        share = np.sum(weights * (examples.swing_liftoffs / examples.durations)[chosen], axis=1)
        released = np.minimum(np.clip(share, -0.5, 0.5) * durations, 0.9 * setup.options.stand_time)
        liftoffs[supports - 1] = segments.begins[rows] + released
        contacts = replace(contacts, positions=positions, yaws=yaws, liftoffs=liftoffs)
        contacts = replace(contacts, headings=_keep_start(with_headings(contacts).headings, contacts, supports))
        longest = longest_step(examples, setup.options)
        self.setup = replace(
            setup, contacts=contacts, segments=cut_segments(contacts, setup.options, longest_step=longest)
        )


def _keep_start(headings: FloatArray, contacts: ContactTable, supports: IntArray) -> FloatArray:
    """Headings at the first strikes stay those the weights were found with."""
    kept = headings.copy()
    kept[supports] = contacts.headings[supports]
    kept[supports - 1] = contacts.headings[supports - 1]
    return kept
