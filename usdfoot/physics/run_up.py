"""Steps before and after motions that begin or end in mid gait, so that the optimum there is that of a steady gait."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.contact_table import ContactTable, with_headings

__all__ = ["extend_contacts", "has_steady_end"]


def extend_contacts(contacts: ContactTable, *, strides: int) -> ContactTable:
    """The table with each plan's first and last stride repeated beyond its ends, and its time extended by them.

    Without them the centre of mass would be free to begin anywhere: a body that need not come from somewhere falls
    into its first step. Plans that begin or end standing keep what they have; those of fewer than three footsteps are
    extended by the contacts that are laid around them.

    Args:
        contacts: As laid from the plans.
        strides: How often to repeat; 0 = not at all.
    """
    if strides == 0:
        return contacts
    first, last, begins, ends = _steady_ends(contacts)
    back, front = np.where(begins, 2 * strides, 0), np.where(ends, 2 * strides, 0)
    lowest = np.where(begins, first, contacts.first[:-1])
    highest = np.where(ends, last, contacts.first[1:] - 1)
    counts = back + (highest - lowest + 1) + front
    starts = np.concatenate([[0], np.cumsum(counts)])
    agents = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(starts[-1]) - starts[agents] - back[agents] + lowest[agents]  # index into `contacts` if inside
    before, after = np.maximum(lowest[agents] - place, 0), np.maximum(place - highest[agents], 0)
    rows = np.where(before > 0, lowest[agents] + before % 2, place)
    rows = np.where(after > 0, highest[agents] - after % 2, rows)
    repeats = np.where(before > 0, -((before + 1) // 2), (after + 1) // 2)
    stride = np.where(before > 0, lowest[agents], highest[agents] - 2)
    stride = np.clip(stride, 0, len(contacts.sides) - 3)
    positions, yaws = _repeated(contacts, rows, stride, repeats)
    shifts = repeats * (contacts.strikes[stride + 2] - contacts.strikes[stride])
    table = replace(
        contacts,
        first=starts,
        agents=agents,
        steps=np.where(repeats == 0, contacts.steps[rows], -1),
        sides=contacts.sides[rows],
        positions=positions,
        yaws=yaws,
        normals=contacts.normals[rows],
        strikes=contacts.strikes[rows] + shifts,
        liftoffs=contacts.liftoffs[rows] + shifts,
        headings=np.zeros(len(rows)),
    )
    return with_headings(
        replace(
            table,
            starts=np.minimum(table.strikes[starts[:-1]], contacts.starts),
            ends=np.where(
                table.steps[starts[1:] - 1] < 0, np.maximum(table.strikes[starts[1:] - 1], contacts.ends), contacts.ends
            ),
        )
    )


def has_steady_end(strikes: FloatArray, liftoffs: FloatArray) -> BoolArray:
    """Whether the stride over three last footsteps (..., 3) can be repeated: each foot lifts off before it, (...)."""
    period = strikes[..., 2] - strikes[..., 0]
    return (liftoffs[..., 2] < strikes[..., 2] + period) & (liftoffs[..., 1] < strikes[..., 1] + period)


def _steady_ends(contacts: ContactTable) -> tuple[IntArray, IntArray, BoolArray, BoolArray]:
    """First and last footstep of each agent, and whether its first and its last stride can be repeated, (A,) each."""
    real = np.flatnonzero(contacts.steps >= 0)
    owners = contacts.agents[real]
    everyone = np.arange(len(contacts.starts))
    first = real[np.searchsorted(owners, everyone)]
    last = real[np.searchsorted(owners, everyone, side="right") - 1]
    enough = last - first >= 2
    strikes, liftoffs = contacts.strikes, contacts.liftoffs
    third = np.minimum(first + 2, len(strikes) - 1)
    period = strikes[third] - strikes[first]
    begins = enough & (strikes[first + 1] > strikes[first]) & (strikes[first] + period > liftoffs[first])
    stride = np.maximum(last[:, None] + np.arange(-2, 1), 0)
    steady = has_steady_end(strikes[stride], liftoffs[stride])
    return first, last, begins, enough & steady & (liftoffs[last] != liftoffs[last - 1])


def _repeated(
    contacts: ContactTable, rows: IntArray, strides: IntArray, repeats: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Positions and yaws of contacts `rows` carried on by a stride, from contact `strides` to the second after it."""
    begin, end = contacts.positions[strides], contacts.positions[strides + 2]
    turn = planar.wrap_angle(contacts.yaws[strides + 2] - contacts.yaws[strides])
    positions, yaws = contacts.positions[rows].copy(), contacts.yaws[rows] + repeats * turn
    sign = np.sign(repeats)
    source, target = np.where(sign[:, None] > 0, begin, end), np.where(sign[:, None] > 0, end, begin)
    for done in range(int(np.abs(repeats).max(initial=0))):
        moving = np.abs(repeats) > done
        across = positions - source
        moved = target + across
        moved[:, [0, 2]] = target[:, [0, 2]] + planar.rotate(sign * turn, across[:, [0, 2]])
        positions = np.where(moving[:, None], moved, positions)
    return positions, yaws
