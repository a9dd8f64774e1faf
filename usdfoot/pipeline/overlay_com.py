"""The curve of the centre of mass, coloured by which feet stand ([P] Figure 15)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.analysis.phases import DOUBLE, FLIGHT, LEFT_STANCE, RIGHT_STANCE, phase_changes, stance_phases
from usdfoot.maths.types import FloatArray
from usdfoot.model.overlay import Lines, ShownAgent

__all__ = ["PHASE_COLORS", "draw_com"]

PHASE_COLORS = {
    LEFT_STANCE: (0.9, 0.0, 0.75),
    RIGHT_STANCE: (0.9, 0.02, 0.02),
    DOUBLE: (0.02, 0.05, 0.6),
    FLIGHT: (0.45, 0.75, 1.0),
}
"""Magenta, red, dark blue and pale blue as in the paper, linear RGB."""
WIDTH = 0.012
"""Of the curve [m]."""


def draw_com(agents: Sequence[ShownAgent]) -> Lines:
    """A line for each agent from its first strike to its last liftoff; colours change where a foot comes or goes."""
    palette = np.array([PHASE_COLORS[phase] for phase in range(len(PHASE_COLORS))])
    lines = [_line(agent) for agent in agents]
    return Lines(
        path="Com",
        counts=np.array([len(points) for points, _ in lines]),
        points=np.concatenate([points for points, _ in lines]),
        colors=palette[np.concatenate([phases for _, phases in lines])],
        width=WIDTH,
        agents=np.arange(len(agents)),
    )


def _line(agent: ShownAgent) -> tuple[FloatArray, np.ndarray]:
    """Points (V, 3) and the phase at each (V,); where the phase changes there are two points on one spot."""
    plan, times = agent.plan, agent.com_times
    changes = phase_changes(plan)
    changes = changes[(changes > times[0]) & (changes < times[-1])]
    within = times[(times >= plan.start) & (times <= plan.end)]
    whole = np.setdiff1d(within, changes)
    stamps = np.concatenate([whole, changes, changes])
    ends = np.concatenate([np.zeros(len(whole) + len(changes)), np.ones(len(changes))])  # 0 = still the old phase
    order = np.lexsort((ends, stamps))
    stamps, ends = stamps[order], ends[order]
    bounds = np.concatenate([[plan.start], changes, [plan.end]])
    phases = stance_phases(plan, 0.5 * (bounds[:-1] + bounds[1:]))
    interval = np.searchsorted(changes, stamps, side="left") + ends.astype(int)
    points = np.stack([np.interp(stamps, times, agent.com_positions[:, axis]) for axis in range(3)], axis=1)
    return points, phases[interval]
