"""Overlay: what is drawn over a crowd to look at it, as plain arrays."""

from __future__ import annotations

from dataclasses import dataclass, field

from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.motion import StepResults
from usdfoot.model.plan import FootstepPlan

__all__ = ["Lines", "Marks", "Overlay", "Shape", "ShownAgent"]


@dataclass(frozen=True, kw_only=True)
class ShownAgent:
    """One agent to draw, with N footsteps."""

    name: str
    plan: FootstepPlan
    """As executed."""
    foot_length: float
    """From ankle to ball [m]."""
    results: StepResults
    """As recorded; errors are NaN where nothing is."""
    com_times: FloatArray
    """[s], increasing, shape (F,)."""
    com_positions: FloatArray
    """Centre of mass in the world at these times [m], shape (F, 3)."""


@dataclass(frozen=True, kw_only=True)
class Shape:
    """A small mesh in its own frame: +Y up, +Z forward."""

    name: str
    """Also its prim's."""
    points: FloatArray
    """[m], shape (V, 3)."""
    counts: IntArray
    """Corners of each face, shape (F,)."""
    indices: IntArray
    """Points of the faces, counter-clockwise seen from outside, shape (sum of counts,)."""
    color: tuple[float, float, float]
    """Linear RGB."""


@dataclass(frozen=True, kw_only=True)
class Marks:
    """N instances of a few shapes, still (T = 1) or at T times."""

    path: str
    """Kind, and name below it."""
    shapes: tuple[Shape, ...]
    times: FloatArray
    """[s], shape (T,)."""
    kinds: IntArray
    """Shape of each instance, shape (T, N)."""
    positions: FloatArray
    """In the world [m], shape (T, N, 3)."""
    orientations: FloatArray
    """Unit xyzw, shape (T, N, 4)."""
    scales: FloatArray
    """Along the shape's axes, shape (T, N, 3)."""
    hidden: BoolArray
    """Instances that are not there, shape (T, N)."""
    agents: IntArray
    """Whose each instance is, shape (N,)."""
    footsteps: IntArray
    """Which footstep of that agent, -1 = none in particular, shape (N,)."""

    def __post_init__(self) -> None:
        times, count = self.positions.shape[:2]
        found = {
            "times": self.times.shape == (times,),
            "kinds": self.kinds.shape == (times, count),
            "orientations": self.orientations.shape == (times, count, 4),
            "scales": self.scales.shape == (times, count, 3),
            "hidden": self.hidden.shape == (times, count),
            "agents": self.agents.shape == (count,),
            "footsteps": self.footsteps.shape == (count,),
        }
        wrong = [name for name, fits in found.items() if not fits]
        if wrong:
            raise ValueError(f"{self.path}: {', '.join(wrong)} do not fit {times} x {count} positions")


@dataclass(frozen=True, kw_only=True)
class Lines:
    """Polylines that stand still."""

    path: str
    """Kind, and name below it."""
    counts: IntArray
    """Points of each line, shape (L,)."""
    points: FloatArray
    """In the world [m], shape (sum of counts, 3)."""
    colors: FloatArray
    """Linear RGB at the points, shape (sum of counts, 3)."""
    width: float
    """[m]."""
    agents: IntArray
    """Whose each line is, shape (L,)."""


@dataclass(frozen=True, kw_only=True)
class Overlay:
    """All that is drawn over some agents."""

    agents: tuple[str, ...]
    """Names; what `agents` of the parts count."""
    marks: tuple[Marks, ...] = ()
    lines: tuple[Lines, ...] = ()
    notes: dict[str, float] = field(default_factory=dict)
    """How lengths stand for other quantities, by name."""
