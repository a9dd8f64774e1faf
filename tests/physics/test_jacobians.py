"""Analytic derivatives of the forces and of E against finite differences."""

import numpy as np
import pytest

from usdfoot.physics.energy import FLIGHT, LEFT_RAY, PLANE, RIGHT_RAY, leg_forces
from usdfoot.physics.linear import force_jacobians

GRAVITY = 9.81


def random_samples(count=400):
    random = np.random.default_rng(3)
    supports = random.normal(0.0, 0.3, (count, 2, 3)) * [1.0, 0.2, 1.0]
    positions = random.normal(0.0, 0.2, (count, 3)) + [0.0, 0.9, 0.0]
    accelerations = random.normal(0.0, 4.0, (count, 3))
    accelerations[: count // 8, 1] -= 15.0
    standing = random.random((count, 2)) < 0.8
    return supports, standing, positions, accelerations


def test_every_face_of_the_cone_has_the_jacobian_of_finite_differences():
    supports, standing, positions, accelerations = random_samples()
    forces = leg_forces(supports, standing, positions, accelerations, GRAVITY)
    assert set(np.unique(forces.faces)) == {FLIGHT, LEFT_RAY, RIGHT_RAY, PLANE}
    by_position, by_acceleration = force_jacobians(forces, supports)
    step = 1e-6
    for axis in range(3):
        shift = step * np.eye(3)[axis]
        for jacobian, moves in ((by_position, (shift, 0.0)), (by_acceleration, (0.0, shift))):
            ahead, behind = (
                leg_forces(supports, standing, positions + s * moves[0], accelerations + s * moves[1], GRAVITY)
                for s in (1.0, -1.0)
            )
            smooth = (ahead.faces == forces.faces) & (behind.faces == forces.faces)
            assert smooth.mean() > 0.98
            differences = (ahead.residuals - behind.residuals) / (2.0 * step)
            np.testing.assert_allclose(jacobian[smooth][..., axis], differences[smooth], atol=2e-5)


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
    supports, standing, positions, accelerations = random_samples(200)
    forces = leg_forces(supports, standing, positions, accelerations, GRAVITY)
    for row in range(200):
        rays = [positions[row] - supports[row, leg] for leg in (0, 1) if standing[row, leg]]
        expected = nearest_on_cone(rays, accelerations[row] + [0.0, GRAVITY, 0.0])
        assert np.linalg.norm(forces.residuals[row]) == pytest.approx(expected, abs=1e-9)
