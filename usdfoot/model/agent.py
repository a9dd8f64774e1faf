"""Agent: one with a goal; Crowd: all of them, with the characters and libraries they use."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from operator import attrgetter
from typing import Any

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.model.trajectory import RootTrajectory
from usdfoot.model.tuning import BodyTuning

__all__ = ["Agent", "Crowd", "Follower", "Performer", "SampledFrames"]


@dataclass(frozen=True, kw_only=True)
class SampledFrames:
    """At which frames an agent has samples, beside those that its feet ask for."""

    every: int = 1
    """At every so many; 1 = at all."""
    turn: int = 0
    """At time codes that are a multiple of `every` more than this."""


@dataclass(frozen=True, kw_only=True)
class Performer:
    """One character with its clips and settings, whatever it walks."""

    name: str
    """Name of the agent prim, unique in the crowd."""
    source: str
    """Path of the agent prim in the scene."""
    library: int
    """Index of the agent's clip library in the crowd."""
    character: int
    """Index of the agent's character in the scene's characters."""
    ik_reach: float = 0.3
    """Largest horizontal distance IK may pull a landing to its footstep [m] ([B] 5)."""
    root_weight: float = 0.0
    """[B]'s lambda4 of a plan whose own root weights are all 0."""
    replace_distance: float = 0.0
    """[B]'s epsilon [m]."""
    motion: str = "clips"
    """clips | physics | hybrid."""
    tuning: BodyTuning = field(default_factory=BodyTuning)
    """How physics moves it; its library's skeleton has the hips as tuned."""
    sampled: SampledFrames = field(default_factory=SampledFrames)

    def walking(self, plan: FootstepPlan, *, root_trajectory: RootTrajectory | None = None) -> Agent:
        """The agent that walks a plan."""
        return Agent(**self._shared(), plan=plan, root_trajectory=root_trajectory)

    def following(self, trajectory: RootTrajectory) -> Follower:
        """The follower of a trajectory."""
        return Follower(**self._shared(), trajectory=trajectory)

    def _shared(self) -> dict[str, Any]:
        """What agents and followers alike have, by field."""
        return dict(zip(_SHARED, _values_of(self), strict=True))


_SHARED = [known.name for known in fields(Performer)]
_values_of = attrgetter(*_SHARED)


@dataclass(frozen=True, kw_only=True)
class Agent(Performer):
    """One character that walks one plan."""

    plan: FootstepPlan
    root_trajectory: RootTrajectory | None = None
    """Where its root goes and faces; None = as the footsteps say ([B] 4.2)."""
    flights_open: bool = False
    """Whether nobody gave the liftoffs of its plan: flights and double supports last as people's do, until it is known
    what its clips show."""

    @property
    def interval(self) -> tuple[float, float]:
        """First and last time of its motion [s]."""
        return self.plan.start, self.plan.end

    @property
    def step_root_weights(self) -> FloatArray:
        """lambda4 of each step: the plan's where it has any above 0, else the agent's, shape (N,)."""
        own = self.plan.root_weights
        return own if own.any() else np.full(len(own), self.root_weight)


@dataclass(frozen=True, kw_only=True)
class Follower(Performer):
    """One that goes along a trajectory; its footsteps are yet to be planned."""

    trajectory: RootTrajectory

    @property
    def interval(self) -> tuple[float, float]:
        """First and last time of its motion [s]."""
        return self.trajectory.start, self.trajectory.end

    def walking(self, plan: FootstepPlan, *, root_trajectory: RootTrajectory | None = None) -> Agent:
        """The agent that walks the footsteps planned for it."""
        weights = np.full(len(plan), self.root_weight)
        return super().walking(replace(plan, root_weights=weights), root_trajectory=root_trajectory)


@dataclass(frozen=True, kw_only=True)
class Crowd:
    """Everything the engine needs, free of USD."""

    agents: tuple[Agent, ...]
    libraries: tuple[ClipLibrary, ...]
    terrain: Terrain
    frame_times: FloatArray
    """Times of the output samples [s], whole time codes of the stage, shape (F,)."""
    frame_rate: float
    """Output samples a second [Hz]."""
    followers: tuple[Follower, ...] = ()
    """Those without footsteps."""
    problems: tuple[Problem, ...] = ()
    """Agents and clips that could not be used, and warnings."""

    @property
    def everyone(self) -> tuple[Agent | Follower, ...]:
        """Agents and followers."""
        return (*self.agents, *self.followers)
