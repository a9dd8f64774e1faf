"""Totals of steps against the steps themselves."""

import numpy as np
import pytest

from usdfoot.model.motion import STATUSES, StepResults
from usdfoot.model.totals import FIGURES, add_totals, sum_results


def results_of(steps: int, seed: int) -> StepResults:
    rng = np.random.default_rng(seed)
    figures = {name: rng.exponential(size=steps) for name in FIGURES}
    figures["placement_error"][::3] = np.nan
    rest = dict.fromkeys(("time_warp", "root_weight", "beta"), np.ones(steps))
    return StepResults(
        **figures,
        **rest,
        status=tuple(rng.choice(STATUSES, steps).tolist()),
        clip_counts=np.zeros(steps, dtype=int),
        clips=(),
        clip_weights=np.zeros(0),
    )


def test_totals_of_agents_add_up_to_those_of_all_their_steps():
    parts = [results_of(steps, steps) for steps in (7, 0, 30, 1)]
    totals = add_totals(sum_results(part) for part in parts)
    kept = np.array([status in ("ok", "outsideHull") for part in parts for status in part.status])
    assert (totals.steps, totals.promised) == (38, kept.sum())
    for name in FIGURES:
        values = np.concatenate([getattr(part, name) for part in parts])
        values = values if name == "root_velocity_error" else values[kept]
        values = np.degrees(values) if name == "yaw_error" else values
        figure = totals.figures[name]
        assert figure.steps == np.isfinite(values).sum()
        assert figure.mean == pytest.approx(np.nanmean(values), rel=1e-12) and figure.most == np.nanmax(values)


def test_nobody_has_no_figures():
    totals = add_totals([])
    assert totals.steps == 0 and np.isnan(totals.figures["slide"].mean)
