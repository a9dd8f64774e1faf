"""Flights: runs that nobody timed fly as long as in the clips they are made from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from usdfoot.analysis.gaits import has_flight
from usdfoot.engine.animate import PreparedLibraries, PreparedLibrary, animate_apart, blend_steps
from usdfoot.engine.flight import natural_flights
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
from usdfoot.maths.planar import GROUND_AXES
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.contact_table import lay_contacts

__all__ = ["fly_like_clips"]

CLIPS = "clips"
"""The source of motion whose bodies fly as recorded."""


def fly_like_clips(crowd: Crowd, *, options: EngineOptions, libraries: PreparedLibraries) -> Crowd:
    """The crowd with flights that nobody gave as long as those of the clips their steps are blended from.

    Who cannot be animated stays as planned.

    Args:
        crowd: As read.
        options: Of the engine.
        libraries: Of the crowd.
    """
    flying = [agent for agent in crowd.agents if agent.motion == CLIPS and agent.flights_open and agent.plan.flies]
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
    """The agents, whose clips are one library, with the flights of these clips.

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
    flies = ~setup.segments.stands & (contacts.liftoffs[supports] < contacts.strikes[following])
    flies &= has_flight(lasts, lasts - natural, displacements, leg_length=setup.leg_length)
    flies &= (contacts.steps[supports] >= 0) & (contacts.steps[following] >= 0)
    liftoffs = contacts.liftoffs.copy()
    liftoffs[supports[flies]] = (contacts.strikes[following] - natural)[flies]
    return [
        replace(agent, plan=replace(agent.plan, liftoff_times=liftoffs[own][contacts.steps[own] >= 0]))
        for agent, own in zip(agents, map(slice, contacts.first[:-1], contacts.first[1:]), strict=True)
    ]
