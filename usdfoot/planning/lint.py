"""Lint: what is wrong with plans before anybody walks them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from usdfoot.analysis.gaits import has_flight
from usdfoot.analysis.timing import EARTH_GRAVITY, HUMAN_LEG
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import SIDES
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.bumps import find_bumps
from usdfoot.planning.collisions import FootTable, feet_of, find_collisions
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.world import Obstacle
from usdfoot.spaces.library import FootstepSpaces, solve_steps

__all__ = ["Fault", "LintLimits", "lint_alone", "lint_clips", "lint_plans", "lint_steps"]

ERROR, WARNING = "error", "warning"
CEILING = 0.5
"""Terrain so far above a print is another level, not the next stair [m]."""


@dataclass(frozen=True, kw_only=True)
class LintLimits:
    """What is still right."""

    longest_step: float = 1.5
    """Of a walking step, over the leg length."""
    highest_step: float = 0.6
    """Rise of a walking step, over the leg length."""
    fastest: float = 10.0
    """Speed of a step with flight, for a leg of 0.86 m [m/s]."""
    fastest_walk: float = 2.9
    """Speed of a step without, for a leg of 0.86 m [m/s]: beyond gravity cannot hold the body to it."""
    highest_jump: float = 0.8
    """Rise of the body in flight, over the leg length."""
    shortest_swing: float = 0.1
    """[s]"""
    crossing: float = 0.25
    """A foot may come down this far on the other one's side, over the foot length."""
    twist: float = np.radians(100.0)
    """Most between the directions of consecutive feet [rad]."""
    off_ground: float = 0.05
    """A print may be this far above or below the ground [m]."""
    steepest: float = np.radians(40.0)
    """[rad]"""
    poke: float = 0.05
    """Ground may rise this much through the sole [m]."""
    headroom: float = 1.8
    """Free height above a print, over the leg length."""
    collision: float = 0.005
    """Feet of two people may overlap this much [m]."""
    bump: float = 0.03
    """A sole may be this far in an obstacle [m]."""


@dataclass(frozen=True, kw_only=True)
class Fault:
    """Something wrong with one footstep."""

    plan: str
    """Name of the plan."""
    footstep: int
    """Index; -1 = of the plan as a whole."""
    kind: str
    """unreachable | flight | crossing | twisted | hurried | offTerrain | offGround | steep | obstructed | obstacle |
    collision | malformed"""
    severity: str
    """error = cannot be walked as planned, warning = will look wrong."""
    value: float
    """How much, in the unit the message names."""
    message: str

    def to_json(self) -> dict[str, object]:
        """A plain dictionary."""
        return dict(vars(self))


def lint_plans(
    plans: Sequence[FootstepPlan],
    ground: Ground,
    *,
    bodies: Sequence[Proportions],
    obstacles: Sequence[Obstacle] = (),
    limits: LintLimits | None = None,
) -> list[Fault]:
    """Faults of plans, in order of plan and footstep.

    Args:
        plans: Of everyone who walks at the same time and place.
        ground: Terrain below them.
        bodies: Who walks each plan.
        obstacles: That nobody walks through.
        limits: What is still right.
    """
    limits = limits or LintLimits()
    alone = lint_alone(plans, ground, bodies=bodies, obstacles=obstacles, limits=limits)
    names = [plan.name for plan in plans]
    order = {name: i for i, name in enumerate(names)}
    found = [*alone, *_collisions(names, plans, bodies, limits)]
    return sorted(found, key=lambda fault: (order[fault.plan], fault.footstep))


def lint_alone(
    plans: Sequence[FootstepPlan],
    ground: Ground,
    *,
    bodies: Sequence[Proportions],
    obstacles: Sequence[Obstacle] = (),
    limits: LintLimits | None = None,
    names: Sequence[str] = (),
) -> list[Fault]:
    """Faults of plans, each as if nobody else was there; as `lint_plans` otherwise.

    Args:
        plans: To check.
        ground: Terrain below them.
        bodies: Who walks each plan.
        obstacles: That nobody walks through.
        limits: What is still right.
        names: To call the plans by; none = their own.
    """
    if not plans:
        return []
    limits = limits or LintLimits()
    feet = feet_of(plans, bodies)
    legs = np.array([body.leg_length for body in bodies])[feet.owners]
    sizes = np.array([body.foot_length for body in bodies])[feet.owners]
    names = names or [plan.name for plan in plans]
    orientations = np.concatenate([plan.orientations for plan in plans])
    normals = quaternion.rotate(orientations, np.array([0.0, 1.0, 0.0]))
    return [
        *_steps(names, feet, legs, sizes, limits),
        *_ground(names, feet, normals, ground, limits),
        *_ceilings(names, feet, legs, ground, limits),
        *_bumps(names, feet, obstacles, limits),
    ]


def lint_steps(plan: FootstepPlan, body: Proportions, *, limits: LintLimits | None = None) -> list[Fault]:
    """Faults between the footsteps of one plan, whatever they lie on.

    Args:
        plan: To check.
        body: Who walks it.
        limits: What is still right.
    """
    feet = feet_of([plan], [body])
    legs, sizes = (np.full(len(plan), size) for size in (body.leg_length, body.foot_length))
    return _steps([plan.name], feet, legs, sizes, limits or LintLimits())


def lint_clips(plan: FootstepPlan, spaces: FootstepSpaces, *, style: str, reach: float) -> list[Fault]:
    """Footsteps that no clip of a library comes near ([B] 5).

    Args:
        plan: To walk with them.
        spaces: Of the library.
        style: To walk in.
        reach: How far IK may pull a landing [m].

    Raises:
        ClipError: If the style has no step of a foot.
    """
    rows = np.flatnonzero(np.diff(plan.strike_times) > 0.0) + 1
    headings = plan.yaws[rows - 1] + 0.5 * planar.wrap_angle(plan.yaws[rows] - plan.yaws[rows - 1])
    landings = planar.rotate(-headings, (plan.positions[rows] - plan.positions[rows - 1])[:, [0, 2]])
    durations = plan.strike_times[rows] - plan.strike_times[rows - 1]
    stances = plan.liftoff_times[rows - 1] - plan.strike_times[rows - 1]
    flights = has_flight(durations, stances, landings, leg_length=spaces.leg_length)
    distances = solve_steps(
        spaces, landings, swing_sides=plan.sides[rows], flights=flights, styles=(style,) * len(rows)
    ).hull_distances
    far = np.flatnonzero(distances > reach)
    message = "lands {:.2f} m outside what the clips show, " + f"IK reaches {reach:g} m"
    owners = np.zeros(len(far), dtype=int)
    return _faults([plan.name], owners, rows[far], "unreachable", ERROR, distances[far], message)


def _faults(
    names: Sequence[str],
    owners: IntArray,
    numbers: IntArray,
    kind: str,
    severity: str,
    values: FloatArray,
    message: str,
) -> list[Fault]:
    """One fault a footstep; the message has a place for its value."""
    return [
        Fault(
            plan=names[owner],
            footstep=int(number),
            kind=kind,
            severity=severity,
            value=float(value),
            message=message.format(float(value)),
        )
        for owner, number, value in zip(owners, numbers, values, strict=True)
    ]


def _steps(
    names: Sequence[str], feet: FootTable, legs: FloatArray, sizes: FloatArray, limits: LintLimits
) -> list[Fault]:
    """What is wrong between consecutive footsteps of a plan."""
    rows = np.flatnonzero(feet.numbers > 0)
    before = rows - 1
    displacements = feet.positions[rows] - feet.positions[before]
    durations, leg = feet.strikes[rows] - feet.strikes[before], legs[rows]
    flights = np.maximum(feet.strikes[rows] - feet.liftoffs[before], 0.0)
    turns = planar.wrap_angle(feet.yaws[rows] - feet.yaws[before])
    local = planar.rotate(-(feet.yaws[before] + 0.5 * turns), displacements[:, [0, 2]])
    apart = local[:, 0] * np.where(feet.sides[rows] == 0, 1.0, -1.0)
    lengths, rises = np.linalg.norm(displacements, axis=1), displacements[:, 1]
    flies = flights > 0.0
    speeds = lengths / np.maximum(durations, 1e-6) / np.sqrt(leg / HUMAN_LEG)
    launch = np.where(flies, rises / np.maximum(flights, 1e-6) + 0.5 * EARTH_GRAVITY * flights, 0.0)
    jumps = np.maximum(launch, 0.0) ** 2 / (2.0 * EARTH_GRAVITY)
    found: list[Fault] = []

    def note(wrong: BoolArray, kind: str, severity: str, values: FloatArray, message: str) -> None:
        chosen = rows[wrong]
        found.extend(_faults(names, feet.owners[chosen], feet.numbers[chosen], kind, severity, values[wrong], message))

    long = ~flies & (lengths > limits.longest_step * leg)
    note(long, "unreachable", ERROR, lengths, "is {:.2f} m from the footstep before it, more than the legs span")
    high = ~flies & ~long & (np.abs(rises) > limits.highest_step * leg)
    note(high, "unreachable", ERROR, rises, "is {:+.2f} m above the footstep before it")
    note(flies & (speeds > limits.fastest), "flight", ERROR, speeds, "needs {:.1f} m/s, faster than anyone runs")
    quick = ~flies & ~long & (durations > 0.0) & (speeds > limits.fastest_walk)
    note(quick, "hurried", ERROR, speeds, "needs {:.1f} m/s without flight, faster than anyone walks")
    note(jumps > limits.highest_jump * leg, "flight", ERROR, jumps, "needs a jump {:.2f} m high")
    note(
        apart < -limits.crossing * sizes[rows],
        "crossing",
        WARNING,
        -apart,
        "comes down {:.2f} m on the other foot's side",
    )
    note(
        np.abs(turns) > limits.twist,
        "twisted",
        WARNING,
        np.degrees(turns),
        "points {:.0f} degrees away from the foot before it",
    )
    own = np.flatnonzero(feet.numbers > 1)
    swings = feet.strikes[own] - feet.liftoffs[own - 2]
    late = own[swings < limits.shortest_swing]
    message = "strikes only {:.2f} s after the foot has left the ground"
    found += _faults(
        names,
        feet.owners[late],
        feet.numbers[late],
        "hurried",
        WARNING,
        swings[swings < limits.shortest_swing],
        message,
    )
    return found


def _ground(names: Sequence[str], feet: FootTable, laid: FloatArray, ground: Ground, limits: LintLimits) -> list[Fault]:
    """What is wrong with where footsteps, laid on normals (N, 3), are on the terrain."""
    if not ground.has_terrain:
        return []
    places, heights = feet.positions[:, [0, 2]], feet.positions[:, 1]
    under = ground.heights(places, heights, step_up=limits.off_ground)
    above = heights - under.heights
    slopes = np.arccos(np.clip(under.normals[:, 1], -1.0, 1.0))
    forward = planar.direction(feet.yaws)
    left, inclines = planar.direction(feet.yaws + 0.5 * np.pi), -laid[:, [0, 2]] / laid[:, [1]]
    pokes = np.zeros(len(heights))
    for reach, across in product((-feet.heels, feet.toes), (-feet.half_widths, feet.half_widths)):
        offsets = reach[:, None] * forward + across[:, None] * left
        end = ground.heights(places + offsets, heights, step_up=0.3)
        sole = heights + np.sum(offsets * inclines, axis=1)
        pokes = np.maximum(pokes, np.where(end.hit, end.heights - sole, 0.0))
    off = ~under.hit
    barred = under.hit & ~under.walkable
    away = under.hit & ~barred & (np.abs(above) > limits.off_ground)
    good = ~(off | barred | away)
    steep = good & (slopes > limits.steepest)
    checks = (
        (off, "offTerrain", np.zeros(len(off)), "is off the terrain"),
        (barred, "offTerrain", np.zeros(len(off)), "is on ground that is not walkable"),
        (away, "offGround", above, "is {:+.2f} m above the ground"),
        (steep, "steep", np.degrees(slopes), "is on a slope of {:.0f} degrees"),
    )
    found = []
    for wrong, kind, values, message in checks:
        found += _faults(names, feet.owners[wrong], feet.numbers[wrong], kind, ERROR, values[wrong], message)
    poked = good & ~steep & (pokes > limits.poke)
    message = "has ground {:.2f} m high in its sole"
    return found + _faults(names, feet.owners[poked], feet.numbers[poked], "obstructed", WARNING, pokes[poked], message)


def _ceilings(
    names: Sequence[str], feet: FootTable, legs: FloatArray, ground: Ground, limits: LintLimits
) -> list[Fault]:
    """Footsteps under terrain too low to stand upright, or inside of it."""
    if not ground.has_terrain:
        return []
    heights = feet.positions[:, 1]
    above = ground.heights(feet.positions[:, [0, 2]], heights + limits.headroom * legs, step_up=0.0).heights - heights
    low = np.flatnonzero((above > CEILING) & (above <= limits.headroom * legs))
    message = "has only {:.2f} m of room above it"
    return _faults(names, feet.owners[low], feet.numbers[low], "obstructed", ERROR, above[low], message)


def _bumps(names: Sequence[str], feet: FootTable, obstacles: Sequence[Obstacle], limits: LintLimits) -> list[Fault]:
    """Footsteps in obstacles, and steps through them."""
    soles, bodies = find_bumps(feet, obstacles)
    found = []
    for bumps, least, what in (
        (soles, limits.bump, "is {:.2f} m in the obstacle "),
        (bodies, 0.0, "leads the body {:.2f} m into the obstacle "),
    ):
        for row, index, depth in zip(bumps.rows, bumps.obstacles, bumps.depths, strict=True):
            if depth > least:
                message, owners, numbers = what + obstacles[index].name, feet.owners[[row]], feet.numbers[[row]]
                found += _faults(names, owners, numbers, "obstacle", ERROR, np.array([depth]), message)
    return found


def _collisions(
    names: Sequence[str], plans: Sequence[FootstepPlan], bodies: Sequence[Proportions], limits: LintLimits
) -> list[Fault]:
    """Feet of different people in one place."""
    if len(names) < 2:
        return []
    feet = feet_of(plans, bodies)
    collisions = find_collisions(feet)
    found = []
    for (first, second), time, depth in zip(collisions.steps, collisions.times, collisions.depths, strict=True):
        if depth <= limits.collision:
            continue
        for own, other in ((first, second), (second, first)):
            side, who = SIDES[int(feet.sides[other])], names[feet.owners[other]]
            found.append(
                Fault(
                    plan=names[feet.owners[own]],
                    footstep=int(feet.numbers[own]),
                    kind="collision",
                    severity=ERROR,
                    value=float(depth),
                    message=f"is {depth:.2f} m in the {side} foot of {who} "
                    f"(footstep {feet.numbers[other]}) at {time:.1f} s",
                )
            )
    return found
