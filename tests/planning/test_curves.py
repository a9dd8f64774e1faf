"""Curves of every basis and wrap against scipy's splines and direct formulas."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import BSpline, CubicHermiteSpline
from scipy.spatial import cKDTree

from usdfoot.errors import PlanError
from usdfoot.planning.curves import sample_curve, sample_hermite

POINTS = np.array([(0.0, 0, 0), (1, 0, 2), (3, 1, 1), (4, 0, 3), (6, 2, 2), (7, 0, 5), (9, 1, 4)])


def distances_to(curve, samples):
    """How far samples are from a densely evaluated curve."""
    return cKDTree(curve).query(samples)[0]


def test_bspline_is_scipys():
    spline = BSpline(np.arange(len(POINTS) + 4, dtype=float), POINTS, 3)
    truth = spline(np.linspace(3.0, len(POINTS), 20001)[:-1])
    samples = sample_curve(POINTS, basis="bspline")
    assert distances_to(truth, samples).max() < 1e-3
    assert_allclose(samples[0], (POINTS[0] + 4 * POINTS[1] + POINTS[2]) / 6.0)
    assert_allclose(samples[-1], (POINTS[-3] + 4 * POINTS[-2] + POINTS[-1]) / 6.0)


def test_catmull_rom_is_a_hermite_spline_with_central_differences():
    times = np.arange(1.0, len(POINTS) - 1)
    truth = CubicHermiteSpline(times, POINTS[1:-1], 0.5 * (POINTS[2:] - POINTS[:-2]))
    samples = sample_curve(POINTS, basis="catmullRom")
    assert distances_to(truth(np.linspace(1.0, len(POINTS) - 2.0, 20001)), samples).max() < 1e-3
    assert_allclose(samples[[0, -1]], POINTS[[1, -2]])


def test_hermite_is_scipys_and_c1(generator):
    tangents = generator.normal(size=POINTS.shape)
    truth = CubicHermiteSpline(np.arange(len(POINTS)), POINTS, tangents)
    samples = sample_hermite(POINTS, tangents)
    assert distances_to(truth(np.linspace(0.0, len(POINTS) - 1.0, 40001)), samples).max() < 2e-3
    for point in POINTS:
        assert np.linalg.norm(samples - point, axis=1).min() < 1e-9


def test_bezier_segments_share_their_ends():
    samples = sample_curve(POINTS, basis="bezier", density=0.01)
    u = np.linspace(0.0, 1.0, 2001)[:, None]
    a, b, c, d = POINTS[3:7]
    second = a * (1 - u) ** 3 + 3 * b * u * (1 - u) ** 2 + 3 * c * u**2 * (1 - u) + d * u**3
    half = samples[len(samples) // 2 :]
    assert min(np.linalg.norm(samples - POINTS[3], axis=1)) < 1e-9
    assert distances_to(second, half[half[:, 0] > POINTS[3, 0]]).max() < 1e-2
    assert_allclose(samples[[0, -1]], POINTS[[0, 6]])


@pytest.mark.parametrize("basis", ["bspline", "catmullRom"])
def test_pinned_curves_reach_their_end_points(basis):
    for points in (POINTS, POINTS[:2]):
        samples = sample_curve(points, basis=basis, wrap="pinned")
        assert_allclose(samples[[0, -1]], points[[0, -1]], atol=1e-12)


@pytest.mark.parametrize("basis", ["linear", "bspline", "catmullRom", "bezier"])
def test_periodic_curves_close_and_do_not_depend_on_where_they_begin(basis):
    points, shift = POINTS[:6], 3
    samples = sample_curve(points, basis=basis, wrap="periodic")
    assert_allclose(samples[0], samples[-1], atol=1e-12)
    turned = sample_curve(np.roll(points, -shift, axis=0), basis=basis, wrap="periodic")
    assert distances_to(turned, samples).max() < 0.1


def test_samples_are_dense():
    for basis in ("bezier", "bspline", "catmullRom"):
        samples = sample_curve(10.0 * POINTS, basis=basis, density=0.2)
        assert np.linalg.norm(np.diff(samples, axis=0), axis=1).max() < 0.2


@pytest.mark.parametrize(
    ("count", "options", "message"),
    [
        (1, {"basis": "linear"}, "two or more"),
        (3, {"basis": "bezier"}, "four points"),
        (6, {"basis": "bezier"}, "3 for each further segment"),
        (4, {"basis": "bezier", "wrap": "periodic"}, "multiple of 3"),
        (3, {"basis": "bspline"}, "four or more"),
        (4, {"basis": "power"}, "linear, bezier"),
        (4, {"basis": "bezier", "wrap": "open"}, "pinned"),
    ],
)
def test_points_that_make_no_curve_are_refused(count, options, message):
    with pytest.raises(PlanError, match=message):
        sample_curve(POINTS[:count], **options)
