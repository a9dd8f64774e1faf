"""Feet apart: people whose ways cross do not tread on each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.testing import assert_allclose

from usdfoot.planning.collisions import find_collisions
from usdfoot.planning.feet_apart import FARTHEST, WIDER, set_feet_apart
from usdfoot.planning.foot_table import FootTable
from usdfoot.planning.step_limits import StepLimits, limit_steps, uncross

STEP, DURATION, STEPS = 0.7, 0.6, 12


def crossing(seed: int, people: int = 2) -> FootTable:
    """Feet of people who all walk past the middle in the middle of their ways, each in a direction of its own."""
    generator = np.random.default_rng(seed)
    count = people * STEPS
    numbers, owners = np.tile(np.arange(STEPS), people), np.repeat(np.arange(people), STEPS)
    headings, starts, asides = (
        np.repeat(generator.uniform(low, high, people), STEPS)
        for low, high in ((-np.pi, np.pi), (0.0, DURATION), (-0.2, 0.2))
    )
    along, across = STEP * (numbers - STEPS / 2), 0.1 * (-1.0) ** numbers + asides
    forward, left = (np.stack([np.sin(yaw), np.cos(yaw)], axis=1) for yaw in (headings, headings + 0.5 * np.pi))
    points = along[:, None] * forward + across[:, None] * left
    strikes = starts + DURATION * numbers
    return FootTable(
        owners=owners,
        numbers=numbers,
        positions=np.column_stack([points[:, 0], np.zeros(count), points[:, 1]]),
        yaws=headings,
        sides=numbers % 2,
        strikes=strikes,
        liftoffs=strikes + DURATION + 0.1,
        last=numbers >= STEPS - 2,
        heels=np.full(count, 0.18),
        toes=np.full(count, 0.08),
        half_widths=np.full(count, 0.05),
    )


def limits_of(feet: FootTable) -> StepLimits:
    """Of people who step as far aside as a leg is long."""
    narrowest, widest = (np.full(len(feet.owners), size) for size in (0.05, 0.86))
    return limit_steps(feet, narrowest=narrowest, widest=widest)


def test_feet_of_people_who_cross_come_apart() -> None:
    trodden = 0
    for seed in (*range(200), 604):  # in the last a foot goes through where the other has just come down
        feet = crossing(seed)
        trodden += len(find_collisions(feet).depths) > 0
        limits = limits_of(feet)
        apart = set_feet_apart(feet, limits)
        assert not len(find_collisions(apart).depths), seed
        rows = np.flatnonzero(feet.numbers > 0)
        assert limits.relaxed(narrower=0.0, wider=WIDER).excess(apart, rows).max() <= 1e-9, seed
        assert np.linalg.norm(apart.positions - feet.positions, axis=1).max() <= FARTHEST + 1e-9
    assert trodden > 150


def test_feet_with_room_stay_where_they_are_while_others_are_moved() -> None:
    feet = crossing(0, people=4)
    beside = np.isin(feet.owners, (2, 3))
    positions, yaws = feet.positions.copy(), np.where(beside, 0.0, feet.yaws)
    own = feet.numbers[beside]
    positions[beside, 0] = 50.0 + np.where(feet.owners[beside] == 2, 0.0, 0.32) + 0.1 * (-1.0) ** own
    positions[beside, 2] = STEP * own  # soles two centimetres apart where they pass
    feet = replace(feet, positions=positions, yaws=yaws, strikes=DURATION * feet.numbers.astype(float))
    feet = replace(feet, liftoffs=feet.strikes + DURATION + 0.1)
    apart = set_feet_apart(feet, limits_of(feet))
    assert np.array_equal(apart.positions[beside], feet.positions[beside])


def test_feet_come_down_in_reach_across() -> None:
    feet = crossing(0, people=1)
    positions, numbers = feet.positions.copy(), feet.numbers.astype(float)
    positions[:, [0, 2]] = np.stack([np.where(numbers % 2, 0.3 + 0.2 * numbers, 0.2 * numbers), numbers], axis=1)
    feet = replace(feet, positions=positions, yaws=np.zeros(STEPS), sides=1 - feet.numbers % 2)
    feet.positions[5, 0] += 0.6
    near = uncross(feet, replace(limits_of(feet), strained=np.full(STEPS, np.inf)))
    apart = np.abs(np.diff(near.positions[:, 0]))
    assert np.abs(np.diff(feet.positions[:, 0])).max() > 1.0
    assert apart.min() >= 0.05 - 1e-9
    assert apart.max() <= 0.86 + 1e-9


def test_feet_moved_aside_come_no_farther_than_legs_span():
    feet = crossing(0, people=1)
    positions = feet.positions.copy()
    outward = 0.1 * (-1.0) ** feet.numbers
    positions[:, 0], positions[:, 2] = outward, 0.6 * feet.numbers
    feet = replace(feet, positions=positions, yaws=np.zeros(STEPS), sides=feet.numbers % 2)
    limits, rows = limits_of(feet), np.arange(1, STEPS)
    pushed = replace(feet, positions=feet.positions + np.where(feet.numbers[:, None] == 5, [-0.4, 0.0, 0.6], 0.0))
    assert limits.excess(pushed, rows)[:, 1].max() > 0.1
    kept = uncross(pushed, limits)
    assert limits.excess(kept, rows).max() <= 1e-9
    assert_allclose(kept.positions[:5], feet.positions[:5])
    assert_allclose(kept.positions[-3:], feet.positions[-3:], atol=1e-9)
