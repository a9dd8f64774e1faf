"""Lint: what is wrong with plans before anybody walks them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from usdfoot.analysis.gaits import has_flight
from usdfoot.analysis.timing import EARTH_GRAVITY, HUMAN_LEG
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.segments import SHORTEST_STAND
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import SIDES
from usdfoot.model.ground import Ground
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.collisions import find_collisions
from usdfoot.planning.crossed import apart_midway
from usdfoot.planning.faults import ERROR, WARNING, Fault, LintLimits, faults_at
from usdfoot.planning.foot_table import FootTable, feet_of
from usdfoot.planning.lint_places import find_bump_faults, find_ground_faults, find_low_ceilings, find_walls
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.world import Obstacle
from usdfoot.spaces.library import FootstepSpaces, solve_steps

__all__ = ["lint_alone", "lint_clips", "lint_feet", "lint_plans", "lint_steps"]


def lint_plans(
    plans: Sequence[FootstepPlan],
    ground: Ground,
    *,
    bodies: Sequence[Proportions],
    obstacles: Sequence[Obstacle] = (),
    moving: Callable[[float], Sequence[Obstacle]] | None = None,
    limits: LintLimits | None = None,
) -> list[Fault]:
    """Faults of plans, in order of plan and footstep.

    Args:
        plans: Of everyone who walks at the same time and place.
        ground: Terrain below them.
        bodies: Who walks each plan.
        obstacles: That nobody walks through, and stay where they are.
        moving: Others at a time [s]; None = there are none.
        limits: What is still right.
    """
    limits = limits or LintLimits()
    alone = lint_alone(plans, ground, bodies=bodies, obstacles=obstacles, moving=moving, limits=limits)
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
    moving: Callable[[float], Sequence[Obstacle]] | None = None,
    limits: LintLimits | None = None,
    names: Sequence[str] = (),
) -> list[Fault]:
    """Faults of plans, each as if nobody else was there; as `lint_plans` otherwise.

    Args:
        plans: To check.
        ground: Terrain below them.
        bodies: Who walks each plan.
        obstacles: That nobody walks through, and stay where they are.
        moving: Others at a time [s]; None = there are none.
        limits: What is still right.
        names: To call the plans by; none = their own.
    """
    if not plans:
        return []
    limits = limits or LintLimits()
    feet = feet_of(plans, bodies)
    names = names or [plan.name for plan in plans]
    orientations = np.concatenate([plan.orientations for plan in plans])
    normals = quaternion.rotate(orientations, np.array([0.0, 1.0, 0.0]))
    return [
        *lint_feet(names, feet, normals, bodies=bodies, ground=ground, limits=limits),
        *find_bump_faults(names, feet, obstacles, limits=limits, moving=moving),
    ]


def lint_feet(
    names: Sequence[str],
    feet: FootTable,
    normals: FloatArray,
    *,
    bodies: Sequence[Proportions],
    ground: Ground,
    limits: LintLimits,
) -> list[Fault]:
    """Faults of footsteps as they follow each other and lie on the terrain.

    Args:
        names: Of the plans.
        feet: Footsteps of all plans.
        normals: On which they lie, shape (S, 3).
        bodies: Who walks each plan.
        ground: Terrain below them.
        limits: What is still right.
    """
    legs = np.array([body.leg_length for body in bodies])[feet.owners]
    return [
        *_steps(names, feet, bodies, limits),
        *find_ground_faults(names, feet, normals, ground=ground, limits=limits),
        *find_low_ceilings(names, feet, legs, ground=ground, limits=limits),
        *find_walls(names, feet, legs, ground=ground, limits=limits),
    ]


def lint_steps(plan: FootstepPlan, body: Proportions, *, limits: LintLimits | None = None) -> list[Fault]:
    """Faults between the footsteps of one plan, whatever they lie on.

    Args:
        plan: To check.
        body: Who walks it.
        limits: What is still right.
    """
    return _steps([plan.name], feet_of([plan], [body]), [body], limits or LintLimits())


def lint_clips(plan: FootstepPlan, spaces: FootstepSpaces, *, style: str, reach: float) -> list[Fault]:
    """Footsteps that no clip of a library comes near ([B] 5), but for those of feet that come to stand.

    Args:
        plan: To walk with them.
        spaces: Of the library.
        style: To walk in.
        reach: How far IK may pull a landing [m].

    Raises:
        ClipError: If the style has no step of a foot.
    """
    rows = np.flatnonzero(np.diff(plan.strike_times) > 0.0) + 1
    headings = planar.midway_yaw(plan.yaws[rows - 1], plan.yaws[rows])
    landings = planar.rotate(-headings, (plan.positions[rows] - plan.positions[rows - 1])[:, [0, 2]])
    durations = plan.strike_times[rows] - plan.strike_times[rows - 1]
    stances = plan.liftoff_times[rows - 1] - plan.strike_times[rows - 1]
    flights = has_flight(durations, stances, landings, leg_length=spaces.leg_length)
    distances = solve_steps(
        spaces, landings, swing_sides=plan.sides[rows], flights=flights, styles=(style,) * len(rows)
    ).hull_distances
    together = np.minimum(plan.liftoff_times[rows - 1], plan.liftoff_times[rows]) - plan.strike_times[rows]
    stands = together > np.where(rows == len(plan) - 1, SHORTEST_STAND, EngineOptions.stand_time)
    far = np.flatnonzero((distances > reach) & ~stands)
    return [
        Fault(
            plan=plan.name,
            footstep=int(row),
            kind="unreachable",
            severity=ERROR,
            value=float(distance),
            message=f"lands {distance:.2f} m outside what the clips show, IK reaches {reach:g} m",
        )
        for row, distance in zip(rows[far], distances[far], strict=True)
    ]


def _steps(names: Sequence[str], feet: FootTable, bodies: Sequence[Proportions], limits: LintLimits) -> list[Fault]:
    """What is wrong between consecutive footsteps of a plan."""
    measures = [(body.leg_length, body.foot_length, body.span(limits.longest_step)) for body in bodies]
    legs, sizes, spans = np.array(measures)[feet.owners].T
    rows = np.flatnonzero(feet.numbers > 0)
    before = rows - 1
    displacements = feet.positions[rows] - feet.positions[before]
    durations, leg = _durations(feet, rows), legs[rows]
    flights = np.maximum(feet.strikes[rows] - feet.liftoffs[before], 0.0)
    turns = planar.wrap_angle(feet.yaws[rows] - feet.yaws[before])
    apart = apart_midway(displacements[:, [0, 2]], feet.sides[rows], yaws_before=feet.yaws[before], turns=turns)
    lengths, rises = np.linalg.norm(displacements, axis=1), displacements[:, 1]
    flies = flights > 0.0
    speeds = lengths / np.maximum(durations, 1e-6) / np.sqrt(leg / HUMAN_LEG)
    launch = np.where(flies, rises / np.maximum(flights, 1e-6) + 0.5 * EARTH_GRAVITY * flights, 0.0)
    jumps = np.maximum(launch, 0.0) ** 2 / (2.0 * EARTH_GRAVITY)
    found: list[Fault] = []

    def note(wrong: BoolArray, kind: str, severity: str, values: FloatArray, message: str) -> None:
        chosen = rows[wrong]
        found.extend(
            faults_at(names, feet, chosen, kind=kind, values=values[wrong], message=message, severity=severity)
        )

    long = ~flies & (lengths > spans[rows])
    note(long, "unreachable", ERROR, lengths, "is {:.2f} m from the footstep before it, more than the legs span")
    high = ~flies & ~long & (np.abs(rises) > limits.highest_step * leg)
    note(high & (rises > 0.0), "unreachable", ERROR, rises, "is {:.2f} m above the footstep before it")
    note(high & (rises < 0.0), "unreachable", ERROR, -rises, "is {:.2f} m below the footstep before it")
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
        np.degrees(np.abs(turns)),
        "points {:.0f} degrees away from the foot before it",
    )
    own = np.flatnonzero(feet.numbers > 1)
    swings = feet.strikes[own] - feet.liftoffs[own - 2]
    late = swings < limits.shortest_swing
    message = "strikes only {:.2f} s after the foot has left the ground"
    return found + faults_at(
        names, feet, own[late], kind="hurried", values=swings[late], message=message, severity=WARNING
    )


def _durations(feet: FootTable, rows: IntArray) -> FloatArray:
    """How long the steps to footsteps (K,) take [s]: strike to strike, the first from a stand as its foot swings."""
    durations = feet.strikes[rows] - feet.strikes[rows - 1]
    own = np.maximum(rows - 2, 0)
    sets_out = (feet.numbers[rows] == 2) & (feet.strikes[own] == feet.strikes[rows - 1])
    return np.where(sets_out, feet.strikes[rows] - feet.liftoffs[own], durations)


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
