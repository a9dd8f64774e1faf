"""Stepping stones: a feasible, comfortable way over given footholds ([P] Figure 13)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from usdfoot.analysis.footstep_times import time_rows
from usdfoot.analysis.timing import STAND_TIME
from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.plan_checks import cut_plans
from usdfoot.model.plan_draft import PlanDraft
from usdfoot.planning.corridor import count_pairs, order_by_way, within_pairs
from usdfoot.planning.crossed import apart_midway
from usdfoot.planning.crossing_graph import HEADINGS, ROUNDED, Way, build_graph
from usdfoot.planning.crossings import Crossing, Stance, Stones
from usdfoot.planning.prints import print_orientations
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.reach import Reach

__all__ = ["find_crossing", "find_crossings", "plan_crossings", "plan_stones"]

MOST_PAIRS = 2_000_000
"""Pairs of footholds within reach of each other that are searched at most, for memory's sake."""
FEWER_PAIRS = (250_000, 1_000_000)
"""Where there are more, so few are searched first."""


def plan_stones(
    stones: Stones,
    start: Stance,
    goal: Stance,
    *,
    reach: Reach,
    body: Proportions | None = None,
    speed: float = 0.0,
    start_time: float = 0.0,
    stand_time: float = STAND_TIME,
    name: str = "stones",
) -> FootstepPlan:
    """The plan of the most comfortable way over stones, standing at both ends, timed by its steps ([P] 4.1).

    Args:
        stones: Where feet may stand besides the stances.
        start: Where both feet are.
        goal: Where both feet shall be.
        reach: Of the character.
        body: Its legs and habits time the steps; None = a person's.
        speed: Mean of all steps [m/s]; 0 = as fast as such steps of the body are.
        start_time: When it begins [s].
        stand_time: How long it stands there, as along paths [s].
        name: Of the plan.

    Raises:
        PlanError: As `find_crossing`.
    """
    (plan,) = plan_crossings(
        stones,
        [start],
        [goal],
        reach=reach,
        body=body,
        speeds=[speed],
        start_time=start_time,
        stand_time=stand_time,
        names=[name],
    )
    if isinstance(plan, PlanError):
        raise plan
    return plan


def plan_crossings(
    stones: Stones,
    starts: Sequence[Stance],
    goals: Sequence[Stance],
    *,
    reach: Reach,
    names: Sequence[str],
    body: Proportions | None = None,
    speeds: Sequence[float] | None = None,
    start_time: float = 0.0,
    stand_time: float = STAND_TIME,
) -> list[FootstepPlan | PlanError]:
    """Plans of many over the same stones, each as by `plan_stones` alone, or why there is none; arguments as there."""
    crossings = find_crossings(stones, starts, goals, reach=reach)
    flight_distance = 0.0 if reach.leaps else float(np.hypot(reach.farthest, reach.rise))  # beyond all steps: no flight
    rule = replace((body or Proportions()).timing, flight_distance=flight_distance)
    found = [crossing for crossing in crossings if isinstance(crossing, Crossing)]
    if not found:
        return [crossing for crossing in crossings if isinstance(crossing, PlanError)]
    led = [number for number, crossing in enumerate(crossings) if isinstance(crossing, Crossing)]
    counts = np.array([len(crossing.sides) for crossing in found])
    columns = ("sides", "positions", "normals", "yaws")
    joined = {name: np.concatenate([getattr(crossing, name) for crossing in found]) for name in columns}
    times = time_rows(
        joined["positions"],
        counts,
        rule=rule,
        speeds=np.array(speeds or [0.0] * len(starts))[led],
        start_times=np.full(len(found), start_time),
        starts_standing=True,
        ends_standing=np.full(len(found), True),
        stand_time=stand_time,
    )
    draft = PlanDraft(
        name="",
        sides=joined["sides"],
        positions=joined["positions"],
        orientations=print_orientations(joined["yaws"], joined["normals"]),
        strike_times=times.strike_times,
        liftoff_times=times.liftoff_times,
        root_weights=np.zeros(counts.sum()),
    )
    plans = iter(cut_plans(draft, counts, names=[names[number] for number in led]))
    return [crossing if isinstance(crossing, PlanError) else next(plans) for crossing in crossings]


def find_crossing(stones: Stones, start: Stance, goal: Stance, *, reach: Reach) -> Crossing:
    """The most comfortable way from stance to stance over footholds.

    A* over (foothold, foot on it, heading): a turn, then a step. A step costs 1 when it is comfortable, and more
    with the square of its difference from that, of its rise and of its turn (`planning/reach.py`). Legs cross neither
    at its end nor midway through its turn. Of more footholds than can be searched at once those are that lie nearest to
    the way that a coarse look over all finds (`planning/corridor.py`), ever more of them until there is a way.

    Args:
        stones: Where feet may stand besides the stances.
        start: Where both feet are.
        goal: Where both feet shall be.
        reach: Of the character.

    Raises:
        PlanError: If no way leads to the goal; it says how far one leads.
    """
    (crossing,) = find_crossings(stones, [start], [goal], reach=reach)
    if isinstance(crossing, PlanError):
        raise crossing
    return crossing


def find_crossings(
    stones: Stones, starts: Sequence[Stance], goals: Sequence[Stance], *, reach: Reach
) -> list[Crossing | PlanError]:
    """The ways of many over the same footholds, each as by `find_crossing` alone, or why there is none.

    Args:
        stones: Where feet may stand besides the stances.
        starts: Where both feet of each are.
        goals: Where both feet of each shall be.
        reach: Of all of them.
    """
    chosen = np.arange(len(stones.positions))
    if count_pairs(stones, reach) <= MOST_PAIRS:
        return _search(stones, starts, goals, reach, chosen)
    return [_search_near_way(stones, start, goal, reach) for start, goal in zip(starts, goals, strict=True)]


def _search_near_way(stones: Stones, start: Stance, goal: Stance, reach: Reach) -> Crossing | PlanError:
    """The most comfortable way over those of very many footholds that lie near a coarse way."""
    order, may_lead = order_by_way(stones, start, goal, reach=reach)
    for most in (*FEWER_PAIRS, MOST_PAIRS):
        (found,) = _search(stones, [start], [goal], reach, within_pairs(stones, order, reach, most=most))
        if not (may_lead and isinstance(found, PlanError)):
            break
    return found


def _search(
    stones: Stones, starts: Sequence[Stance], goals: Sequence[Stance], reach: Reach, chosen: IntArray
) -> list[Crossing | PlanError]:
    """The most comfortable ways over the footholds chosen (K,)."""
    ways = build_graph(stones.only(chosen), reach=reach).search(starts, goals)
    return [
        _crossing(way, stones, chosen, start, goal)
        if way.places.size
        else _unreachable(stones, chosen, way, goal, reach)
        for way, start, goal in zip(ways, starts, goals, strict=True)
    ]


def _crossing(way: Way, stones: Stones, chosen: IntArray, start: Stance, goal: Stance) -> Crossing:
    """Adds the foot that stands beside the first and the one that closes up to the last."""
    sides, first, last = way.sides, 1 - way.sides[0], 1 - way.sides[-1]
    numbers = np.concatenate([np.full(4, -1), chosen])
    normals = np.concatenate([np.tile([0.0, 1.0, 0.0], (4, 1)), stones.normals[chosen]])
    yaws = np.concatenate([[start.yaw], way.yaws[way.headings], [goal.yaw]])
    places = np.concatenate([[first], way.places, [2 + last]])
    positions = way.positions[places]
    return Crossing(
        footholds=numbers[places],
        sides=np.concatenate([[first], sides, [last]]),
        positions=positions,
        normals=normals[places],
        yaws=_smoothed(yaws, np.diff(positions[:, [0, 2]], axis=0), np.array([*sides, last])),
        cost=way.cost,
    )


def _smoothed(yaws: FloatArray, offsets: FloatArray, sides: IntArray) -> FloatArray:
    """Headings averaged with their neighbours, but for the stances, by at most half the search's resolution.

    Those of steps whose legs would cross by that stay; steps go by `offsets` (S - 1, 2) [m] and end on feet `sides`.
    """
    yaws = np.unwrap(yaws)
    means = yaws.copy()
    means[2:-2] = 0.25 * yaws[1:-3] + 0.5 * yaws[2:-2] + 0.25 * yaws[3:-1]
    most = np.pi / HEADINGS
    smooth = yaws + np.clip(means - yaws, -most, most)
    for _ in range(len(yaws)):
        apart = apart_midway(offsets, sides, yaws_before=smooth[:-1], turns=np.diff(smooth))
        crossed = np.flatnonzero(apart < -ROUNDED)
        ends = np.union1d(crossed, crossed + 1)
        if np.array_equal(smooth[ends], yaws[ends]):
            break
        smooth[ends] = yaws[ends]
    return smooth


def _unreachable(stones: Stones, chosen: IntArray, way: Way, goal: Stance, reach: Reach) -> PlanError:
    """The error that says how far the way leads and how far it is from there."""
    reached, positions = way.reached, way.positions
    middle = goal.positions.mean(axis=0)
    far = np.linalg.norm(positions - middle, axis=1)
    nearest = int(np.flatnonzero(reached)[np.argmin(far[reached])])
    where = "the start" if nearest < 4 else f"foothold {chosen[nearest - 4]}"
    x, y, z = positions[nearest]
    left = np.logical_not(reached)
    left[:2] = False
    gaps = positions[left] - positions[nearest]
    gap = gaps[np.argmin(np.linalg.norm(gaps, axis=1))]
    higher = f", {abs(gap[1]):.2f} m {'higher' if gap[1] > 0.0 else 'lower'}" if abs(gap[1]) > reach.rise else ""
    most = "" if len(chosen) == len(stones.positions) else f", the most promising of {len(stones.positions)},"
    return PlanError(
        stones.name,
        f"the goal cannot be reached; the way over {int(reached[4:].sum())} of {len(chosen)} footholds{most} "
        f"ends at {where} ({x:.2f}, {y:.2f}, {z:.2f}) m, {far[nearest]:.2f} m before the goal, and the next one not "
        f"reached is {np.linalg.norm(gap):.2f} m from there{higher}",
        f"a step reaches {reach.farthest:.2f} m and rises {reach.rise:.2f} m; {_what_helps(gap, nearest < 4, reach)}",
    )


def _what_helps(gap: FloatArray, at_start: bool, reach: Reach) -> str:
    """What would let a way lead on over a gap (3,) [m]."""
    if abs(gap[1]) > reach.rise:
        help_up = "add footholds at heights between"
        return f"{help_up}, or stand the agent on the ground beside them" if at_start else help_up
    if at_start:
        return "stand the agent nearer to the footholds"
    more = "" if reach.leaps else ", or let it leap"
    if np.hypot(gap[0], gap[2]) <= reach.farthest:
        return f"not in all directions, nor with either foot: add footholds between these, or beside them{more}"
    return f"add footholds{more}"
