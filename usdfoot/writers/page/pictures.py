"""What the page shows of a crowd: arrays in the canonical world, and figures beside their targets."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.motion import StepResults
from usdfoot.model.plan import FootstepPlan
from usdfoot.writers.page.ground import GroundPicture

__all__ = ["AgentPicture", "CrowdPicture", "PageFigure", "StickFigure"]


@dataclass(frozen=True, kw_only=True)
class PageFigure:
    """One quantity of design.md section 10, of every footstep or of every agent."""

    key: str
    """Of the values in `AgentPicture.steps` or `AgentPicture.whole`."""
    title: str
    unit: str
    """Of the values and the target; "" = a pure number."""
    digits: int
    """Shown after the point."""
    meaning: str
    """One sentence."""
    target: float | None = None
    """None = reported, without a target."""
    at_least: bool = False
    """Whether values below the target miss it, instead of values above."""
    of_mean: bool = False
    """Whether the target is one of the mean, not of every value."""
    per_agent: bool = False
    """Whether there is one value an agent, not one a footstep."""


@dataclass(frozen=True, kw_only=True)
class StickFigure:
    """The joints that are drawn of one skeleton: K of them, the pelvis first."""

    joints: tuple[int, ...]
    """Their indices in the skeleton."""
    parents: tuple[int, ...]
    """Place among them of each joint's parent, -1 for the pelvis."""
    sides: tuple[int, ...]
    """0 = of the left leg, 1 = of the right leg, 2 = of the rest."""
    head: int
    """Place among them of the head, -1 = none is known."""
    leg_length: float
    """[m]."""
    foot_length: float
    """From ankle to ball, mean of the feet [m]."""


@dataclass(frozen=True, kw_only=True)
class AgentPicture:
    """One agent: F frames of K joints, N footsteps."""

    name: str
    source: str
    """Path of the agent's prim in the scene, "" if not recorded."""
    plan: FootstepPlan
    flat_times: FloatArray
    """[s], shape (N,)."""
    stick_figure: StickFigure
    times: FloatArray
    """Evenly spaced [s], shape (F,)."""
    roots: FloatArray
    """Of the agent prim [m], shape (F, 3)."""
    joints: FloatArray
    """World positions [m], shape (F, K, 3)."""
    sole_heights: FloatArray
    """Lower of ball and heel of each sole over the terrain [m], NaN = not known, shape (F, 2)."""
    stood: FloatArray
    """Where the ball stood, on the sole, mean over the planted frames [m], NaN = never, shape (N, 3)."""
    promised: BoolArray
    """Whether the status promises the placement, shape (N,)."""
    results: StepResults
    """As recorded."""
    steps: Mapping[str, FloatArray]
    """Values of each figure of footsteps, in its unit, NaN = not known, shape (N,)."""
    whole: Mapping[str, float]
    """Value of each figure of agents, in its unit, NaN = not known."""


@dataclass(frozen=True, kw_only=True)
class CrowdPicture:
    """All that the page shows."""

    title: str
    agents: tuple[AgentPicture, ...]
    figures: tuple[PageFigure, ...]
    ground: GroundPicture
    frame_time: float
    """Between two frames of the agents [s]."""
    code_rate: float
    """Time codes in one second [1/s]."""
    total: tuple[Mapping[str, Any], ...]
    """Rows of the table of figures: name, unit, value, target, atLeast, passed."""
    problems: tuple[str, ...]
    notes: tuple[str, ...]
    """What was left out or simplified, in sentences."""
    facts: Mapping[str, str] = field(default_factory=dict)
    """What the crowd was made from and with, by name."""
