"""Edits of one footstep of a plan, which leave a plan: left and right in turn, times in order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.prints import lay_prints

__all__ = ["add_footstep", "delete_footstep", "lay_footsteps", "move_footstep"]

USUAL_STEP, USUAL_SWING = 0.6, 0.45
"""Times of plans too short to have any of their own [s]."""
LONGEST_SWING = 1.8
"""Of a swing, over the step time: the foot stands for the rest of the stride."""


def move_footstep(
    plan: FootstepPlan, footstep: int, *, position: FloatArray, orientation: FloatArray | None = None
) -> FootstepPlan:
    """The plan with one footstep somewhere else; its times stay.

    Args:
        plan: To edit.
        footstep: Number of the footstep.
        position: Where it shall be [m], shape (3,).
        orientation: How it shall lie, unit xyzw, shape (4,); None = as it does.

    Raises:
        PlanError: If there is no such footstep.
    """
    _check(plan, footstep)
    positions, orientations = plan.positions.copy(), plan.orientations.copy()
    positions[footstep] = position
    orientations[footstep] = orientations[footstep] if orientation is None else orientation
    return replace(plan, positions=positions, orientations=orientations)


def delete_footstep(plan: FootstepPlan, footstep: int) -> FootstepPlan:
    """The plan without a footstep; inside the plan without the one after it too, so that the feet still alternate.

    The feet stay where they stood until those footsteps would have been left, and all others keep their times.

    Raises:
        PlanError: If there is no such footstep or fewer than two would be left.
    """
    _check(plan, footstep)
    inside = 0 < footstep < len(plan) - 1
    gone = [footstep, footstep + 1] if inside else [footstep]
    if len(plan) - len(gone) < 2:
        raise PlanError(plan.name, f"has {len(plan)} footsteps", "a plan needs at least two, this one must stay")
    liftoffs = plan.liftoff_times.copy()
    waiting = [row for row in gone if inside and row >= 2]
    liftoffs[[row - 2 for row in waiting]] = plan.liftoff_times[waiting]
    rows = np.delete(np.arange(len(plan)), gone)
    return _taken(
        plan,
        rows,
        strike_times=plan.strike_times[rows],
        liftoff_times=liftoffs[rows],
        positions=plan.positions[rows],
    )


def add_footstep(
    plan: FootstepPlan, after: int, *, position: FloatArray | None = None, orientation: FloatArray | None = None
) -> FootstepPlan:
    """The plan with one footstep more after its last; after any other one with two more, one for each foot.

    A footstep at the end goes on in the pace of the plan. Two inside it are spread over the step they are put into, and
    all that follows comes later by as much as they take.

    Args:
        plan: To edit.
        after: Number of the footstep before the new one.
        position: Where the (first) new footstep shall be [m], shape (3,); None = as the stride before goes on, or
            between its neighbours.
        orientation: How it shall lie, unit xyzw, shape (4,); None = as the foot's next or last one.

    Raises:
        PlanError: If there is no such footstep.
    """
    _check(plan, after)
    after = 1 if after == 0 and plan.starts_standing else after
    edited = _appended(plan) if after == len(plan) - 1 else _inserted(plan, after)
    new = after + 1
    place = edited.positions[new] if position is None else position
    return move_footstep(edited, new, position=place, orientation=orientation)


def lay_footsteps(plan: FootstepPlan, rows: IntArray, ground: Ground) -> FootstepPlan:
    """The plan with footsteps `rows` on the terrain under them; without terrain as it is."""
    if not ground.has_terrain:
        return plan
    positions, orientations = plan.positions.copy(), plan.orientations.copy()
    prints = lay_prints(ground, positions[rows][:, [0, 2]], plan.yaws[rows], near=positions[rows, 1])
    positions[rows], orientations[rows] = prints.positions, prints.orientations
    return replace(plan, positions=positions, orientations=orientations)


def _appended(plan: FootstepPlan) -> FootstepPlan:
    """One footstep more at the end, of the foot of the last but one."""
    step, swing, overlap = _pace(plan)
    last = len(plan) - 1
    strikes, liftoffs, positions = plan.strike_times, plan.liftoff_times.copy(), plan.positions
    strike = max(liftoffs[last - 1] + swing, strikes[last] + step)
    if plan.ends_standing:
        end = strike + plan.end - strikes[last]
        liftoffs[last] = end
    else:
        end = strike + float(np.median(liftoffs - strikes))
        liftoffs[last] = max(liftoffs[last], strike + overlap)
    stride = positions[last] - positions[max(last - 2, 0)]
    return _taken(
        plan,
        np.append(np.arange(len(plan)), last - 1),
        strike_times=np.append(strikes, strike),
        liftoff_times=np.append(liftoffs, end),
        positions=np.concatenate([positions, positions[last - 1 : last] + stride]),
    )


def _inserted(plan: FootstepPlan, after: int) -> FootstepPlan:
    """Two footsteps more within the step from `after` to the next footstep."""
    step, _, overlap = _pace(plan)
    strikes, liftoffs, positions = plan.strike_times, plan.liftoff_times, plan.positions
    count, following = len(plan), after + 1
    begin, shift = strikes[following], 2.0 * step
    left = max(begin + min(liftoffs[after] - begin, overlap), 0.5 * (strikes[after] + begin))
    left_again = max(liftoffs[after] + shift, begin + 1.1 * step)
    first, second = positions[following], positions[after]
    if 1 <= after < count - 2:
        first = positions[after - 1] + (first - positions[after - 1]) * (2.0 / 3.0)
        second = second + (positions[after + 2] - second) / 3.0
    return _taken(
        plan,
        np.concatenate([np.arange(following), [following, after], np.arange(following, count)]),
        strike_times=np.concatenate([strikes[:following], [begin, begin + step], strikes[following:] + shift]),
        liftoff_times=np.concatenate(
            [liftoffs[:after], [left, begin + step + overlap, left_again], liftoffs[following:] + shift]
        ),
        positions=np.concatenate([positions[:following], [first, second], positions[following:]]),
    )


def _pace(plan: FootstepPlan) -> tuple[float, float, float]:
    """Usual times of a step, of a swing, and from a strike to the other foot's liftoff, below 0 in a run [s]."""
    steps = np.diff(plan.strike_times)
    steps = steps[steps > 0.0]
    swings = plan.strike_times[2:] - plan.liftoff_times[:-2]
    step = float(np.median(steps)) if steps.size else USUAL_STEP
    swing = min(float(np.median(swings)) if swings.size else USUAL_SWING, LONGEST_SWING * step)
    return step, swing, step - swing


def _taken(
    plan: FootstepPlan,
    rows: IntArray,
    *,
    strike_times: FloatArray,
    liftoff_times: FloatArray,
    positions: FloatArray,
) -> FootstepPlan:
    """The plan with times and positions given, and the rest taken from its footsteps `rows`."""
    return replace(
        plan,
        sides=plan.sides[rows],
        orientations=plan.orientations[rows],
        root_weights=plan.root_weights[rows],
        styles=tuple(plan.styles[row] for row in rows) if plan.styles else (),
        strike_times=strike_times,
        liftoff_times=liftoff_times,
        positions=positions,
    )


def _check(plan: FootstepPlan, footstep: int) -> None:
    """Raises PlanError if there is no such footstep."""
    if not 0 <= footstep < len(plan):
        raise PlanError(plan.name, f"has no footstep {footstep}", f"give one of 0 to {len(plan) - 1}")
