"""Libraries prepared once for all tests of the engine."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest

from tests.engine.plans import crowd
from tests.engine.walkers import OTHERS, WALKS, library_of
from usdfoot.engine.animate import PreparedLibrary, animate_agents, prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.model.motion import Motion
from usdfoot.model.plan import FootstepPlan

Animate = Callable[..., list[Motion]]


@pytest.fixture(scope="session")
def walker_library() -> PreparedLibrary:
    """Walks of many lengths and widths, backward and side steps, turns and runs."""
    return prepare_library(library_of([*WALKS, *OTHERS]), EngineOptions())


@pytest.fixture(scope="session")
def animate(walker_library: PreparedLibrary) -> Animate:
    """Motions of plans on the walker library, or on another one."""

    def run(
        plans: Sequence[FootstepPlan],
        *,
        options: EngineOptions | None = None,
        library: PreparedLibrary = walker_library,
        **about: object,
    ) -> list[Motion]:
        scene = crowd(library.source, plans, **about)
        return animate_agents(library, scene.agents, scene, options=options or EngineOptions())

    return run
