"""The contacts of all agents in one table: every footstep, and the stands before the first and after the last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from usdfoot.maths import planar, quaternion
from usdfoot.maths.planar import GROUND_AXES
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.plan import FootstepPlan

if TYPE_CHECKING:  # Warp, which it loads, takes a tenth of a run that finds that nothing is to be made
    from usdfoot.model.ground import Ground

__all__ = ["EDGE_HEIGHT", "ContactTable", "lay_contacts", "lay_on_ground", "stay_down", "with_headings"]

NEAR_GROUND = 0.3
"""Ground farther than this above or below a contact, along its normal, is not its own [m]."""

NEAR_FOOTSTEP = 0.05
"""Ground farther than this above or below a planned footstep is not meant by it [m]."""

STEEPEST = 0.7
"""Ground whose unit normal rises less is no place to stand [1]."""

EDGE_HEIGHT = 0.03
"""Ground under the heel farther than this above the slope under the ball is another tread [m]."""

UNKNOWN_STEP_TIME = 0.6
"""Duration of a step when a plan has no other to copy from [s]."""

LONGEST_OVERLAP = 0.5
"""Part of a step for which the foot before a mid-gait start stays down at most: the rest is its swing."""


@dataclass(frozen=True, kw_only=True)
class ContactTable:
    """Contacts of A agents, C in all, each agent's in order of strike, left and right in turn.

    A plan that starts in mid gait has one more contact before its first footstep: where the other foot comes from
    (design.md section 2). One that ends in mid gait has two more after its last, so that the body walks on until the
    last liftoff, and the last stays down as long as it would if the plan went on. Their `steps` are -1.
    """

    first: IntArray
    """Index of each agent's first contact, shape (A + 1,); the last entry is C."""
    agents: IntArray
    """Agent of each contact, shape (C,)."""
    steps: IntArray
    """Footstep of the plan, or -1, shape (C,)."""
    sides: IntArray
    """0 = left, 1 = right, shape (C,)."""
    positions: FloatArray
    """Ground under the ball as executed [m], world, shape (C, 3)."""
    yaws: FloatArray
    """Direction of the foot [rad], shape (C,)."""
    normals: FloatArray
    """Ground normal, shape (C, 3)."""
    strikes: FloatArray
    """[s], shape (C,)."""
    liftoffs: FloatArray
    """[s], shape (C,); of the last footstep before a mid-gait end perhaps after the motion's."""
    headings: FloatArray
    """Heading at the strike: mean of the yaws of this contact and the one before, continuous [rad], shape (C,)."""
    starts: FloatArray
    """First strike of each agent's plan [s], shape (A,)."""
    ends: FloatArray
    """Last liftoff of each agent's plan [s], shape (A,)."""
    given_headings: FloatArray | None = None
    """Headings at the strikes that come from a root trajectory [rad], not a number for others, shape (C,)."""

    def __getitem__(self, rows: IntArray) -> ContactTable:
        """The contacts `rows` (N,) alone, each as if it were its agent's only one."""
        names = ("steps", "sides", "positions", "yaws", "normals", "strikes", "liftoffs", "headings")
        agents, given = self.agents[rows], self.given_headings
        return ContactTable(
            first=np.arange(len(rows) + 1),
            agents=np.arange(len(rows)),
            starts=self.starts[agents],
            ends=self.ends[agents],
            given_headings=None if given is None else given[rows],
            **{name: getattr(self, name)[rows] for name in names},
        )

    @property
    def has_next(self) -> BoolArray:
        """Whether the agent has a contact after this one, shape (C,)."""
        flags = np.ones(len(self.sides), dtype=bool)
        flags[self.first[1:] - 1] = False
        return flags

    @property
    def has_previous(self) -> BoolArray:
        """Whether the agent has a contact before this one, shape (C,)."""
        flags = np.ones(len(self.sides), dtype=bool)
        flags[self.first[:-1]] = False
        return flags

    @property
    def flown(self) -> BoolArray:
        """Whether a flight within the motion ends with the strike, shape (C,)."""
        liftoffs = np.roll(self.liftoffs, 1)
        return self.has_previous & (liftoffs < self.strikes) & (liftoffs >= self.starts[self.agents])

    @property
    def has_swing(self) -> BoolArray:
        """Whether the same foot has another contact after this one, shape (C,)."""
        flags = self.has_next
        return flags & np.append(flags[1:], False)


def lay_contacts(plans: Sequence[FootstepPlan]) -> ContactTable:
    """Table of the contacts of all plans; the contacts that are no footsteps are placed as far as the plans tell.

    Those after the last footstep mirror the last step. The one before the first is put beside it; where it
    belongs follows from the examples (`weights.place_departures`).
    """
    before = np.array([not plan.starts_standing for plan in plans], dtype=int)
    after = np.array([0 if plan.ends_standing else 2 for plan in plans])
    counts = np.array([len(plan) for plan in plans]) + before + after
    first = np.concatenate([[0], np.cumsum(counts)])
    total = int(first[-1])
    agents = np.repeat(np.arange(len(plans)), counts)
    steps = np.arange(total) - np.repeat(first[:-1] + before, counts)
    steps[steps >= np.repeat([len(plan) for plan in plans], counts)] = -1
    steps = np.maximum(steps, -1)
    real = steps >= 0
    table = {
        name: np.zeros((total, *shape), dtype=kind)
        for name, shape, kind in (
            ("sides", (), int),
            ("positions", (3,), float),
            ("yaws", (), float),
            ("normals", (3,), float),
            ("strikes", (), float),
            ("liftoffs", (), float),
        )
    }
    orientations = np.concatenate([plan.orientations for plan in plans])
    table["yaws"][real] = planar.yaw_of(quaternion.rotate(orientations, np.array([0.0, 0.0, 1.0]))[:, [0, 2]])
    table["normals"][real] = quaternion.rotate(orientations, np.array([0.0, 1.0, 0.0]))
    for name, values in (
        ("sides", [plan.sides for plan in plans]),
        ("positions", [plan.positions for plan in plans]),
        ("strikes", [plan.strike_times for plan in plans]),
        ("liftoffs", [plan.liftoff_times for plan in plans]),
    ):
        table[name][real] = np.concatenate(values)
    ends = np.array([plan.liftoff_times.max() for plan in plans])
    _lay_before(table, first[:-1][before == 1])
    lasts = first[1:][after > 0] - 3
    pair = lasts - np.array([[1], [0]])
    table["liftoffs"][lasts] = stay_down(table["strikes"][pair], table["liftoffs"][pair])
    for ahead in (1, 2):
        _lay_after(table, lasts + ahead, ends[after > 0])
    contacts = ContactTable(
        first=first,
        agents=agents,
        steps=steps,
        headings=np.zeros(total),
        starts=np.array([plan.strike_times[0] for plan in plans]),
        ends=ends,
        **table,
    )
    return with_headings(contacts)


def _lay_before(table: dict[str, FloatArray], rows: IntArray) -> None:
    """Fills the contacts before mid-gait starts, where a steady gait would have them.

    They lift off as long after the first strike, in runs before it, as the first footstep does after the second.
    """
    step_time = table["strikes"][rows + 2] - table["strikes"][rows + 1]
    overlap = table["liftoffs"][rows + 1] - table["strikes"][rows + 2]
    table["sides"][rows] = 1 - table["sides"][rows + 1]
    heading = planar.circular_mean(np.stack([table["yaws"][rows + 1], table["yaws"][rows + 2]]), axis=0)
    displacement = (table["positions"][rows + 2] - table["positions"][rows + 1])[:, [0, 2]]
    behind = planar.rotate(heading, planar.rotate(-heading, displacement) * np.array([1.0, -1.0]))
    for name in ("positions", "normals"):
        table[name][rows] = table[name][rows + 1]
    table["positions"][rows, 0] += behind[:, 0]
    table["positions"][rows, 2] += behind[:, 1]
    table["yaws"][rows] = table["yaws"][rows + 2]
    table["liftoffs"][rows] = table["strikes"][rows + 1] + np.minimum(overlap, LONGEST_OVERLAP * step_time)
    table["strikes"][rows] = table["strikes"][rows + 1] - step_time


def _lay_after(table: dict[str, FloatArray], rows: IntArray, ends: FloatArray) -> None:
    """Fills contacts after mid-gait ends: the mirror image of the step before, after the same time."""
    pair = rows - np.array([[2], [1]])
    heading = planar.circular_mean(table["yaws"][pair], axis=0)
    displacement = table["positions"][rows - 1] - table["positions"][rows - 2]
    step = planar.rotate(-heading, displacement[:, [0, 2]]) * np.array([-1.0, 1.0])
    table["sides"][rows] = table["sides"][rows - 2]
    table["positions"][rows] = table["positions"][rows - 1]
    table["positions"][np.ix_(rows, GROUND_AXES)] += planar.rotate(heading, step)
    table["normals"][rows] = table["normals"][rows - 1]
    table["yaws"][rows] = table["yaws"][rows - 2]
    table["strikes"][rows] = _following_strikes(table["strikes"][pair], table["liftoffs"][pair])
    table["liftoffs"][rows] = np.maximum(ends, table["strikes"][rows]) + 1.0


def stay_down(strikes: FloatArray, liftoffs: FloatArray) -> FloatArray:
    """When the last footsteps before mid-gait ends would lift off if their plans went on: most are cut off by the end.

    That is as long after the strike that follows, in runs before it, as the foot before them did; at the earliest
    when the plan says.

    Args:
        strikes: Of the last two footsteps [s], shape (2, N).
        liftoffs: Of these [s], shape (2, N).

    Returns:
        [s], shape (N,).
    """
    return np.maximum(liftoffs[1], _following_strikes(strikes, liftoffs) + liftoffs[0] - strikes[1])


def _following_strikes(strikes: FloatArray, liftoffs: FloatArray) -> FloatArray:
    """When the next foot strikes after two contacts, if that step takes as long as the one between them."""
    step_time = strikes[1] - strikes[0]
    step_time = np.where(step_time > 0.0, step_time, UNKNOWN_STEP_TIME)
    return np.maximum(strikes[1] + step_time, liftoffs[0] + 0.5 * step_time)


def with_headings(contacts: ContactTable) -> ContactTable:
    """The table with headings made anew: as given, else from its yaws."""
    yaws = contacts.yaws
    previous = np.concatenate([yaws[:1], yaws[:-1]])
    headings = planar.midway_yaw(previous, yaws)
    starts = contacts.first[:-1]
    headings[starts] = headings[starts + 1]
    if contacts.given_headings is not None:
        headings = np.where(np.isnan(contacts.given_headings), headings, contacts.given_headings)
    jumps = np.diff(headings, prepend=0.0)
    jumps[starts] = 0.0
    windings = np.cumsum(np.rint((planar.wrap_angle(jumps) - jumps) / (2.0 * np.pi)))  # whole: sums are exact
    windings -= np.repeat(windings[starts], np.diff(contacts.first))
    return replace(contacts, headings=headings + 2.0 * np.pi * windings)


def lay_on_ground(
    contacts: ContactTable, ground: Ground, *, planned: FloatArray, foot_lengths: FloatArray
) -> ContactTable:
    """The table with contacts put on the ground under them, if it is near.

    Footsteps that lie a little above or below the terrain stand on it: their places are exact across the ground only.
    A foot that comes down elsewhere stands on what may be walked on there: on the tread under its heel where its ball
    is over the edge. Where there is nothing it keeps its height.

    Args:
        contacts: As executed.
        ground: The terrain.
        planned: Their positions as planned [m], shape (C, 3); contacts that are no footsteps count as moved.
        foot_lengths: From heel to ball of each side [m], shape (2,).
    """
    if not ground.has_terrain:
        return contacts
    moved = (contacts.steps < 0) | (contacts.positions != planned).any(axis=1)
    places = contacts.positions
    reach = np.where(moved, NEAR_GROUND / contacts.normals[:, 1], NEAR_FOOTSTEP)
    found = ground.heights(places[:, [0, 2]], places[:, 1] + reach, step_up=0.0)
    carries = ~moved | (found.heights > places[:, 1]) | (found.walkable & (found.normals[:, 1] > STEEPEST))
    near = found.hit & (np.abs(found.heights - places[:, 1]) < reach) & carries
    heights = np.where(near, found.heights, places[:, 1])
    behind = -foot_lengths[contacts.sides, None] * planar.direction(contacts.yaws)
    rises = -np.sum(found.normals[:, GROUND_AXES] * behind, axis=1) / found.normals[:, 1]
    treads = ground.heights(places[:, [0, 2]] + behind, places[:, 1] + reach, step_up=0.0)
    over = moved & treads.hit & (treads.heights - heights > np.where(near, np.maximum(rises, 0.0), 0.0) + EDGE_HEIGHT)
    positions = places.copy()
    positions[:, 1] = np.where(over, treads.heights, heights)
    return replace(contacts, positions=positions)
