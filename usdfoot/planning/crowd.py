"""Crowds: many walkers with goals, simulated by JuPedSim, stepping without treading on each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.planning.places import find_places
from usdfoot.planning.prints import follow_ground, lay_prints
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.scenario import Scenario, Walker
from usdfoot.planning.separation import find_conflicts, separate_feet
from usdfoot.planning.track_steps import TrackSteps, step_along_tracks

if TYPE_CHECKING:
    from usdfoot.planning.simulation import Tracks

__all__ = ["CrowdOptions", "plan_crowd"]

TOE_OUT = 0.1
"""How far feet point outward [rad]."""


@dataclass(frozen=True, kw_only=True)
class CrowdOptions:
    """How a crowd is planned."""

    body: Proportions = Proportions()
    """Of everyone."""
    duration: float = 600.0
    """Simulated at most [s]; it ends earlier when all have arrived or nobody gets on."""
    seed: int = 0
    """Of the simulation: same seed, same plans."""


def plan_crowd(
    scenario: Scenario, terrain: Terrain, *, options: CrowdOptions | None = None
) -> tuple[list[FootstepPlan], tuple[Problem, ...]]:
    """Plans of all walkers that can go, in order and with their names, and what went wrong with whom.

    JuPedSim gives the paths (anticipation velocity model). Who goes to the place where others go gets a place beside it.
    Footsteps follow the paths, where it is tight to the side; those that would come down on or swing into another's foot
    are moved apart.

    Args:
        scenario: Walkers, obstacles and bounds.
        terrain: Walkable ground; without any it is level and everywhere. Levels above one another count as one.
        options: How.

    Raises:
        PlanError: If JuPedSim is not installed or there is no walker.
    """
    options = options or CrowdOptions()
    if find_spec("jupedsim") is None:
        raise PlanError("plan crowd", "needs JuPedSim, which is not installed", "pip install 'usdfoot[crowd]'")
    if not scenario.walkers:
        raise PlanError("crowd", "has no agent with a goal", "point usdfoot:agent:goal of agents at prims")
    groups, problems = find_places(scenario, terrain)
    faults = list(problems)
    plans: list[FootstepPlan] = []
    for area, walkers in groups:
        from usdfoot.planning.simulation import simulate  # JuPedSim is optional

        tracks = simulate(area, walkers, duration=options.duration, seed=options.seed)
        plans += _plans(walkers, tracks, terrain, options, faults)
    order = {walker.name: index for index, walker in enumerate(scenario.walkers)}
    return sorted(plans, key=lambda plan: order[plan.name]), tuple(faults)


def _plans(
    walkers: Sequence[Walker], tracks: Tracks, terrain: Terrain, options: CrowdOptions, faults: list[Problem]
) -> list[FootstepPlan]:
    """Plans of the walkers of one area."""
    yaws = np.array([np.nan if walker.yaw is None else walker.yaw for walker in walkers])
    steps = step_along_tracks(tracks.points, time_step=float(tracks.times[1]), yaws=yaws, body=options.body)
    steps = separate_feet(steps, options.body)
    faults += [_late(walker, tracks.points[-1, i]) for i, walker in enumerate(walkers) if not tracks.arrived[i]]
    conflicts = find_conflicts(steps, options.body)
    pairs, rows = np.unique(conflicts.people, axis=0, return_index=True)
    for (one, other), row in zip(pairs, rows, strict=True):
        what = f"treads on {walkers[other].name} by {conflicts.depths[row]:.3f} m at {conflicts.times[row]:.2f} s"
        faults.append(_warning(walkers[one], what))
    return _lay(walkers, tracks, steps, terrain, options.body)


def _lay(
    walkers: Sequence[Walker], tracks: Tracks, steps: TrackSteps, terrain: Terrain, body: Proportions
) -> list[FootstepPlan]:
    """Footsteps on the ground as plans."""
    starts = np.array([walker.start for walker in walkers])
    ground = Ground(terrain, fallback_height=float(starts[:, 1].min()))
    count, people = tracks.points.shape[:2]
    way_starts = np.arange(people * count) % count == 0
    near = np.repeat(starts[:, 1], count)
    levels = follow_ground(ground, tracks.points.transpose(1, 0, 2).reshape(-1, 2), near, starts=way_starts)
    owners = steps.owners
    when = np.clip((steps.strike_times - steps.lead) / tracks.times[1], 0.0, count - 1.0).round().astype(int)
    outward = np.where(steps.sides == 0, TOE_OUT, -TOE_OUT)
    heights = levels.heights.reshape(people, count)[owners, when]
    prints = lay_prints(ground, steps.points, steps.yaws + outward, heights)
    return [
        FootstepPlan(
            name=walker.name,
            sides=steps.sides[own],
            positions=prints.positions[own],
            orientations=prints.orientations[own],
            strike_times=steps.strike_times[own],
            liftoff_times=steps.liftoff_times[own],
            root_weights=np.zeros(own.stop - own.start),
        )
        for index, walker in enumerate(walkers)
        for own in [slice(int(steps.first[index]), int(steps.first[index + 1]))]
    ]


def _late(walker: Walker, point: FloatArray) -> Problem:
    left = float(np.linalg.norm(walker.goals[-1][[0, 2]] - point))
    return _warning(walker, f"does not get to its goal; it stops {left:.2f} m before it")


def _warning(walker: Walker, what: str) -> Problem:
    return Problem(severity="warning", where=walker.name, message=f"{walker.name}: {what}")
