"""Habits of agents: how they step, as the clips show that move them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from usdfoot.analysis.examples import build_examples
from usdfoot.bridge.tokens import Motion
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
from usdfoot.planning.habits import PEOPLE, Habits, find_habits
from usdfoot.planning.proportions import Proportions
from usdfoot.readers.agents import AgentSource, read_agent_options
from usdfoot.readers.casting import Casting

if TYPE_CHECKING:
    from usdfoot.engine.animate import ExamplesBuilder

__all__ = ["HabitsReader"]


class HabitsReader:
    """How agents of one stage step, found once for each library of clips.

    Args:
        motion: Of all agents; None = what each says.
        build: Cuts the steps of clips; None = `build_examples`.
    """

    def __init__(self, *, motion: str | None = None, build: ExamplesBuilder | None = None) -> None:
        self._motion = motion
        self._build: ExamplesBuilder = build or build_examples
        self._known: dict[int, Habits] = {}

    def read(self, casting: Casting, source: AgentSource) -> Habits:
        """Habits of an agent; people's where no clips move it, or none that can be used: animating it tells why."""
        try:
            if (self._motion or read_agent_options(source, casting.units).motion) == Motion.PHYSICS:
                return PEOPLE
            library = casting.library_of(source)
            if id(library) not in self._known:
                examples, _ = self._build(library, samples=EngineOptions().samples)
                self._known[id(library)] = find_habits(examples, leg_length=library.biped.maximal_leg_length)
            return self._known[id(library)]
        except UsdfootError:
            return PEOPLE

    def body_of(self, casting: Casting, source: AgentSource) -> Proportions:
        """Proportions of an agent's character with its habits; a person's if it has none that can be used."""
        return replace(casting.body_of(source), habits=self.read(casting, source))
