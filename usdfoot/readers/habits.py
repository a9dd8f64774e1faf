"""Habits of agents: how they step, as the clips show that move them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from usdfoot.analysis.examples import build_examples
from usdfoot.bridge.tokens import Motion
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.examples import Examples
from usdfoot.model.path import WalkingPath
from usdfoot.planning.gait import derive_gait
from usdfoot.planning.habits import PEOPLE, Habits, fastest_step, find_habits, narrowest_step
from usdfoot.planning.hurry import MOST_HURRY, unhurried_time
from usdfoot.planning.proportions import Proportions
from usdfoot.readers.agents import AgentSource, read_agent_options
from usdfoot.readers.casting import Casting
from usdfoot.spaces.library import FootstepSpaces, spaces_of

if TYPE_CHECKING:
    from usdfoot.engine.animate import ExamplesBuilder

__all__ = ["HabitsReader"]


SIDEWAYS = 0.8
"""Part of IK's reach that steps as narrow as asked may take; the rest is for their lengths and turns."""


class HabitsReader:
    """How agents of one stage step, found once for each library of clips.

    Args:
        motion: Of all agents; None = what each says.
        build: Cuts the steps of clips; None = `build_examples`.
    """

    def __init__(self, *, motion: str | None = None, build: ExamplesBuilder | None = None) -> None:
        self._motion = motion
        self._build: ExamplesBuilder = build or build_examples
        self._examples: dict[int, Examples] = {}
        self._habits: dict[int, Habits] = {}
        self._spaces: dict[int, FootstepSpaces] = {}

    def read(self, casting: Casting, source: AgentSource) -> Habits:
        """Habits of an agent; people's where no clips move it, or none that can be used: animating it tells why."""
        try:
            library = self._library_of(casting, source)
            if library is None:
                return PEOPLE
            if id(library) not in self._habits:
                examples = self._examples_of(library)
                self._habits[id(library)] = find_habits(examples, leg_length=library.biped.maximal_leg_length)
            return self._habits[id(library)]
        except UsdfootError:
            return PEOPLE

    def styles(self, casting: Casting, source: AgentSource) -> tuple[str, ...]:
        """Styles of the clips that move an agent; none where no clips do, or none that can be used."""
        try:
            library = self._library_of(casting, source)
            return () if library is None else tuple(sorted({str(each) for each in self._examples_of(library).styles}))
        except UsdfootError:
            return ()

    def fastest(self, casting: Casting, source: AgentSource) -> float:
        """Speed of the fastest step of the clips that move an agent [m/s]; no limit where no clips do."""
        try:
            library = self._library_of(casting, source)
            return float("inf") if library is None else fastest_step(self._examples_of(library))
        except UsdfootError:  # animating it tells why
            return float("inf")

    def body_of(self, casting: Casting, source: AgentSource) -> Proportions:
        """Proportions of an agent's character with its habits; a person's if it has none that can be used."""
        return replace(casting.body_of(source), habits=self.read(casting, source))

    def unhurried(self, path: WalkingPath, casting: Casting, source: AgentSource, *, body: Proportions) -> WalkingPath:
        """The path of an agent, slower where its steps would be so quick that its clips had to be hurried too much.

        Who is given a speed alone goes no faster than the fastest step of the clips, hurried as much as they can be.
        """
        if not path.step_length:
            fastest = MOST_HURRY * self.fastest(casting, source)
            return replace(path, speed=fastest) if path.speed > fastest else path
        if not path.speed:
            return path
        try:
            library = self._library_of(casting, source)
            if library is None or not len(examples := self._examples_of(library)):
                return path
            spaces = self._spaces_of(library)
            gait = derive_gait(body, speed=path.speed, step_length=path.step_length, step_width=path.step_width)
            style = path.style or examples.default_style
            quickest = unhurried_time(gait, spaces, np.asarray(examples.durations, dtype=float), style=style)
        except UsdfootError:  # animating it tells why
            return path
        if quickest <= gait.step_time:
            return path
        return replace(path, speed=path.step_length / quickest, quickest_step=quickest)

    def in_reach(self, path: WalkingPath, casting: Casting, source: AgentSource) -> WalkingPath:
        """The path of an agent, with wider steps where IK may not pull its clips' steps to such narrow ones."""
        if not path.step_width:
            return path
        try:
            library = self._library_of(casting, source)
            if library is None:
                return path
            reach = read_agent_options(source, casting.units).ik_reach
            narrowest = narrowest_step(self._examples_of(library)) - SIDEWAYS * reach
        except UsdfootError:  # animating it tells why
            return path
        return replace(path, step_width=narrowest) if path.step_width < narrowest else path

    def _library_of(self, casting: Casting, source: AgentSource) -> ClipLibrary | None:
        """Clips that move an agent, None where physics does."""
        motion = self._motion or read_agent_options(source, casting.units).motion
        return None if motion == Motion.PHYSICS else casting.library_of(source)

    def _examples_of(self, library: ClipLibrary) -> Examples:
        if id(library) not in self._examples:
            self._examples[id(library)] = self._build(library, samples=EngineOptions().samples)[0]
        return self._examples[id(library)]

    def _spaces_of(self, library: ClipLibrary) -> FootstepSpaces:
        if id(library) not in self._spaces:
            self._spaces[id(library)] = spaces_of(library, self._examples_of(library))
        return self._spaces[id(library)]
