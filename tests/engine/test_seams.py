"""Seams between steps: position and velocity pass through them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.engine.plans import way
from tests.engine.synthesis import synthesise
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.poses import device_segments, place_segments, pose_frames
from usdfoot.engine.seams import measure_seams
from usdfoot.maths import quaternion

PROBE = 0.002

PLANS = {
    "walk": way(turn=0.1, length=0.6),
    "walk of changing steps": way(length=0.3, step_time=0.55, rise=0.05),
    "run": way(length=1.0, step_time=0.35, duty=0.4, width=0.13),
    "from stand to stand": way(stand_first=0.9, stand_last=1.0),
}


def poses_beside(library, plan, seam: str):
    """Joint rotations and pelvis positions at -2, -1, 0 | 0, 1, 2 probes from each seam, shape (S, 6, ...)."""
    options = EngineOptions(seam=seam)
    made = synthesise(library, [plan], options=options)
    setup, blend = made.setup, made.blend
    joints = np.arange(len(setup.skeleton.joints))
    seams = np.flatnonzero(setup.segments.joined)
    rows = np.repeat(np.stack([seams - 1, seams], axis=1), 3, axis=1)
    times = setup.segments.begins[seams][:, None] + PROBE * np.array([-2.0, -1.0, 0.0, 0.0, 1.0, 2.0])
    arrays = device_segments(setup, blend)
    arrays = place_segments(setup, arrays, measure_seams(setup, arrays) if seam != "none" else None)
    poses = pose_frames(setup, arrays, rows=rows.ravel(), times=times.ravel(), joints=joints)
    rotations = poses.rotations.numpy().reshape(len(seams), 6, len(joints), 4).astype(float)
    pelvis = setup.library.pelvis
    rotations[:, :, pelvis] = poses.pelvis_rotations.numpy().reshape(len(seams), 6, 4)
    positions = poses.pelvis_positions.numpy().reshape(len(seams), 6, 3).astype(float)
    return np.delete(rotations, np.arange(pelvis), axis=2), positions


def turn(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Rotation vectors from first to second."""
    return quaternion.to_rotation_vector(quaternion.compose(second, quaternion.inverse(first)))


def rotation_jumps(rotations: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Jumps in value [rad] and velocity [rad/s] of all joints; the velocities extrapolated to the seam."""
    values = np.linalg.norm(turn(rotations[:, 2], rotations[:, 3]), axis=-1)
    before = 1.5 * turn(rotations[:, 1], rotations[:, 2]) - 0.5 * turn(rotations[:, 0], rotations[:, 1])
    after = 1.5 * turn(rotations[:, 3], rotations[:, 4]) - 0.5 * turn(rotations[:, 4], rotations[:, 5])
    return values, np.linalg.norm(after - before, axis=-1) / PROBE


def position_jumps(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Jumps in value [m] and velocity [m/s] of the pelvis."""
    values = np.linalg.norm(positions[:, 3] - positions[:, 2], axis=-1)
    steps = np.diff(positions, axis=1)
    velocity = (1.5 * steps[:, 3] - 0.5 * steps[:, 4]) - (1.5 * steps[:, 1] - 0.5 * steps[:, 0])
    return values, np.linalg.norm(velocity, axis=-1) / PROBE


@pytest.mark.parametrize("plan", PLANS.values(), ids=PLANS.keys())
def test_inertialised_seams_keep_pose_and_velocity(walker_library, plan):
    rotations, positions = poses_beside(walker_library, plan, "inertialise")
    values, velocities = rotation_jumps(rotations)
    assert values.max() < 1e-3
    assert velocities.max() < 0.3
    values, velocities = position_jumps(positions)
    assert values.max() < 1e-4
    assert velocities.max() < 0.3


def test_without_seams_there_are_jumps(walker_library):
    plan = PLANS["from stand to stand"]
    rotations, _ = poses_beside(walker_library, plan, "none")
    values, velocities = rotation_jumps(rotations)
    assert values.max() > 0.01
    assert velocities.max() > 3.0


def test_a_crossfade_keeps_the_pose_but_not_the_velocity(walker_library):
    rotations, positions = poses_beside(walker_library, PLANS["from stand to stand"], "crossfade")
    values, _ = rotation_jumps(rotations)
    assert values.max() < 0.02
    assert position_jumps(positions)[0].max() < 1e-4


@pytest.mark.parametrize("seam", ["inertialise", "crossfade", "none"])
def test_feet_stand_still_whatever_the_seam(animate, seam):
    motion = animate([PLANS["walk"]], options=EngineOptions(seam=seam), rate=60.0)[0]
    assert_allclose(motion.results.slide, 0.0, atol=1e-4)
    assert_allclose(motion.results.placement_error, 0.0, atol=1e-4)
