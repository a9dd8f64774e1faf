"""Flights: runs that nobody timed fly as long as in the clips they are made from, and feet of walks stand no longer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from usdfoot.analysis.gaits import has_flight
from usdfoot.engine.animate import PreparedLibraries, PreparedLibrary, animate_apart, blend_steps
from usdfoot.engine.flight import natural_flights, natural_overlaps
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
from usdfoot.maths.planar import GROUND_AXES
from usdfoot.maths.types import BoolArray, IntArray
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.contact_table import lay_contacts

__all__ = ["fly_like_clips"]

CLIPS = "clips"
"""The source of motion whose bodies fly as recorded."""
LEAST_OVERLAP = 0.01
"""Both feet of a walk stand together at least this long [s]."""


def fly_like_clips(crowd: Crowd, *, options: EngineOptions, libraries: PreparedLibraries) -> Crowd:
    """The crowd with liftoffs that nobody gave as those of the clips their steps are blended from.

    Runs fly as long as the clips. In walks both feet stand together no longer than there: a foot held on to while the
    body goes on would stretch its knee. Who cannot be animated stays as planned.

    Args:
        crowd: As read.
        options: Of the engine.
        libraries: Of the crowd.
    """
    flying = [agent for agent in crowd.agents if agent.motion == CLIPS and agent.flights_open]
    flown: dict[str, Agent] = {}
    for index in sorted({agent.library for agent in flying}):
        own = [agent for agent in flying if agent.library == index]
        try:
            prepared = libraries.prepared(crowd, index)
        except UsdfootError:
            continue
        found, _ = animate_apart(partial(_flown, prepared, options=options), own)
        flown.update({agent.name: agent for agent in found})
    return replace(crowd, agents=tuple(flown.get(agent.name, agent) for agent in crowd.agents))


def _flown(library: PreparedLibrary, agents: Sequence[Agent], *, options: EngineOptions) -> list[Agent]:
    """The agents, whose clips are one library, with the flights and double supports of these clips.

    A step quicker than its clips flies shorter by as much, one that is slower as long as they: it spends the rest on
    the ground. What would no longer be a run stays as planned.
    """
    contacts = lay_contacts([agent.plan for agent in agents])
    setup, blend, landings = blend_steps(library, agents, contacts, options=options)
    supports = setup.segments.supports
    following = np.minimum(supports + 1, len(contacts.sides) - 1)
    lasts = contacts.strikes[following] - contacts.strikes[supports]
    natural = natural_flights(setup.examples, blend.examples, blend.weights) * np.minimum(landings.time_warp, 1.0)
    displacements = (contacts.positions[following] - contacts.positions[supports])[:, GROUND_AXES]
    planned = contacts.liftoffs[supports] - contacts.strikes[following]
    steps = ~setup.segments.stands & (contacts.steps[supports] >= 0) & (contacts.steps[following] >= 0)
    flies = steps & (planned < 0.0) & has_flight(lasts, lasts - natural, displacements, leg_length=setup.leg_length)
    is_walk = steps & (planned > 0.0) & (planned <= options.stand_time)
    walks = _between_walks(supports, is_walk, len(contacts.sides))
    together = natural_overlaps(setup.examples, blend.examples, blend.weights) * np.minimum(landings.time_warp, 1.0)
    together += lasts * np.maximum(1.0 - 1.0 / landings.time_warp, 0.0)
    overlaps = np.where(flies, -natural, planned)
    overlaps[walks] = np.minimum(planned, np.maximum(together, LEAST_OVERLAP))[walks]
    liftoffs = np.minimum(contacts.liftoffs, contacts.ends[contacts.agents])
    changed = flies | walks
    liftoffs[supports[changed]] = (contacts.strikes[following] + overlaps)[changed]
    return [
        replace(agent, plan=replace(agent.plan, liftoff_times=liftoffs[own][contacts.steps[own] >= 0]))
        for agent, own in zip(agents, map(slice, contacts.first[:-1], contacts.first[1:]), strict=True)
    ]


def _between_walks(supports: IntArray, walks: BoolArray, count: int) -> BoolArray:
    """Which walking steps (M,) have one before them and two after them: not those from, to and beside runs and stands.

    Args:
        supports: Contact that stands in each step, of `count`, shape (M,).
        walks: Whether it is a walking step, shape (M,).
        count: Number of contacts.
    """
    walked = np.zeros(count + 3, dtype=bool)  # one more before the first, two after the last
    walked[supports[walks] + 1] = True
    return walks & walked[supports] & walked[supports + 2] & walked[supports + 3]
