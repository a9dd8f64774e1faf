"""Plans from trajectories: footsteps, of any number of people at once, that keep to where they were."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from usdfoot.analysis.gaits import RUNNING_FROUDE
from usdfoot.analysis.timing import TimingRule
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.ground import Ground
from usdfoot.model.limits import WINDOWS, check_range
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.plan_checks import cut_plans
from usdfoot.model.plan_draft import PlanDraft
from usdfoot.model.trajectory import RootTrajectory
from usdfoot.planning.cadences import step_rates
from usdfoot.planning.edges import keep_off_edges
from usdfoot.planning.elbow_room import make_room
from usdfoot.planning.feet_apart import set_feet_apart
from usdfoot.planning.foot_table import FootTable, joined_tables
from usdfoot.planning.footholds import foot_places
from usdfoot.planning.gait import TOE_OUT, longest_time, natural_lengths, overlap_shares
from usdfoot.planning.prints import lay_prints
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.root_curves import SPACING, CurveBatches, RootCurves
from usdfoot.planning.step_limits import limit_steps, uncross

__all__ = ["NARROW", "TrajectoryOptions", "lay_plans", "plan_trajectories", "step_along_curves"]

SHUFFLE = 0.3
"""Who is slower when its trajectory begins or ends stands there, and takes no part of a step [m/s]."""
ONSET = 0.75
"""Part of a step from the start of a motion to the first strike."""
SWING = 0.57
"""Least time of a swing over that of a short step."""
NARROW = 0.6
"""Least distance between the feet across, over that of an easy step: legs do not cross."""
STAND = 0.3
"""Least time that both feet stand at the end [s]."""


@dataclass(frozen=True, kw_only=True)
class TrajectoryOptions:
    """How trajectories become footsteps.

    Raises:
        UsdfootError: If a value is out of its range.
    """

    smoothing_time: float = 0.3
    """Standard deviation of the filter on positions [s]: takes out jitter and the sway of tracked heads."""
    apart: bool = True
    """Keep people, and their feet, out of each other."""
    elbow_room: float = 0.5
    """Least distance between the roots of two people, if `apart` [m]."""

    def __post_init__(self) -> None:
        check_range("smoothing_time", self.smoothing_time, WINDOWS, unit="s")


def plan_trajectories(
    trajectories: Sequence[RootTrajectory],
    ground: Ground,
    *,
    proportions: Proportions | None = None,
    options: TrajectoryOptions | None = None,
) -> list[FootstepPlan]:
    """Footstep plans of people who move as trajectories say, all made together.

    Steps are as long and quick as people of that speed choose; those who hardly move stand, and turn on the spot. Who
    moves at the first or last sample walks there, who hardly does stands. The feet stay on the level of the terrain
    they begin on.

    Args:
        trajectories: One a person.
        ground: Terrain to conform to.
        proportions: Of all of them; None = people.
        options: Smoothing, and whether people avoid each other.
    """
    if not trajectories:
        return []
    options, body = options or TrajectoryOptions(), proportions or Proportions()
    curves = CurveBatches(trajectories, smoothing_time=options.smoothing_time)
    several = options.apart and len(trajectories) > 1
    room = make_room(curves, distance=options.elbow_room) if several else None
    parts = []
    for agents, own in curves.of(np.arange(len(trajectories))):
        table = step_along_curves(own if room is None else room.moved(own, agents), body)
        parts.append(replace(table, owners=agents[table.owners]))
    feet = joined_tables(parts)
    narrowest, widest = (np.full(len(feet.owners), size) for size in (NARROW * body.step_width, body.widest_step))
    limits = limit_steps(feet, narrowest=narrowest, widest=widest)
    feet = uncross(feet, limits)
    if several:
        feet = set_feet_apart(feet, limits)
    feet = keep_off_edges(_on_ground(feet, ground), ground)
    return lay_plans([trajectory.name for trajectory in trajectories], feet, ground)


def step_along_curves(curves: RootCurves, body: Proportions) -> FootTable:
    """Footsteps along curves, at the heights of the curves.

    The root is midway between the feet whenever one strikes, so a footstep lies where the root is half a step later, to
    its side.
    """
    rule = body.timing
    speeds, rates = step_rates(curves, rule)
    frames = np.clip(np.ceil((curves.ends - curves.starts) / SPACING).astype(int), 1, rates.shape[1] - 1)
    phases = np.concatenate([np.zeros((len(rates), 1)), np.cumsum(rates[:, :-1] * SPACING, axis=1)], axis=1)
    people = np.arange(len(rates))
    starts_still = (rates[:, 0] <= 0.0) | (speeds[:, 0] < SHUFFLE)
    ends_still = (rates[people, frames - 1] <= 0.0) | (speeds[people, frames - 1] < SHUFFLE)
    onsets = np.where(starts_still, ONSET, 0.0)
    stepped = np.floor(phases[people, frames] - onsets + 1e-9).astype(int) + 1
    counts = np.maximum(np.maximum(stepped, 0) + 2 * starts_still, 2)
    owners = np.repeat(people, counts)
    numbers = np.arange(len(owners)) - np.repeat(np.cumsum(counts) - counts, counts)
    taken = numbers - 2 * starts_still[owners]
    clock = _Clock(phases=phases, rates=rates, frames=frames, starts=curves.starts, still=ends_still)
    strikes = clock.times(owners, np.where(taken < 0, 0.0, taken + onsets[owners]))
    strikes[taken < 0] = curves.starts[owners[taken < 0]]
    beside = clock.times(owners, np.where(taken < 0, 0.0, taken + onsets[owners] + 0.5))
    beside = np.where(taken < 0, strikes, np.minimum(beside, strikes + 0.5 * longest_time(rule)))  # rests are no steps
    places, headings = curves.at(owners, beside)
    sides = (numbers + owners) % 2
    width, toe_out = np.full(len(owners), body.step_width), np.full(len(owners), TOE_OUT)
    points, yaws = foot_places(places[:, [0, 2]], headings, sides, widths=width, toe_out=toe_out)
    where = np.clip(((strikes - curves.starts[owners]) / SPACING).astype(int), 0, frames[owners])
    liftoffs = _liftoffs(strikes, speeds[owners, where], numbers, counts, rule)
    last = np.cumsum(counts) - 1
    rest = np.maximum(curves.ends, strikes[last] + STAND)
    for back in (0, 1):
        liftoffs[last - back] = np.where(ends_still, rest, liftoffs[last - back])
    return FootTable(
        owners=owners,
        numbers=numbers,
        positions=np.stack([points[:, 0], places[:, 1], points[:, 1]], axis=-1),
        yaws=yaws,
        sides=sides,
        strikes=strikes,
        liftoffs=liftoffs,
        last=numbers >= counts[owners] - 2,
        heels=np.full(len(owners), body.heel),
        toes=np.full(len(owners), body.toe),
        half_widths=np.full(len(owners), body.half_width),
    )


@dataclass(frozen=True, kw_only=True)
class _Clock:
    """When people have taken how many steps."""

    phases: FloatArray
    """Steps taken until each frame, shape (A, F)."""
    rates: FloatArray
    """Steps a second, shape (A, F)."""
    frames: IntArray
    """Last frame of each, shape (A,)."""
    starts: FloatArray
    """[s], shape (A,)."""
    still: BoolArray
    """Who stands at the end, shape (A,)."""

    def times(self, owners: IntArray, phases: FloatArray) -> FloatArray:
        """When people (S,) reach phases (S,) [s]; beyond the end those who walk go on as they did, others wait."""
        count = self.phases.shape[1]
        whole = self.phases[np.arange(len(self.frames)), self.frames]
        span = float(self.phases.max()) + 1.0
        axis = (np.minimum(self.phases, whole[:, None]) + span * np.arange(len(self.frames))[:, None]).ravel()
        inside = np.minimum(phases, whole[owners])
        samples = np.interp(inside + span * owners, axis, np.arange(axis.size)) - owners * count
        samples = np.minimum(samples, self.frames[owners])
        rates = np.maximum(self.rates[owners, self.frames[owners] - 1], 0.5)
        beyond = np.where(self.still[owners], 0.0, (phases - inside) / rates)
        return np.asarray(self.starts[owners] + samples * SPACING + beyond)


def _liftoffs(
    strikes: FloatArray, speeds: FloatArray, numbers: IntArray, counts: IntArray, rule: TimingRule
) -> FloatArray:
    """Each foot leaves when the overlap after the next strike is over, after a stand just in time for its next step.

    A step during which somebody runs has a flight, also where a walk follows it.
    """
    left = np.repeat(counts, counts) - 1 - numbers  # footsteps that follow
    has_next, has_same = left > 0, left > 1
    following = np.arange(len(strikes)) + np.minimum(2, left)
    run = speeds[np.arange(len(strikes)) + np.minimum(1, left)]  # how far a step goes shows half a step later
    runs = run > np.sqrt(RUNNING_FROUDE * rule.gravity * rule.leg_length)
    speed = np.maximum(speeds[following], np.where(runs, run, 1e-3))
    longest = longest_time(rule)
    natural = np.minimum(longest, natural_lengths(speed, rule) / speed)
    shares = overlap_shares(speed, rule)
    other = np.where(has_next, np.roll(strikes, -1), strikes + natural)
    same = np.where(has_same, np.roll(strikes, -2), other + natural)
    spans = np.minimum(natural, same - other)
    swung = np.where(runs & (same - other <= longest), same - other, natural)
    liftoffs = np.maximum(other + shares * spans, same - (1.0 - np.minimum(shares, 0.4)) * swung)
    swings = np.minimum(SWING * longest, 0.85 * (same - other))
    walks = shares > 0.0
    return np.maximum(np.where(walks, np.minimum(liftoffs, same - swings), liftoffs), strikes + 0.05)


def _on_ground(feet: FootTable, ground: Ground) -> FootTable:
    """The table with feet on the ground of the level each person keeps to."""
    first = np.append(np.flatnonzero(feet.numbers == 0), len(feet.owners))
    positions = feet.positions.copy()
    positions[:, 1] = ground.follow(positions[:, [0, 2]], positions[:, 1], first=first).heights
    return replace(feet, positions=positions)


def lay_plans(names: Sequence[str], feet: FootTable, ground: Ground, *, on_ground: bool = False) -> list[FootstepPlan]:
    """Plans of the footsteps, on the ground of the level each person keeps to.

    Args:
        names: Of the plans.
        feet: Of all of them.
        ground: The terrain.
        on_ground: Whether the heights of the feet are those of the ground near them; else only the level of the first
            is known.
    """
    places, near = feet.positions[:, [0, 2]], feet.positions[:, 1]
    first = np.append(np.flatnonzero(feet.numbers == 0), len(feet.owners))
    ways = np.arange(len(near) + 1) if on_ground else first
    prints = lay_prints(ground, places, feet.yaws, near=ground.follow(places, near, first=ways).heights)
    table = PlanDraft(
        name="",
        sides=feet.sides,
        positions=prints.positions,
        orientations=prints.orientations,
        strike_times=feet.strikes,
        liftoff_times=feet.liftoffs,
        root_weights=np.zeros(len(near)),
    )
    return cut_plans(table, np.diff(first), names=names)
