"""Where the pelvis goes for legs that would be too short."""

import numpy as np
import pytest
import warp as wp
from numpy.testing import assert_allclose

from usdfoot.engine.legs import LegRig, leg_kinematics
from usdfoot.engine.pelvis import longest_leg, pelvis_offset

FOOT_WAYS = np.linspace(0.6, 1.3, 1401)
"""How far ahead of its hip a foot is, over what the leg reaches."""


@wp.kernel
def offsets_for(
    rig: LegRig,
    turn: wp.array(dtype=wp.quatf),
    feet: wp.array(dtype=wp.vec3f),
    rotations: wp.array2d(dtype=wp.quatf),
    offsets: wp.array(dtype=wp.vec3f),
    missing: wp.array(dtype=wp.float32),
):
    frame = wp.tid()
    left = leg_kinematics(rig, 0, wp.vec3f(), turn[0], rotations, 0)
    right = leg_kinematics(rig, 1, wp.vec3f(), turn[0], rotations, 0)
    ankle = left.hip + feet[frame] * longest_leg(rig, left)
    offsets[frame] = pelvis_offset(rig, left, right, ankle, right.ankle, 1.0, 0.0, 0.0)
    missing[frame] = wp.length(ankle - left.hip - offsets[frame]) / longest_leg(rig, left) - 1.0


@pytest.mark.parametrize("depth", [0.3, 0.6])
def test_a_pelvis_follows_a_foot_about_as_fast_as_that_goes(walker_library, depth):
    """However flat the leg lies; downwards alone it would have to plunge. The foot is reached all the same."""
    rest = walker_library.source.skeleton.rest_rotations.astype(np.float32)[None]
    reached = FOOT_WAYS[np.hypot(FOOT_WAYS, depth) < 1.3]
    feet = np.stack([np.zeros_like(reached), np.full_like(reached, -depth), reached], axis=1).astype(np.float32)
    offsets, missing = wp.empty(len(feet), dtype=wp.vec3f), wp.empty(len(feet), dtype=wp.float32)
    wp.launch(
        offsets_for,
        dim=len(feet),
        inputs=[
            walker_library.rig.arrays,
            wp.array([wp.quat_identity()], dtype=wp.quatf),
            wp.array(feet, dtype=wp.vec3f),
            wp.array(rest, dtype=wp.quatf),
        ],
        outputs=[offsets, missing],
    )
    leg = walker_library.source.biped.maximal_leg_length
    speeds = np.linalg.norm(np.diff(offsets.numpy(), axis=0), axis=1) / (np.diff(reached) * leg)
    assert speeds.max() < 2.5
    assert_allclose(np.maximum(missing.numpy(), 0.0), 0.0, atol=3e-3)
