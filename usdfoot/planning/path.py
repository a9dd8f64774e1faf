"""Plans along paths: step length, width and timing, start and end stance ([P] 2.1, Figure 4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.timing import STAND_TIME
from usdfoot.errors import PlanError
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.biped import LEFT
from usdfoot.model.ground import Ground
from usdfoot.model.limits import DEFAULT_LIMITS, SPANS, check_range
from usdfoot.model.path import WalkingPath
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.plan_checks import cut_plans
from usdfoot.model.plan_draft import PlanDraft
from usdfoot.planning.bypass import go_round
from usdfoot.planning.footholds import (
    find_footholds,
    find_walls,
    firm_ends,
    foot_places,
    strained_ways,
    tread_steps,
)
from usdfoot.planning.gait import Gait, derive_gait
from usdfoot.planning.lint import lint_alone
from usdfoot.planning.paces import pace_steps, stance_times, swing_lifts
from usdfoot.planning.prints import lay_prints
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.ways import Ways, lay_ways
from usdfoot.planning.world import Obstacle

__all__ = ["PathOptions", "plan_each", "plan_path", "plan_paths"]

LONGEST = 1e5
"""A path longer than that is in another unit than was meant, or broken [m]."""
BARRING = ("unreachable", "steep", "offTerrain", "obstructed", "obstacle")
"""Faults of plans whose paths lead where nobody walks."""


@dataclass(frozen=True, kw_only=True)
class PathOptions:
    """How plans along paths begin and end.

    Raises:
        UsdfootError: If a value is out of its range.
    """

    starts_standing: bool = True
    """Both feet stand side by side at the start; else the walk begins in mid gait."""
    ends_standing: bool = True
    """Both feet stand side by side at the end; else the walk ends in mid gait."""
    stand_time: float = STAND_TIME
    """How long the feet stand at the start before one leaves, and at the end [s]."""
    first_side: int = LEFT
    """The foot that steps first."""
    around: bool | None = None
    """Go round obstacles and ground that is too steep, too low or not walkable: None = where there is a better way,
    True = or there is no plan, False = the path is kept to as it is drawn."""

    def __post_init__(self) -> None:
        check_range("stand_time", self.stand_time, SPANS, unit="s")


def plan_path(
    path: WalkingPath,
    ground: Ground,
    *,
    proportions: Proportions | None = None,
    options: PathOptions | None = None,
    obstacles: Sequence[Obstacle] = (),
) -> FootstepPlan:
    """The plan along one path; see `plan_paths`."""
    bodies = [proportions or Proportions()]
    return plan_paths([path], ground, proportions=bodies, options=options, obstacles=obstacles)[0]


def plan_paths(
    paths: Sequence[WalkingPath],
    ground: Ground,
    *,
    proportions: Sequence[Proportions] | None = None,
    options: PathOptions | None = None,
    obstacles: Sequence[Obstacle] = (),
) -> list[FootstepPlan]:
    """Plans along paths, all made together.

    Where every foot stands firmly the steps are even, up to the local step length; on ways over stairs, edges or holes,
    and on those that turn so fast that even steps would cross the feet, they are those of `tread_steps`.

    Args:
        paths: Curves with speed, step length and width.
        ground: Terrain to conform to.
        proportions: Of each walker; None = people.
        options: Start and end, and what to go round.
        obstacles: To go round.

    Raises:
        PlanError: If a path is shorter than a print is long, or cannot go round what it is to go round.
    """
    plans = []
    for plan in plan_each(paths, ground, proportions=proportions, options=options, obstacles=obstacles):
        if isinstance(plan, PlanError):
            raise plan
        plans.append(plan)
    return plans


def plan_each(
    paths: Sequence[WalkingPath],
    ground: Ground,
    *,
    proportions: Sequence[Proportions] | None = None,
    options: PathOptions | None = None,
    obstacles: Sequence[Obstacle] = (),
) -> list[FootstepPlan | PlanError]:
    """As `plan_paths`, with the error in place of each plan that cannot be made."""
    options = options or PathOptions()
    bodies = list(proportions or [Proportions()] * len(paths))
    found: dict[int, FootstepPlan | PlanError] = {}
    for row, (path, body) in enumerate(zip(paths, bodies, strict=True)):
        if error := _wrong_length(path, body):
            found[row] = error
    able = [row for row in range(len(paths)) if row not in found]
    chosen, walking = [paths[row] for row in able], [bodies[row] for row in able]
    plans = _laid(chosen, walking, ground, options)
    found |= dict(zip(able, plans, strict=True))
    if options.around is not False and (ground.has_terrain or obstacles):
        barred = _barred(plans, ground, walking, obstacles)
        for index in np.flatnonzero(barred).tolist():
            try:
                led = go_round(chosen[index], ground, body=walking[index], obstacles=obstacles)
            except PlanError as error:
                if options.around:
                    found[able[index]] = error
                continue
            if led is chosen[index]:
                continue
            round_it = _laid([led], [walking[index]], ground, options)
            if options.around or _barred(round_it, ground, [walking[index]], obstacles)[0] < barred[index]:
                found[able[index]] = round_it[0]
    return [found[row] for row in range(len(paths))]


def _wrong_length(path: WalkingPath, body: Proportions) -> PlanError | None:
    """What is wrong with a path too short to step along, or longer than anybody walks, or that in steps too short."""
    length = path.length
    if not length <= LONGEST:
        what = f"is {length:.3g} m long, more than {LONGEST:g} m"
        return PlanError(path.name, what, "correct the curve, or the stage's metersPerUnit")
    most = DEFAULT_LIMITS.footsteps
    if path.step_length and length > most * path.step_length:
        what = f"takes {length / path.step_length:.3g} steps of {path.step_length:.3g} m, more than {most}"
        return PlanError(path.name, what, "author a longer usdfoot:path:stepLength, or none")
    if path.speed and not path.step_length and length > most * path.speed:  # a short step takes less than a second
        what = f"takes more than {most} steps at {path.speed:.3g} m/s"
        return PlanError(path.name, what, "author a higher usdfoot:path:speed, or none")
    if length < body.toe:
        return PlanError(path.name, f"is {length:.3g} m long, less than a step", "draw a longer curve")
    return None


def _laid(
    paths: Sequence[WalkingPath], bodies: list[Proportions], ground: Ground, options: PathOptions
) -> list[FootstepPlan]:
    """The plans along paths, which are walked as they are."""
    if not paths:
        return []
    sizes = [
        (body, path.speed, path.step_length, path.step_width, path.quickest_step)
        for path, body in zip(paths, bodies, strict=True)
    ]
    known = {
        size: derive_gait(size[0], speed=size[1], step_length=size[2], step_width=size[3], quickest_time=size[4])
        for size in dict.fromkeys(sizes)
    }
    gaits = [known[size] for size in sizes]
    ways = lay_ways(paths, gaits, ground)
    steps = _steps(ways, gaits, bodies, ground, options)
    return _plans(paths, gaits, ways, ground, steps, options)


def _barred(
    plans: Sequence[FootstepPlan], ground: Ground, bodies: list[Proportions], obstacles: Sequence[Obstacle]
) -> IntArray:
    """How many faults each plan has that bar the way, shape (P,); off the terrain nothing is known."""
    numbers = [str(row) for row in range(len(plans))]
    faults = lint_alone(plans, ground, bodies=bodies, obstacles=obstacles, names=numbers)
    places = np.array([plans[int(fault.plan)].positions[fault.footstep] for fault in faults]).reshape(-1, 3)
    known = ground.heights(places[:, [0, 2]], places[:, 1]).hit
    barring = np.array([fault.severity == "error" and fault.kind in BARRING for fault in faults], dtype=bool)
    owners = np.array([int(fault.plan) for fault in faults], dtype=int)
    return np.bincount(owners[known & barring], minlength=len(plans))


@dataclass(frozen=True, kw_only=True)
class _Steps:
    """Steps of all paths, one after the other; the start, where no step ends, is left out."""

    starts: FloatArray
    """Where each way's feet stand first [m], shape (P,)."""
    rows: IntArray
    """Path of each step, shape (S,)."""
    arcs: FloatArray
    """Where it ends along the way [m], shape (S,)."""
    widths: FloatArray
    """Between the feet at each sample of the ways, if both stood as each of them does [m], shape (M, 2)."""


def _steps(ways: Ways, gaits: list[Gait], bodies: list[Proportions], ground: Ground, options: PathOptions) -> _Steps:
    steps = _even_steps(ways, gaits)
    uneven = strained_ways(ways, gaits, rows=steps.rows, arcs=steps.arcs, first_side=options.first_side)
    if ground.has_terrain:
        uneven = np.union1d(uneven, _uneven_ways(ways, gaits, bodies, ground, steps))
    if not len(uneven):
        return steps
    rough, walkers = ways.only(uneven), [gaits[way] for way in uneven]
    built = [bodies[way] for way in uneven]
    footholds = find_footholds(rough, walkers, built, ground=ground)
    ends = firm_ends(rough, footholds, walkers)
    walls = find_walls(rough, ground)
    treads = tread_steps(
        rough, footholds, walkers, bodies=built, walls=walls, ends=ends, support=1 - options.first_side
    )
    starts = steps.starts.copy()
    starts[uneven] = rough.arcs[rough.first[:-1] + ends[:, 0]]
    widths = steps.widths.copy()
    widths[np.isin(ways.rows, uneven)] = footholds.widths
    kept = ~np.isin(steps.rows, uneven)
    rows = np.concatenate([steps.rows[kept], uneven[rough.rows[treads]]])
    arcs = np.concatenate([steps.arcs[kept], rough.arcs[treads]])
    order = np.lexsort((arcs, rows))
    return _Steps(starts=starts, rows=rows[order], arcs=arcs[order], widths=widths)


def _uneven_ways(ways: Ways, gaits: list[Gait], bodies: list[Proportions], ground: Ground, steps: _Steps) -> IntArray:
    """Ways with ground on which a foot does not stand firmly: where even steps end, or twice in every sole's length."""
    rows, numbers = ways.rows, np.arange(len(ways.arcs))
    half_soles = np.array([0.5 * (body.heel + body.toe) for body in bodies])
    every = np.maximum((half_soles / ways.arcs[ways.first[:-1] + 1]).astype(np.intp), 1)
    stepped = np.rint(ways.at(steps.rows, steps.arcs, numbers.astype(float))).astype(np.intp)
    samples = np.union1d(np.flatnonzero((numbers - ways.first[rows]) % every[rows] == 0), stepped)
    firm = find_footholds(ways, gaits, bodies, ground=ground, samples=samples).firm
    return np.unique(rows[samples[~firm]])


def _even_steps(ways: Ways, gaits: list[Gait]) -> _Steps:
    """Steps that each take the same part of what is a step where they are, the last at the way's end."""
    rows = ways.rows
    rates = 1.0 / (np.array([gait.step_length for gait in gaits])[rows] * ways.shares)
    pieces = np.diff(ways.arcs, prepend=0.0) * 0.5 * (rates + np.concatenate([rates[:1], rates[:-1]]))
    pieces[ways.first[:-1]] = 0.0
    phases = np.cumsum(pieces)
    phases -= np.repeat(phases[ways.first[:-1]], np.diff(ways.first))
    whole = phases[ways.first[1:] - 1]
    far = ways.lengths > np.array([gait.walked_length for gait in gaits])
    counts = np.maximum(np.rint(whole), 1.0 + far).astype(int)
    owner = np.repeat(np.arange(len(counts)), counts)
    numbers = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts) + 1.0
    offsets = np.concatenate([[0.0], np.cumsum(whole + 1.0)[:-1]])
    arcs = np.interp(numbers / counts[owner] * whole[owner] + offsets[owner], phases + offsets[rows], ways.arcs)
    widths = np.repeat(np.array([gait.step_width for gait in gaits])[rows, None], 2, axis=1)
    return _Steps(starts=np.zeros(len(gaits)), rows=owner, arcs=arcs, widths=widths)


def _plans(
    paths: Sequence[WalkingPath], gaits: list[Gait], ways: Ways, ground: Ground, steps: _Steps, options: PathOptions
) -> list[FootstepPlan]:
    """Footsteps where steps end, with the stances before and after."""
    before, after = 1 + options.starts_standing, int(options.ends_standing)
    stepped = np.bincount(steps.rows, minlength=len(paths))
    counts = stepped + before + after
    first = np.concatenate([[0], np.cumsum(counts)])
    rows = np.repeat(np.arange(len(paths)), counts)
    numbers = np.arange(first[-1]) - first[rows]
    last = steps.arcs[np.cumsum(stepped) - 1]
    arcs = np.where(numbers < before, steps.starts[rows], last[rows])
    arcs[(numbers >= before) & (numbers < counts[rows] - after)] = steps.arcs
    sides = (numbers + options.first_side + (not options.starts_standing)) % 2
    places, yaws = foot_places(
        np.stack([ways.at(rows, arcs, ways.points[:, i]) for i in (0, 1)], axis=-1),
        ways.at(rows, arcs, ways.headings),
        sides,
        widths=np.where(sides == 0, *(ways.at(rows, arcs, steps.widths[:, side]) for side in (0, 1))),
        toe_out=np.array([gait.toe_out for gait in gaits])[rows],
    )
    prints = lay_prints(ground, places, yaws, near=ways.at(rows, arcs, ways.heights))
    pace = pace_steps(ways, gaits, rows=rows, arcs=arcs, lifts=swing_lifts(rows, prints.positions, ground))
    strikes, liftoffs = stance_times(
        pace,
        first,
        starts_standing=options.starts_standing,
        ends_standing=options.ends_standing,
        stand_time=options.stand_time,
    )
    delays = np.array([path.start_time for path in paths])[rows]
    table = PlanDraft(
        name="",
        sides=sides,
        positions=prints.positions,
        orientations=prints.orientations,
        strike_times=strikes + delays,
        liftoff_times=liftoffs + delays,
        root_weights=np.zeros(len(rows)),
    )
    return cut_plans(table, counts, names=[path.name for path in paths])
