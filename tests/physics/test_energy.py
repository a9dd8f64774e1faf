"""The forces legs cannot give, and the kernel's derivatives of E, against slow references."""

import numpy as np
import pytest
import warp as wp

from tests.physics.builders import human, walk
from tests.physics.equations_kernel import descend, normal_equations
from usdfoot.model.contact_table import lay_contacts
from usdfoot.physics.energy import leg_forces, segment_energies, spline_samples
from usdfoot.physics.footing import lay_footing
from usdfoot.physics.optimise import start_unknowns
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.samples import lay_samples
from usdfoot.physics.solve import device_problem, device_work, first_segments
from usdfoot.physics.spline import controls_of, lay_knots

GRAVITY = 9.81
SOFTNESS = 0.5


@pytest.fixture(scope="module")
def problem():
    """Two agents, one of which leaps and stands at last: samples, knots, random unknowns, options."""
    plans = [walk(4, turn=0.3), walk(5, lengths=[0.6, 1.4, 0.6, 0.4], ends_standing=True)]
    options = PhysicsOptions()
    contacts = lay_contacts(plans)
    footing = lay_footing(contacts, human(), options)
    knots = lay_knots(contacts, footing)
    samples = lay_samples(footing, knots, window=options.heading_window)
    random = np.random.default_rng(5)
    start = start_unknowns(contacts, knots, human())
    unknowns = start + random.normal(0.0, 0.1, start.shape)
    return samples, knots, unknowns, options


def nearest_on_cone(rays, wanted):
    """Smallest distance from a force to what pushing legs can give, by trying all combinations of legs."""
    best = np.linalg.norm(wanted)
    for legs in ([0], [1], [0, 1]):
        if max(legs) < len(rays):
            basis = np.array(rays)[legs].T
            shares, *_ = np.linalg.lstsq(basis, wanted, rcond=None)
            if (shares >= 0.0).all():
                best = min(best, np.linalg.norm(wanted - basis @ shares))
    return best


def test_residual_is_the_distance_to_the_cone_of_the_standing_legs():
    random = np.random.default_rng(3)
    count = 300
    supports = random.normal(0.0, 0.3, (count, 2, 3)) * [1.0, 0.2, 1.0]
    positions = random.normal(0.0, 0.2, (count, 3)) + [0.0, 0.9, 0.0]
    accelerations = random.normal(0.0, 4.0, (count, 3))
    accelerations[: count // 8, 1] -= 15.0
    standing = random.random((count, 2)) < 0.8
    forces = leg_forces(supports, standing, positions=positions, accelerations=accelerations, gravity=GRAVITY)
    pushing = forces.pushes > 0.0
    assert 0.05 < pushing.mean() < 0.95
    assert len(forces.planes) > 20
    for row in range(count):
        rays = [positions[row] - supports[row, leg] for leg in (0, 1) if standing[row, leg]]
        expected = nearest_on_cone(rays, accelerations[row] + [0.0, GRAVITY, 0.0])
        assert np.linalg.norm(forces.residuals[row]) == pytest.approx(expected, abs=1e-8)


def residual_rows(samples, knots, options, unknowns):
    """Square roots of E's terms with the norm's weights held, as one vector, and those weights."""
    controls = controls_of(unknowns, knots.begins)
    positions, accelerations = spline_samples(samples, controls)
    forces = leg_forces(
        samples.stance.supports,
        samples.stance.standing,
        positions=positions,
        accelerations=accelerations,
        gravity=options.gravity,
    )
    intervals = np.repeat(samples.intervals, samples.times.shape[1])
    stretches = np.linalg.norm(positions[:, None] - samples.stance.anchors, axis=-1) - samples.stance.nominal_lengths
    strains = np.sqrt(2.0 * options.comfort * intervals[:, None] * samples.stance.leg_shares) * stretches
    weights = np.sqrt(intervals / np.sqrt(np.sum(forces.residuals**2, axis=1) + SOFTNESS**2))
    return forces.residuals, strains, weights


def dense_equations(samples, knots, options, unknowns):
    """Hessian and gradient of the reweighted squares, the Jacobian by finite differences."""
    residuals, strains, weights = residual_rows(samples, knots, options, unknowns)
    rows = np.concatenate([(weights[:, None] * residuals).ravel(), strains.ravel()])
    jacobian = np.empty((len(rows), unknowns.size))
    step = 1e-6
    for column in range(unknowns.size):
        shift = np.zeros(unknowns.size)
        shift[column] = step
        sides = []
        for sign in (1.0, -1.0):
            moved, strained, _ = residual_rows(samples, knots, options, unknowns + sign * shift.reshape(-1, 6))
            sides.append(np.concatenate([(weights[:, None] * moved).ravel(), strained.ravel()]))
        jacobian[:, column] = (sides[0] - sides[1]) / (2.0 * step)
    jacobian[:, np.repeat(knots.fixed.ravel(), 3)] = 0.0
    return jacobian.T @ jacobian, jacobian.T @ rows


def device_equations(samples, knots, options, unknowns):
    count = len(knots.times)
    blocks = wp.zeros((2 * count, 4), dtype=wp.mat33d)
    gradients = wp.zeros(2 * count, dtype=wp.vec3d)
    values = wp.from_numpy(unknowns.reshape(count, 2, 3).copy(), dtype=wp.vec3d)
    inputs = [device_problem(samples, knots, options), first_segments(knots), SOFTNESS, values, blocks, gradients]
    wp.launch(normal_equations, dim=len(knots.starts), inputs=inputs)
    matrix = np.zeros((2 * count, 3, 2 * count, 3))
    for column, below in zip(*np.nonzero(np.abs(blocks.numpy()).max(axis=(2, 3))), strict=True):
        matrix[column + below, :, column] = blocks.numpy()[column, below]
        matrix[column, :, column + below] = blocks.numpy()[column, below].T
    return matrix.reshape(6 * count, 6 * count), gradients.numpy().ravel()


def test_analytic_jacobians_are_those_of_finite_differences(problem):
    expected, gradient = dense_equations(*problem[:2], problem[3], problem[2])
    found, slope = device_equations(*problem[:2], problem[3], problem[2])
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())
    np.testing.assert_allclose(slope, gradient, atol=1e-5 * np.abs(gradient).max())


def test_knots_touch_only_their_neighbours_and_agents_not_each_other(problem):
    samples, knots, unknowns, options = problem
    expected, _ = dense_equations(samples, knots, options, unknowns)
    blocks = np.abs(expected).reshape(len(knots.times), 6, len(knots.times), 6).max(axis=(1, 3))
    rows, columns = np.nonzero(blocks)
    assert (np.abs(rows - columns) <= 1).all()
    assert (knots.agents[rows] == knots.agents[columns]).all()


def test_gradient_is_that_of_the_energy(problem):
    samples, knots, unknowns, options = problem
    _, slope = device_equations(samples, knots, options, unknowns)
    random = np.random.default_rng(9)
    direction = random.normal(size=unknowns.shape) * np.repeat(~knots.fixed, 3, axis=1)

    def energy(values):
        residuals, strains, _ = residual_rows(samples, knots, options, values)
        soft = np.sqrt(np.sum(residuals**2, axis=1) + SOFTNESS**2)
        return np.repeat(samples.intervals, samples.times.shape[1]) @ soft + 0.5 * np.sum(strains**2)

    step = 1e-6
    difference = (energy(unknowns + step * direction) - energy(unknowns - step * direction)) / (2.0 * step)
    assert slope @ direction.ravel() == pytest.approx(difference, rel=1e-5)


def test_a_step_is_that_of_the_dense_solution(problem):
    samples, knots, unknowns, options = problem
    matrix, slope = device_equations(samples, knots, options, unknowns)
    diagonal = np.diag(matrix)
    damped = matrix + np.diag(1e-3 * diagonal + 1e-9 + (diagonal == 0.0))
    expected = unknowns - np.linalg.solve(damped, slope).reshape(-1, 6)
    found = unknowns.copy()
    work = device_work(found)
    work.iterations = 1
    wp.launch(descend, dim=2, inputs=[device_problem(samples, knots, options), work, first_segments(knots), SOFTNESS])
    np.testing.assert_allclose(found, expected, atol=1e-7)


def test_energy_of_the_paper_is_the_soft_one_without_softness(problem):
    samples, knots, unknowns, options = problem
    residuals, strains, _ = residual_rows(samples, knots, options, unknowns)
    intervals = np.repeat(samples.intervals, samples.times.shape[1])
    expected = intervals @ np.linalg.norm(residuals, axis=1) + 0.5 * np.sum(strains**2)
    found = segment_energies(
        samples, controls_of(unknowns, knots.begins), gravity=options.gravity, comfort=options.comfort
    )
    assert found.sum() == pytest.approx(expected, rel=1e-12)
