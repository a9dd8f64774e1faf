"""Flying: plans whose runs nobody timed fly as long as the clips of who runs them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from usdfoot.batch.analysed import build_once
from usdfoot.engine.animate import PreparedLibraries
from usdfoot.engine.options import EngineOptions
from usdfoot.model.agent import Crowd
from usdfoot.model.terrain import Terrain
from usdfoot.planning.flights import fly_like_clips
from usdfoot.readers.agents import AgentSource
from usdfoot.readers.casting import Casting
from usdfoot.writers.plans import PlannedAgent

__all__ = ["flying_like_clips", "runs_like_clips"]


def flying_like_clips(
    planned: Sequence[PlannedAgent], sources: Sequence[AgentSource], *, terrain: Terrain, casting: Casting
) -> list[PlannedAgent]:
    """The plans, those of agents with clips with the liftoffs that animating them gives.

    Args:
        planned: Of agents, or of nobody: these stay as they are.
        sources: Of all these agents.
        terrain: They walk on.
        casting: Of their scene.
    """
    source_of = {source.name: source for source in sources}
    cast = [casting.cast(source_of[part.name], part.plan) for part in planned if part.agent]
    crowd = Crowd(
        agents=tuple(replace(agent, flights_open=True) for agent in cast if agent),
        libraries=tuple(casting.libraries),
        terrain=terrain,
        frame_times=casting.frame_codes,
        frame_rate=casting.units.time_codes_per_second,
    )
    options = EngineOptions()
    flown = fly_like_clips(crowd, options=options, libraries=PreparedLibraries(options, build=build_once))
    liftoffs = {agent.name: agent.plan.liftoff_times for agent in flown.agents}
    return [
        replace(part, plan=replace(part.plan, liftoff_times=liftoffs.get(part.name, part.plan.liftoff_times)))
        for part in planned
    ]


def runs_like_clips(
    planned: Sequence[PlannedAgent], sources: Sequence[AgentSource], *, terrain: Terrain, casting: Casting
) -> list[PlannedAgent]:
    """The plans, those with a flight as `flying_like_clips` has them, the others as they are.

    Args:
        planned: Of agents, or of nobody.
        sources: Of all these agents.
        terrain: They walk on.
        casting: Of their scene.
    """
    runs = [part for part in planned if np.any(part.plan.liftoff_times[:-1] < part.plan.strike_times[1:])]
    flown = {part.name: part for part in flying_like_clips(runs, sources, terrain=terrain, casting=casting)}
    return [flown.get(part.name, part) for part in planned]
