"""Root curves against lines fitted one by one, and many trajectories asked at once against each alone."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from usdfoot.errors import PlanError
from usdfoot.model.trajectory import RootTrajectory, sample_trajectories
from usdfoot.planning import root_curves
from usdfoot.planning.root_curves import LARGEST, SPACING, CurveBatches, build_root_curves

SIGMA = 0.19


def walkers(seed: int, *, count: int = 4) -> list[RootTrajectory]:
    generator = np.random.default_rng(seed)
    return [
        RootTrajectory(
            name=f"walker_{index}",
            times=generator.uniform(-50.0, 50.0) + np.cumsum(generator.uniform(0.05, 0.6, size=length)),
            positions=np.cumsum(generator.normal(scale=0.3, size=(length, 3)), axis=0),
            yaws=np.cumsum(generator.normal(scale=0.2, size=length)) if index % 2 else None,
        )
        for index, length in enumerate(generator.integers(2, 12, size=count).tolist())
    ]


def test_many_trajectories_are_sampled_as_each_alone() -> None:
    found = walkers(3)
    numbers = np.array([2, 0, 3, 1])[:, None] + np.zeros(60, dtype=int)
    times = np.stack([np.linspace(found[i].start - 1.0, found[i].end + 1.0, 60) for i in numbers[:, 0]])
    times[:, 30] = [found[i].times[1] for i in numbers[:, 0]]  # exactly at a sample
    values = np.concatenate([walker.positions for walker in found])
    expected = [
        np.stack([np.interp(clock, found[i].times, column) for column in found[i].positions.T], axis=1)
        for i, clock in zip(numbers[:, 0], times, strict=True)
    ]
    assert_allclose(sample_trajectories(found, numbers, times, values=values), expected, atol=1e-9)


def test_curves_are_lines_fitted_in_gaussian_windows() -> None:
    found = walkers(5)
    curves = build_root_curves(found, smoothing_time=SIGMA)
    for agent, walker in enumerate(found):
        clock = np.arange(int((walker.end - walker.start) / SPACING + 0.5) + 1) * SPACING
        asked = np.minimum(clock, walker.end - walker.start) + walker.start
        given = np.stack([np.interp(asked, walker.times, column) for column in walker.positions.T], axis=1)
        for frame in range(0, len(clock), 3):
            offsets = np.arange(len(clock)) - frame
            near = np.abs(offsets) <= np.ceil(3.0 * SIGMA / SPACING)
            weights = np.exp(-0.5 * (offsets[near] * SPACING / SIGMA) ** 2)
            line = np.polyfit(offsets[near], given[near], 1, w=np.sqrt(weights))
            assert_allclose(curves.positions[agent, frame], line[1], atol=1e-8)


def test_given_headings_are_kept_and_others_follow_the_way() -> None:
    times = np.linspace(0.0, 4.0, 41)
    ahead = np.stack([0.0 * times, 0.0 * times, times], axis=1)
    looking = RootTrajectory(name="looking", times=times, positions=ahead, yaws=np.full(41, 1.0))
    going = RootTrajectory(name="going", times=times, positions=ahead, yaws=None)
    curves = build_root_curves([looking, going], smoothing_time=SIGMA)
    assert_allclose(curves.yaws[0], 1.0, atol=1e-9)
    assert_allclose(curves.yaws[1], 0.0, atol=1e-9)


def test_curves_of_all_hours_are_refused_with_the_longest() -> None:
    short = RootTrajectory(name="short", times=np.array([0.0, 1.0]), positions=np.zeros((2, 3)), yaws=None)
    long = RootTrajectory(
        name="long", times=np.array([0.0, 1.01 * LARGEST * SPACING]), positions=np.zeros((2, 3)), yaws=None
    )
    with pytest.raises(PlanError, match="long"):
        build_root_curves([short, long], smoothing_time=SIGMA)


def test_curves_have_the_same_bytes_alone_in_batches_and_all_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    found = walkers(7, count=9)
    whole = build_root_curves(found, smoothing_time=SIGMA)
    monkeypatch.setattr(root_curves, "BATCH", 4 * whole.yaws.shape[1])
    for curves in (build_root_curves(found, smoothing_time=SIGMA), whole):
        for name, values in vars(curves).items():
            assert np.array_equal(values, getattr(whole, name)), name
    for agent, walker in enumerate(found):
        alone = build_root_curves([walker], smoothing_time=SIGMA)
        count = alone.yaws.shape[1]
        assert np.array_equal(alone.positions[0], whole.positions[agent, :count])
        assert np.array_equal(alone.yaws[0], whole.yaws[agent, :count])


def test_crowds_of_any_size_are_made_in_even_batches(monkeypatch: pytest.MonkeyPatch) -> None:
    found = walkers(8, count=7)
    whole = build_root_curves(found, smoothing_time=SIGMA)
    monkeypatch.setattr(root_curves, "BATCH", 1)
    monkeypatch.setattr(root_curves, "KEPT", 1)
    agents = np.array([6, 1, 2, 5, 3])
    parts = list(CurveBatches(found, smoothing_time=SIGMA).of(agents))
    assert [part.tolist() for part, _ in parts] == [[6, 1], [2, 5], [3]]
    for part, curves in parts:
        assert np.array_equal(curves.positions, whole.positions[part, : curves.yaws.shape[1]])
