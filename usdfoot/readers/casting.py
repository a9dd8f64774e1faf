"""Casting: gives agents their character and clips."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
from pxr import Sdf, Usd, UsdShade, UsdSkel

from usdfoot.analysis.hip_spacing import space_hips
from usdfoot.bridge.own_attributes import OwnAttribute, OwnAttributes, OwnBinding
from usdfoot.bridge.scene import Character
from usdfoot.bridge.tokens import Motion, Plan
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import UsdfootError
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Agent, Follower, Performer
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.limits import DEFAULT_LIMITS
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.trajectory import RootTrajectory
from usdfoot.model.tuning import BodyTuning
from usdfoot.planning.proportions import Proportions, proportions_of
from usdfoot.readers.agent_libraries import AgentLibraries
from usdfoot.readers.agents import OPTIONS, AgentSource, read_agent_options
from usdfoot.readers.assets import said_over
from usdfoot.readers.authored import authored_or_primvar
from usdfoot.readers.bindings import BindingReader
from usdfoot.readers.candidates import find_skeleton, only_character
from usdfoot.readers.characters import character_key, read_character
from usdfoot.readers.clip_sources import ClipFinder
from usdfoot.readers.own_attributes import read_own
from usdfoot.readers.stage import StagePrims
from usdfoot.readers.tuning import TUNINGS, read_tuning
from usdfoot.retarget.rig import legs_as_rigged

__all__ = ["Casting", "holds_skeleton", "skipped"]


_SAYS_MORE = frozenset((*OPTIONS, *TUNINGS))
"""Properties of agents that are not alike."""
_Found = TypeVar("_Found", int, Usd.Prim)


@dataclass(kw_only=True)
class Casting:
    """Gives agents their character and clips, reading each only once."""

    prims: StagePrims
    foreign: tuple[Usd.Prim, ...]
    """Plans and terrain."""
    units: StageUnits
    frame_codes: FloatArray
    finder: ClipFinder
    most_frames: int = DEFAULT_LIMITS.frames
    """Samples that a clip may have."""
    motion: str | None = None
    """Of all agents; None = what each says."""
    tuning: BodyTuning = field(default_factory=BodyTuning)
    """Of all agents, over what each says."""
    characters: list[Character] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)
    _only: Usd.Prim | UsdfootError | None = None
    _tuning_of: dict[str, BodyTuning] = field(default_factory=dict)
    _performer_of: dict[tuple[Sdf.Path, tuple[Sdf.Path, ...]], Performer] = field(default_factory=dict)
    _key_of: dict[tuple[Sdf.Path, float], tuple[object, ...]] = field(default_factory=dict)
    _own_of: dict[Sdf.Path, OwnAttributes] = field(default_factory=dict)
    _bindings: BindingReader = field(default_factory=BindingReader)
    _character_of: dict[object, int | UsdfootError] = field(default_factory=dict)
    _library_of: dict[object, int | UsdfootError] = field(default_factory=dict)
    _libraries: AgentLibraries = field(init=False)

    def __post_init__(self) -> None:
        self._libraries = AgentLibraries(
            finder=self.finder, units=self.units, most_frames=self.most_frames, problems=self.problems
        )

    @property
    def libraries(self) -> Sequence[ClipLibrary]:
        """Clips on characters, by the indices that agents have."""
        return self._libraries.libraries

    @classmethod
    def to_look(
        cls, stage: Usd.Stage, prims: StagePrims, units: StageUnits, *, foreign: Sequence[Usd.Prim] = ()
    ) -> Casting:
        """Only to look at characters and clips, at one instant."""
        finder = ClipFinder(stage, prims)
        return cls(prims=prims, foreign=tuple(foreign), units=units, frame_codes=np.zeros(1), finder=finder)

    def cast(
        self, source: AgentSource, plan: FootstepPlan, root_trajectory: RootTrajectory | None = None
    ) -> Agent | None:
        """The agent that walks a plan; None, and a problem noted, if it cannot be used."""
        performer = self._performer(source)
        if performer is None:
            return None
        if performer.root_weight and (plan.root_weights.any() or authored_or_primvar(source.plan, Plan.ROOT_WEIGHTS)):
            performer = replace(performer, root_weight=0.0)  # artists add some to the plan's own
        elif performer.root_weight:
            plan = replace(plan, root_weights=np.full(len(plan), performer.root_weight))
        return performer.walking(plan, root_trajectory=root_trajectory)

    def cast_follower(self, source: AgentSource, trajectory: RootTrajectory) -> Follower | None:
        """The agent that goes along a trajectory; None, and a problem noted, if it cannot be used."""
        performer = self._performer(source)
        return None if performer is None else performer.following(trajectory)

    def _performer(self, source: AgentSource) -> Performer | None:
        likeness = _likeness(source)
        known = self._performer_of.get(likeness) if likeness else None
        if known:
            return Performer(**{**vars(known), "name": source.name, "source": str(source.prim.GetPath())})
        try:
            performer = self._read_performer(source)
        except UsdfootError as error:
            self.problems.append(skipped(source, error))
            return None
        if likeness:
            self._performer_of[likeness] = performer
        return performer

    def _read_performer(self, source: AgentSource) -> Performer:
        options = read_agent_options(source, self.units)
        motion = self.motion or options.motion
        character, prim = self._character(source)
        return Performer(
            name=source.name,
            source=str(source.prim.GetPath()),
            library=self._library(source, character, prim, required=motion != Motion.PHYSICS),
            character=character,
            ik_reach=options.ik_reach,
            root_weight=options.root_weight,
            replace_distance=options.replace_distance,
            motion=motion,
            tuning=self._tuning(source),
        )

    def character_of(self, source: AgentSource) -> Character:
        """The character of an agent.

        Raises:
            UsdfootError: If it has none that can be used.
        """
        return self.characters[self._character(source)[0]]

    def own_attributes_of(self, source: AgentSource) -> OwnAttributes:
        """Attributes that describe an agent, and materials bound to it, by name: its character's, and its prim's.

        The latter are stronger, except over a character that is below the prim and has its own, as USD has it.

        Raises:
            UsdfootError: If it has no character that can be used.
        """
        prim = source.character or self._character(source)[1]
        path = prim.GetPath()
        own = self._own_of.get(path)
        if own is None:
            own = self._own_of[path] = self._own(prim, said_over(prim), prim)
        if not source.is_authored or source.prim == prim:
            return own
        agents = self._own(source.prim, source.properties, prim)
        if not path.HasPrefix(source.prim.GetPath()):
            return {**own, **agents}
        return {**agents, **{name: said for name, said in own.items() if not _is_strong(agents.get(name))}}

    def _own(self, prim: Usd.Prim, names: Collection[str], character: Usd.Prim) -> OwnAttributes:
        return {**read_own(prim, names), **self._bindings.read(prim, names, character=character)}

    def body_of(self, source: AgentSource) -> Proportions:
        """Proportions of an agent's character; a person's if it has none that can be used."""
        try:
            character = self.character_of(source)
        except UsdfootError:
            return Proportions()
        return proportions_of(character.skeleton, character.biped, character.bind_pose)

    def library_of(self, source: AgentSource) -> ClipLibrary:
        """The clips of an agent on its character; none if it has no clips.

        Raises:
            UsdfootError: If it has no character that can be used.
        """
        character, prim = self._character(source)
        return self.libraries[self._library(source, character, prim, required=False)]

    def _character(self, source: AgentSource) -> tuple[int, Usd.Prim]:
        """Index of the agent's character, and its prim."""
        prim = source.character or (source.prim if source.is_authored and holds_skeleton(source.prim) else None)
        prim = prim or self._only_character()
        spacing = self._tuning(source).given.get("hip_spacing", 1.0)
        place = (prim.GetPath(), spacing)
        key = self._key_of.get(place)
        if key is None:
            key = self._key_of[place] = (*character_key(prim, self.units), spacing)
        if key not in self._character_of:
            try:
                self.characters.append(_spaced(read_character(prim, self.units, self.frame_codes), spacing))
                self._character_of[key] = len(self.characters) - 1
            except UsdfootError as error:
                self._character_of[key] = error
        return _or_raise(self._character_of[key]), prim

    def _tuning(self, source: AgentSource) -> BodyTuning:
        if source.name not in self._tuning_of:
            self._tuning_of[source.name] = self.tuning.over(read_tuning(source, self.units))
        return self._tuning_of[source.name]

    def _only_character(self) -> Usd.Prim:
        """The stage's only character, looked for once."""
        if self._only is None:
            try:
                self._only = only_character(self.prims, self.foreign)
            except UsdfootError as error:
                self._only = error
        return _or_raise(self._only)

    def _library(self, source: AgentSource, character: int, prim: Usd.Prim, *, required: bool) -> int:
        """Index of the library with the agent's clips on its character."""
        key = (character, source.clips, required)
        if key not in self._library_of:
            own = self.characters[character]
            try:
                skeleton = find_skeleton(prim)
                self._library_of[key] = self._libraries.add(source.clips, own, skeleton, required=required)
            except UsdfootError as error:
                self._library_of[key] = error
        return _or_raise(self._library_of[key])

    def unfit_clips(self) -> tuple[Problem, ...]:
        """A warning for each clip nobody asked for that fits none of the characters."""
        return self._libraries.unfit_clips()


def skipped(source: AgentSource, error: UsdfootError) -> Problem:
    """The problem of an agent that cannot be used."""
    path = str(source.prim.GetPath())
    message = str(error) if error.where.startswith(path) else f"{path}: {error}"
    return Problem(severity="error", where=path, message=message)


def _spaced(character: Character, spacing: float) -> Character:
    """The character with legs as rigged and its hips spaced."""
    skeleton = legs_as_rigged(character.skeleton, character.biped, character.bind_pose)
    return replace(character, skeleton=space_hips(skeleton, character.biped, spacing))


def _or_raise(result: _Found | UsdfootError) -> _Found:
    if isinstance(result, UsdfootError):
        raise result
    return result


def _likeness(source: AgentSource) -> tuple[Sdf.Path, tuple[Sdf.Path, ...]] | None:
    """What an agent has in common with all who say no more of themselves than whom they look like; None = it says more.

    These differ in name and way.
    """
    if source.character is None or source.override or not _SAYS_MORE.isdisjoint(source.properties):
        return None
    return source.character.GetPath(), source.clips


def _is_strong(said: OwnAttribute | OwnBinding | None) -> bool:
    """Whether it goes over what is said below."""
    return isinstance(said, OwnBinding) and said.strength == UsdShade.Tokens.strongerThanDescendants


def holds_skeleton(prim: Usd.Prim) -> bool:
    """Whether there is a Skeleton below a prim, or it is one."""
    return any(below.IsA(UsdSkel.Skeleton) for below in Usd.PrimRange(prim, Usd.TraverseInstanceProxies()))
