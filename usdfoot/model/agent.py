"""Agent: one with a goal; Crowd: all of them, with the characters and libraries they use."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain

__all__ = ["Agent", "Crowd"]


@dataclass(frozen=True, kw_only=True)
class Agent:
    """One character that walks one plan."""

    name: str
    """Name of the agent prim, unique in the crowd."""
    source: str
    """Path of the agent prim in the scene."""
    plan: FootstepPlan
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

    @property
    def step_root_weights(self) -> FloatArray:
        """lambda4 of each step: the plan's where it has any above 0, else the agent's, shape (N,)."""
        own = self.plan.root_weights
        return own if own.any() else np.full(len(own), self.root_weight)


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
    problems: tuple[Problem, ...] = ()
    """Agents and clips that could not be used, and warnings."""
