"""A synthesis with its inner parts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import PchipInterpolator

from tests.engine.plans import crowd
from usdfoot.engine.animate import PreparedLibrary, PreparedSteps, prepare_steps
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.segments import Segments
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.examples import LIFTOFF_PHASES
from usdfoot.model.plan import FootstepPlan


def synthesise(
    library: PreparedLibrary,
    plans: Sequence[FootstepPlan],
    *,
    options: EngineOptions | None = None,
    **about: object,
) -> PreparedSteps:
    """The contacts, segments and weights that motions of the plans are made from."""
    scene = crowd(library.source, plans, **about)
    return prepare_steps(library, scene.agents, scene, options=options or EngineOptions())


def slow_phases(segments: Segments, rows: IntArray, times: FloatArray) -> FloatArray:
    """Phases of segments at times, one by one: PCHIP to the blended examples' events, straight between them."""
    phases = []
    for row, time in zip(rows, times, strict=True):
        knots, shares = segments.knot_times[row], segments.knot_shares[row]
        share = PchipInterpolator(knots, shares)(np.clip(time, knots[0], knots[-1]))
        phases.append(np.interp(share, shares, [0.0, *LIFTOFF_PHASES, 1.0]))
    return np.array(phases)
