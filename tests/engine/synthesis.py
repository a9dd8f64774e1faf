"""A synthesis with its inner parts."""

from __future__ import annotations

from collections.abc import Sequence

from tests.engine.plans import crowd
from usdfoot.engine.animate import PreparedLibrary, PreparedSteps, prepare_steps
from usdfoot.engine.options import EngineOptions
from usdfoot.model.plan import FootstepPlan


def synthesise(
    library: PreparedLibrary,
    plans: Sequence[FootstepPlan],
    *,
    options: EngineOptions | None = None,
    **about: object,
) -> PreparedSteps:
    """The contacts, segments and weights that motions of the plans are made from."""
    scene = crowd(library.source, plans, **about)
    return prepare_steps(library, scene.agents, scene, options=options or EngineOptions())
