"""Crowds: many seekers with goals, simulated by JuPedSim, stepping without treading on each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import LEFT
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.planning.gait import TOE_OUT
from usdfoot.planning.prints import follow_ground, lay_prints
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.scenario import Scenario, Seeker
from usdfoot.planning.separation import find_conflicts, separate_feet
from usdfoot.planning.track_steps import TrackSteps, join_steps, step_along_tracks

if TYPE_CHECKING:
    from usdfoot.planning.simulation import Tracks

__all__ = ["CrowdOptions", "plan_crowd"]


@dataclass(frozen=True, kw_only=True)
class CrowdOptions:
    """How a crowd is planned."""

    duration: float = 600.0
    """Simulated at most [s]; it ends earlier when all have arrived or nobody gets on."""


def plan_crowd(
    scenario: Scenario, terrain: Terrain, *, options: CrowdOptions | None = None
) -> tuple[list[FootstepPlan], tuple[Problem, ...]]:
    """Plans of all seekers that can go, in order and with their names, and what went wrong with whom.

    JuPedSim gives the paths (collision free speed model). Who goes to the place where others go gets a place beside it.
    Footsteps follow the paths, where it is tight to the side; those that would come down on or swing into another's
    foot are moved apart.

    Args:
        scenario: Seekers, obstacles and bounds.
        terrain: Walkable ground; without any it is level and everywhere. Levels above one another count as one.
        options: How.

    Raises:
        PlanError: If JuPedSim is not installed or there is no seeker.
    """
    options = options or CrowdOptions()
    if find_spec("jupedsim") is None:
        raise PlanError("plan crowd", "needs JuPedSim, which is not installed", "pip install 'usdfoot[crowd]'")
    if not scenario.seekers:
        raise PlanError("crowd", "has no agent with a goal", "point usdfoot:agent:goal of agents at prims")
    from usdfoot.planning.places import find_places  # these need what comes with the extra
    from usdfoot.planning.simulation import simulate

    groups, problems = find_places(scenario, terrain)
    faults = list(problems)
    plans: list[FootstepPlan] = []
    for area, seekers in groups:
        tracks = simulate(area, seekers, duration=options.duration)
        plans += _plans(seekers, tracks, terrain, faults)
    order = {seeker.name: index for index, seeker in enumerate(scenario.seekers)}
    return sorted(plans, key=lambda plan: order[plan.name]), tuple(faults)


def _plans(seekers: Sequence[Seeker], tracks: Tracks, terrain: Terrain, faults: list[Problem]) -> list[FootstepPlan]:
    """Plans of the seekers of one area."""
    steps = join_steps(
        [
            step_along_tracks(
                tracks.points[:, rows],
                time_step=float(tracks.times[1]),
                yaws=np.array([np.nan if (yaw := seekers[row].yaw) is None else yaw for row in rows]),
                body=body,
            )
            for body, rows in _by_body(seekers)
        ],
        [rows for _, rows in _by_body(seekers)],
    )
    largest = max((seeker.body for seeker in seekers), key=lambda body: body.foot_length)
    steps = separate_feet(steps, largest)
    faults += [_late(seeker, tracks.points[-1, i]) for i, seeker in enumerate(seekers) if not tracks.arrived[i]]
    conflicts = find_conflicts(steps, largest)
    pairs, rows = np.unique(conflicts.people, axis=0, return_index=True)
    for (one, other), row in zip(pairs, rows, strict=True):
        what = f"treads on {seekers[other].name} by {conflicts.depths[row]:.3f} m at {conflicts.times[row]:.2f} s"
        faults.append(_warning(seekers[one], what))
    return _lay(seekers, tracks, steps, terrain)


def _by_body(seekers: Sequence[Seeker]) -> list[tuple[Proportions, IntArray]]:
    """Different bodies, and who has them."""
    bodies = list(dict.fromkeys(seeker.body for seeker in seekers))
    owners = np.array([bodies.index(seeker.body) for seeker in seekers])
    return [(body, np.flatnonzero(owners == index)) for index, body in enumerate(bodies)]


def _lay(seekers: Sequence[Seeker], tracks: Tracks, steps: TrackSteps, terrain: Terrain) -> list[FootstepPlan]:
    """Footsteps on the ground as plans."""
    starts = np.array([seeker.start for seeker in seekers])
    ground = Ground(terrain, fallback_height=float(starts[:, 1].min()))
    count, people = tracks.points.shape[:2]
    levels = follow_ground(
        ground,
        tracks.points.transpose(1, 0, 2).reshape(-1, 2),
        np.repeat(starts[:, 1], count),
        starts=np.arange(people * count) % count == 0,
    )
    when = np.clip((steps.strike_times - steps.lead) / tracks.times[1], 0.0, count - 1.0).round().astype(int)
    heights = levels.heights.reshape(people, count)[steps.owners, when]
    outward = np.where(steps.sides == LEFT, TOE_OUT, -TOE_OUT)
    prints = lay_prints(ground, steps.points, steps.yaws + outward, heights)
    return [
        FootstepPlan(
            name=seeker.name,
            sides=steps.sides[own],
            positions=prints.positions[own],
            orientations=prints.orientations[own],
            strike_times=steps.strike_times[own],
            liftoff_times=steps.liftoff_times[own],
            root_weights=np.zeros(own.stop - own.start),
        )
        for index, seeker in enumerate(seekers)
        for own in [slice(int(steps.first[index]), int(steps.first[index + 1]))]
    ]


def _late(seeker: Seeker, point: FloatArray) -> Problem:
    left = float(np.linalg.norm(seeker.goals[-1][[0, 2]] - point))
    return _warning(seeker, f"does not get to its goal; it stops {left:.2f} m before it")


def _warning(seeker: Seeker, what: str) -> Problem:
    return Problem(severity="warning", where=seeker.name, message=f"{seeker.name}: {what}")
