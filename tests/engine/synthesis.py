"""A synthesis with its inner parts: what the recipe handed from one room to the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from unittest.mock import patch

from tests.engine.plans import crowd
from usdfoot.engine import animate
from usdfoot.engine.animate import PreparedLibrary, animate_agents
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.poses import Setup, StepBlend
from usdfoot.model.motion import Motion
from usdfoot.model.plan import FootstepPlan


@dataclass(frozen=True, kw_only=True)
class Synthesis:
    motions: list[Motion]
    setup: Setup
    blend: StepBlend


def synthesise(
    library: PreparedLibrary,
    plans: Sequence[FootstepPlan],
    *,
    options: EngineOptions | None = None,
    **about: object,
) -> Synthesis:
    """Motions of plans, with the contacts, segments and weights they were made from."""
    scene = crowd(library.source, plans, **about)
    with patch.object(animate, "measure_steps", wraps=animate.measure_steps) as watched:
        motions = animate_agents(library, scene.agents, scene, options=options or EngineOptions())
    setup, blend = watched.call_args.args[:2]
    return Synthesis(motions=motions, setup=setup, blend=blend)
