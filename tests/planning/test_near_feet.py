"""Near feet: all pairs that are near, no others, and the same after some have moved."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from usdfoot.planning.foot_table import FootTable, Instants, between, foot_axes
from usdfoot.planning.near_feet import STOREY, Pairs, find_near_feet, find_pairs_of, overlaps
from usdfoot.planning.presences import INSTANT

SLACK = 0.1


def crowded(seed: int, *, people: int = 6, steps: int = 8) -> FootTable:
    """Feet of people who stamp about in a few square metres, now and then for a long time, on two storeys."""
    generator = np.random.default_rng(seed)
    count = people * steps
    owners, numbers = np.repeat(np.arange(people), steps), np.tile(np.arange(steps), people)
    gaps = generator.choice([0.35, 0.6, 4.0], size=(people, steps))
    strikes = (np.cumsum(gaps, axis=1) + generator.uniform(0.0, 2.0, size=(people, 1))).ravel()
    following = np.where(numbers < steps - 2, strikes[np.minimum(np.arange(count) + 2, count - 1)], strikes + 2.0)
    heights = np.repeat(generator.choice([0.0, 0.45], size=people), steps)
    return FootTable(
        owners=owners,
        numbers=numbers,
        positions=np.column_stack([generator.uniform(-1.0, 1.0, count), heights, generator.uniform(-1.0, 1.0, count)]),
        yaws=generator.uniform(-np.pi, np.pi, count),
        sides=numbers % 2,
        strikes=strikes,
        liftoffs=strikes + generator.uniform(0.3, 0.9, count) * (following - strikes),
        last=numbers >= steps - 2,
        heels=np.full(count, 0.18),
        toes=np.full(count, 0.08),
        half_widths=np.full(count, 0.05),
    )


def presences(feet: FootTable) -> list[tuple[int, int, float]]:
    """Footstep, instant and share of the way to the next, of every foot at every instant."""
    found = []
    for step in range(len(feet.owners)):
        end = feet.liftoffs[step] if feet.last[step] else feet.strikes[step + 2] - 1e-9
        for instant in range(int(np.ceil(feet.strikes[step] / INSTANT - 1e-9)), int(np.floor(end / INSTANT)) + 1):
            phase = 0.0
            if not feet.last[step] and INSTANT * instant > feet.liftoffs[step]:
                phase = (INSTANT * instant - feet.liftoffs[step]) / (feet.strikes[step + 2] - feet.liftoffs[step])
            found.append((step, instant, phase * phase * (3.0 - 2.0 * phase)))
    return found


def expected(feet: FootTable) -> set[tuple[int, int, int]]:
    """Footsteps and instant of each pair that is near, by comparing all with all."""
    found: dict[tuple[int, ...], tuple[int, int, int]] = {}
    everything = sorted(presences(feet), key=lambda presence: presence[1])
    reach = float((feet.heels + feet.toes).max()) + SLACK
    for index, (one, instant, share) in enumerate(everything):
        for other, again, part in everything[index + 1 :]:
            if again > instant:
                break
            if feet.owners[one] == feet.owners[other]:
                continue
            both = [
                Instants(steps=np.array([step]), shares=np.array([way]), times=np.array([INSTANT * instant]))
                for step, way in ((one, share), (other, part))
            ]
            middles = [foot_axes(feet, single).mean(axis=1)[0] for single in both]
            rise = np.subtract(*(between(feet, single, feet.positions[:, 1])[0] for single in both)) * reach / STOREY
            if np.hypot(np.linalg.norm(middles[0] - middles[1]), rise) > reach:
                continue
            if overlaps(feet, *both)[0][0] > -SLACK:
                low, high = sorted((one, other))
                standing = share == 0.0 and part == 0.0
                found.setdefault((low, high) if standing else (low, high, instant), (low, high, instant))
    return set(found.values())


def pairs_of(near: Pairs) -> set[tuple[int, int, int]]:
    instants = np.round(near.first.times / INSTANT).astype(int)
    return set(zip(near.first.steps.tolist(), near.second.steps.tolist(), instants.tolist(), strict=True))


def test_all_pairs_that_are_near_are_found() -> None:
    for seed in range(3):
        feet = crowded(seed)
        found = find_near_feet(feet, slack=SLACK)
        assert pairs_of(found) == expected(feet)
        assert len(found.first.steps) == len(pairs_of(found))  # each once


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), share=st.floats(0.0, 1.0))
def test_after_some_have_moved_the_pairs_are_those_of_a_new_search(seed: int, share: float) -> None:
    feet = crowded(seed)
    generator = np.random.default_rng(seed + 1)
    moved = generator.random(len(feet.owners)) < share
    positions = feet.positions + moved[:, None] * generator.normal(scale=0.2, size=feet.positions.shape)
    later = replace(feet, positions=positions)
    followed, anew = find_near_feet(feet, slack=SLACK).after(later, moved), find_near_feet(later, slack=SLACK)
    assert pairs_of(followed) == pairs_of(anew)
    assert len(followed.first.steps) == len(anew.first.steps)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), share=st.floats(0.0, 1.0))
def test_pairs_of_some_footsteps_are_those_of_all_pairs_that_touch_them(seed: int, share: float) -> None:
    feet = crowded(seed)
    steps = np.random.default_rng(seed + 1).random(len(feet.owners)) < share
    near, some = find_near_feet(feet, slack=SLACK), find_pairs_of(feet, steps, slack=SLACK)
    assert pairs_of(some) == pairs_of(near[near.touch(steps)])
    assert_allclose(some.depths, near.depths[near.touch(steps)], atol=0.0)


def test_feet_of_nobody_are_near_nobody() -> None:
    alone = crowded(0, people=1)
    assert not len(find_near_feet(alone, slack=SLACK).depths)
    assert not len(find_pairs_of(alone, np.zeros(len(alone.owners), dtype=bool), slack=SLACK).depths)


def test_overlaps_are_kept_up_to_date_where_feet_move() -> None:
    feet = crowded(1)
    generator = np.random.default_rng(2)
    moved = generator.random(len(feet.owners)) < 0.3
    later = replace(feet, positions=feet.positions + moved[:, None] * generator.normal(scale=0.2, size=(len(moved), 3)))
    near = find_near_feet(feet, slack=SLACK)
    for known in (near, near.moved(later, moved), near.after(later, moved)):
        depths, directions = overlaps(feet if known is near else later, known.first, known.second)
        assert_allclose(known.depths, depths, atol=1e-12)
        assert_allclose(known.directions, directions, atol=1e-12)
