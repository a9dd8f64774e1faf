"""Crowds: many seekers with goals, simulated by JuPedSim, stepping without treading on each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray
from usdfoot.model.ground import Ground
from usdfoot.model.limits import LATEST, check_range
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain
from usdfoot.planning.collisions import find_collisions
from usdfoot.planning.edges import keep_off_edges
from usdfoot.planning.elbow_room import make_room
from usdfoot.planning.facing import LEAD, face_tracks
from usdfoot.planning.feet_apart import is_sideways, set_feet_apart
from usdfoot.planning.foot_table import FootTable, feet_of, joined_tables
from usdfoot.planning.latecomers import find_latecomers
from usdfoot.planning.root_curves import CurveBatches
from usdfoot.planning.scenario import Scenario, Seeker
from usdfoot.planning.step_limits import limit_steps, uncross
from usdfoot.planning.trajectories import NARROW, lay_plans, step_along_curves

if TYPE_CHECKING:
    from usdfoot.planning.places import Party
    from usdfoot.planning.simulation import Tracks

__all__ = ["CrowdOptions", "plan_crowd"]

SMOOTHING = 0.4
"""Standard deviation of the filter on the simulated paths: people start and stop more gently than discs [s]."""
NEAR = 0.3
"""The ground is at most this far from the middle of its cell [m]."""
BETWEEN = 0.01
"""Between the feet when one closes up to the other in side steps [m]."""
ELBOW_ROOM = 0.45
"""Least distance between the roots of two people [m]."""


@dataclass(frozen=True, kw_only=True)
class CrowdOptions:
    """How a crowd is planned.

    Raises:
        UsdfootError: If a value is out of its range.
    """

    duration: float = 600.0
    """Simulated at most [s]; it ends earlier when all have arrived or nobody gets on."""

    def __post_init__(self) -> None:
        check_range("duration", self.duration, (1.0, LATEST), unit="s")


def plan_crowd(
    scenario: Scenario, terrain: Terrain, *, options: CrowdOptions | None = None
) -> tuple[list[FootstepPlan], tuple[Problem, ...]]:
    """Plans of all seekers that can go, in order and with their names, and what went wrong with whom.

    JuPedSim gives the paths (collision free speed model). Who goes to the place where others go gets a place beside it.
    Footsteps follow the paths, where it is tight to the side; those that would come down on or swing into another's
    foot are moved apart.

    Args:
        scenario: Seekers, obstacles and bounds.
        terrain: Walkable ground; without any it is level and everywhere. A start or goal is on the highest level below
            it; levels are left by the ramps and stairs that join them.
        options: How.

    Raises:
        PlanError: If JuPedSim is not installed or there is no seeker.
    """
    options = options or CrowdOptions()
    if find_spec("jupedsim") is None:
        raise PlanError("plan crowd", "needs JuPedSim, which is not installed", "pip install 'usdfoot[crowd]'")
    if not scenario.seekers:
        raise PlanError("crowd", "has no agent with a goal", "point usdfoot:agent:goal of agents at prims")
    from usdfoot.planning.dodging import is_met
    from usdfoot.planning.places import find_places  # these need what comes with the extra
    from usdfoot.planning.simulation import simulate

    parties, problems = find_places(scenario, terrain)
    faults = list(problems)
    plans: list[FootstepPlan] = []
    for party in parties:
        moving, begun = scenario.moving, False
        if moving:
            begun = is_met(party, moving, seconds=LEAD)
            moving = moving if begun else moving.later(LEAD)
        tracks = simulate(party, duration=options.duration, moving=moving, hold=LEAD if begun else 0.0)
        faults += find_latecomers(party.seekers, tracks, duration=options.duration)
        plans += _plans(party, tracks, terrain, faults, begun=begun)
    order = {seeker.name: index for index, seeker in enumerate(scenario.seekers)}
    return sorted(plans, key=lambda plan: order[plan.name]), tuple(faults)


def _plans(party: Party, tracks: Tracks, terrain: Terrain, faults: list[Problem], *, begun: bool) -> list[FootstepPlan]:
    """Plans of the seekers of one area, whose tracks begin when the plans do or `LEAD` later."""
    from usdfoot.planning.walls import Walls  # needs what comes with the extra

    seekers = party.seekers
    starts = np.array([seeker.start for seeker in seekers])
    ground = Ground(terrain, fallback_height=float(starts[:, 1].min()))
    trajectories = face_tracks(
        tracks.points,
        time_step=float(tracks.times[1]),
        yaws=np.array([np.nan if seeker.yaw is None else seeker.yaw for seeker in seekers]),
        heights=_on_ground(tracks, starts[:, 1], ground),
        turned=tracks.turned,
        legs=np.array([seeker.body.leg_length for seeker in seekers]),
        names=[seeker.name for seeker in seekers],
        begun=begun,
    )
    curves = CurveBatches(trajectories, smoothing_time=SMOOTHING)
    room = make_room(curves, distance=ELBOW_ROOM)
    walls, narrow = Walls(party.area), min(seeker.narrowest for seeker in seekers)
    tables, order = [], np.zeros(0, dtype=int)
    for body in dict.fromkeys(seeker.body for seeker in seekers):
        own = np.array([index for index, seeker in enumerate(seekers) if seeker.body == body])
        for agents, some in curves.of(own):
            some = room.moved(some, agents)
            roots, places = some.positions.copy(), some.positions[..., [0, 2]]
            roots[..., [0, 2]] = walls.keep_off(places.reshape(-1, 2), distance=narrow).reshape(places.shape)
            table = step_along_curves(replace(some, positions=roots), body)
            tables.append(replace(table, owners=table.owners + len(order)))
            order = np.concatenate([order, agents])
    feet, ordered = joined_tables(tables), [seekers[index] for index in order]
    narrowest = np.array([NARROW * seeker.body.step_width for seeker in ordered])[feet.owners]
    narrowest = np.where(is_sideways(feet), 2.0 * feet.half_widths + BETWEEN, narrowest)
    widest = np.array([seeker.body.widest_step for seeker in ordered])[feet.owners]
    limits = limit_steps(feet, narrowest=narrowest, widest=widest)
    feet = set_feet_apart(uncross(feet, limits), limits, confine=walls.keep_feet_off)
    feet = keep_off_edges(feet, ground)
    plans = lay_plans([seeker.name for seeker in ordered], feet, ground, on_ground=True)
    faults += _treads(ordered, feet_of(plans, [seeker.body for seeker in ordered]))
    return plans


def _on_ground(tracks: Tracks, starts: FloatArray, ground: Ground) -> FloatArray:
    """Heights of the ground below tracks [m], shape (T, N); without terrain those (N,) of the starts."""
    known = np.where(np.isnan(tracks.heights), starts, tracks.heights)
    if not ground.has_terrain:
        return known
    points = tracks.points.reshape(-1, 2)
    sample = ground.heights(points, known.ravel(), step_up=NEAR)
    return np.where(np.abs(sample.heights - known.ravel()) <= NEAR, sample.heights, known.ravel()).reshape(known.shape)


def _treads(seekers: Sequence[Seeker], feet: FootTable) -> list[Problem]:
    """A warning for each two people whose feet still overlap, at the worst instant."""
    found = find_collisions(feet)
    people = feet.owners[found.steps].reshape(-1, 2)
    pairs, rows = np.unique(people, axis=0, return_index=True)
    return [
        _warning(
            seekers[one],
            f"treads on {seekers[other].name} by {found.depths[row]:.3f} m at {found.times[row]:.2f} s",
        )
        for (one, other), row in zip(pairs, rows, strict=True)
    ]


def _warning(seeker: Seeker, what: str) -> Problem:
    return Problem(severity="warning", where=seeker.name, message=f"{seeker.name}: {what}")
