"""Mend: what lint finds and where the remedy is obvious."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from usdfoot.maths.types import IntArray
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.plan_draft import PlanDraft
from usdfoot.planning.collisions import find_collisions
from usdfoot.planning.feet_apart import set_feet_apart
from usdfoot.planning.foot_table import feet_of
from usdfoot.planning.lint import lint_alone
from usdfoot.planning.prints import lay_prints
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.step_limits import limit_steps, uncross

__all__ = ["mend_plans", "mend_times", "strike_order"]

OVERLAP = 0.25
"""Double support given to feet that leave too late, over the step time."""
FALLBACK_CONTACT = 0.7
"""Contact of a foot whose liftoff is wrong and that has no further footstep [s]."""
NEAR_GROUND = 0.5
"""Prints this far above or below the ground are laid on it [m]."""
OFF_GROUND = 0.02
"""Those nearer stay as they are [m]."""
NARROW = 0.6
"""Least distance between a foot and its other one across, over that of an easy step."""


def strike_order(draft: PlanDraft) -> IntArray:
    """Footsteps in order of strike; of the first two that strike together that of the third one's foot comes first."""
    order = np.argsort(draft.strike_times, kind="stable")
    together = len(order) > 2 and draft.strike_times[order[0]] == draft.strike_times[order[1]]
    if together and draft.sides[order[1]] == draft.sides[order[2]]:
        order[:2] = order[1::-1]
    return order


def mend_times(draft: PlanDraft) -> PlanDraft:
    """The draft in order of strike, every liftoff after its strike and before the foot's next.

    Arrays of different lengths and feet that do not alternate are left as they are: what was meant cannot be known.
    """
    arrays = {name: values for name, values in vars(draft).items() if name not in ("name", "styles")}
    lengths = {len(values) for values in arrays.values()} | ({len(draft.styles)} if draft.styles else set())
    if len(lengths) != 1 or len(draft.sides) < 2:
        return draft
    if np.any(np.diff(draft.strike_times) < 0.0):
        order = strike_order(draft)
        styles = tuple(draft.styles[step] for step in order) if draft.styles else ()
        draft = replace(draft, **{name: values[order] for name, values in arrays.items()}, styles=styles)
    strikes, liftoffs = draft.strike_times, draft.liftoff_times.copy()
    latest = np.full(len(strikes), np.inf)
    latest[:-2] = strikes[1:-1] + OVERLAP * (strikes[2:] - strikes[1:-1])
    usual = np.where(np.isfinite(latest), latest, strikes + FALLBACK_CONTACT)
    late = np.flatnonzero(strikes[2:] <= liftoffs[:-2])
    early = np.flatnonzero(~(liftoffs > strikes))
    wrong = np.union1d(late, early)
    liftoffs[wrong] = np.maximum(usual[wrong], strikes[wrong] + 1e-3)
    return replace(draft, liftoff_times=liftoffs)


def mend_plans(plans: Sequence[FootstepPlan], ground: Ground, *, bodies: Sequence[Proportions]) -> list[FootstepPlan]:
    """The plans with crossing feet uncrossed, feet of different people set apart and prints laid on the ground.

    A plan where none of that is needed stays exactly as it is, and so does one that would only get more errors.
    """
    if not plans:
        return []
    feet = feet_of(plans, bodies)
    narrowest = np.array([NARROW * body.step_width for body in bodies])[feet.owners]
    start, wide = feet.positions, np.full(len(feet.owners), np.inf)  # how wide somebody steps is left alone
    limits = limit_steps(feet, narrowest=narrowest, widest=wide)
    crossing = uncross(feet, limits.relaxed(narrower=0.0))
    crossed = np.unique(feet.owners[(crossing.positions != start).any(axis=1)])
    feet = replace(feet, positions=np.where(np.isin(feet.owners, crossed)[:, None], crossing.positions, start))
    if len(plans) > 1 and len(find_collisions(feet).depths):
        feet = set_feet_apart(feet, limits, waits=False)
    moved = (feet.positions != start).any(axis=1)
    if ground.has_terrain:
        prints = lay_prints(ground, feet.positions[:, [0, 2]], feet.yaws, near=feet.positions[:, 1])
        away = prints.positions[:, 1] - feet.positions[:, 1]
        laid = (moved | (np.abs(away) > OFF_GROUND)) & (np.abs(away) < NEAR_GROUND)
    else:
        prints, laid = None, np.zeros(len(start), dtype=bool)
    mended = []
    for index, plan in enumerate(plans):
        own = feet.owners == index
        if not (moved | laid)[own].any():
            mended.append(plan)
            continue
        positions, orientations = feet.positions[own], plan.orientations.copy()
        if prints is not None:
            positions = np.where(laid[own, None], prints.positions[own], positions)
            orientations = np.where(laid[own, None], prints.orientations[own], orientations)
        mended.append(replace(plan, positions=positions, orientations=orientations))
    before, after = (_errors(version, ground, bodies) for version in (plans, mended))
    return [new if after[i] <= before[i] else old for i, (old, new) in enumerate(zip(plans, mended, strict=True))]


def _errors(plans: Sequence[FootstepPlan], ground: Ground, bodies: Sequence[Proportions]) -> Counter[int]:
    """How many errors each plan has, whoever else is there."""
    faults = lint_alone(plans, ground, bodies=bodies, names=[str(index) for index in range(len(plans))])
    return Counter(int(fault.plan) for fault in faults if fault.severity == "error")
