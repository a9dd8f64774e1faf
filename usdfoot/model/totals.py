"""Totals: figures of the steps of many agents, which add up without the steps themselves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import fsum
from typing import NamedTuple

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.model.motion import StepResults

__all__ = ["FIGURES", "StepTotals", "Total", "add_totals", "sum_results", "sum_steps"]

PROMISED = ("ok", "outsideHull")
"""Status of steps whose placement is promised."""
VELOCITY = "root_velocity_error"
FIGURES = ("blend_error", "placement_error", "slide", "yaw_error", "hull_distance", VELOCITY)
"""Fields of `StepResults` that are summed: the last over all steps, the others over those that are promised."""


class Total(NamedTuple):
    """A figure of several steps; what is not finite does not count."""

    steps: int = 0
    sum: float = 0.0
    most: float = 0.0

    @property
    def mean(self) -> float:
        """NaN of no steps."""
        return self.sum / self.steps if self.steps else float("nan")


@dataclass(frozen=True, kw_only=True)
class StepTotals:
    """How many steps there are, and their figures."""

    steps: int
    promised: int
    """Those whose placement is promised."""
    figures: Mapping[str, Total]
    """By name, of FIGURES; metres, degrees and metres a second."""


def sum_steps(status: Sequence[str], figures: Mapping[str, FloatArray]) -> StepTotals:
    """Totals of N steps; sums are rounded once, so that they are the same on every machine.

    Args:
        status: Of each step.
        figures: Of each step, by name, shape (N,) each; metres, degrees and metres a second.
    """
    promised = np.array([each in PROMISED for each in status], dtype=bool)

    def total(name: str) -> Total:
        values = np.asarray(figures[name], dtype=float)
        values = values[np.isfinite(values) if name == VELOCITY else promised & np.isfinite(values)]
        return Total(len(values), fsum(values.tolist()), float(values.max())) if values.size else Total()

    return StepTotals(
        steps=len(promised), promised=int(promised.sum()), figures={name: total(name) for name in FIGURES}
    )


def sum_results(results: StepResults) -> StepTotals:
    """Totals of an agent's steps."""
    figures = {name: getattr(results, name) for name in FIGURES}
    return sum_steps(results.status, {**figures, "yaw_error": np.degrees(results.yaw_error)})


def add_totals(parts: Iterable[StepTotals]) -> StepTotals:
    """Totals of all parts together."""
    parts = [*parts]

    def total(name: str) -> Total:
        own = [part.figures[name] for part in parts if part.figures[name].steps]
        if not own:
            return Total()
        return Total(sum(each.steps for each in own), fsum(each.sum for each in own), max(each.most for each in own))

    return StepTotals(
        steps=sum(part.steps for part in parts),
        promised=sum(part.promised for part in parts),
        figures={name: total(name) for name in FIGURES},
    )
