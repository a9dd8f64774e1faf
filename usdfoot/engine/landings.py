"""Where blended steps land: the blend of chosen examples, and the landing measured on its pose ([B] Fig. 5)."""

from __future__ import annotations

import numpy as np

from usdfoot.engine.poses import Setup, StepBlend, device_segments, pose_feet, pose_frames
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray, IntArray

__all__ = ["GROUND_AXES", "beyond_reach", "landing_offsets", "merge_blends", "stand_blend", "with_steps"]

GROUND_AXES = np.array([0, 2])


def stand_blend(count: int, stand: int, *, width: int) -> StepBlend:
    """Blend of `count` segments that stand; each may take `width` examples."""
    weights = np.zeros((count, width))
    weights[:, 0] = 1.0
    return StepBlend(examples=np.full((count, width), stand), weights=weights, twists=np.zeros(count))


def with_steps(
    blend: StepBlend, steps: IntArray, examples: IntArray, weights: FloatArray, twists: FloatArray
) -> StepBlend:
    """The blend with other examples and weights (N, K), heaviest first, and twists (N,) [rad] of the `steps` (N,)."""
    all_examples, all_weights, all_twists = blend.examples.copy(), blend.weights.copy(), blend.twists.copy()
    used = examples.shape[1]
    all_examples[steps] = examples[:, :1]
    all_examples[steps, :used] = examples
    all_weights[steps] = 0.0
    all_weights[steps, :used] = weights
    all_twists[steps] = twists
    return StepBlend(examples=all_examples, weights=all_weights, twists=all_twists)


def merge_blends(blend: StepBlend, other: StepBlend, rows: IntArray) -> StepBlend:
    """`blend` with the rows of `other`."""
    return with_steps(blend, rows, other.examples[rows], other.weights[rows], other.twists[rows])


def landing_offsets(setup: Setup, blend: StepBlend, steps: IntArray) -> FloatArray:
    """Footstep minus where the blended swing foot is going to be planted, (x, z) [m], shape (N, 2)."""
    contacts, segments, examples = setup.contacts, setup.segments, setup.examples
    arrays = device_segments(setup, blend, origins=np.zeros((len(segments), 3)))
    poses = pose_frames(setup, blend, arrays, steps, segments.ends[steps], joints=setup.rig.leg_joints)
    targets = segments.supports[steps] + 1
    balls = pose_feet(setup.rig, poses).balls[np.arange(len(steps)), contacts.sides[targets]][:, GROUND_AXES]
    settle = examples.landings - examples.swing_balls[:, -1, GROUND_AXES]  # from the strike until the ball is down
    settling = np.sum(blend.weights[steps, :, None] * settle[blend.examples[steps]], axis=1)
    headings = contacts.headings[segments.supports[steps]] + blend.twists[steps]
    landing = balls + planar.rotate(headings, settling)
    target = contacts.positions[targets] - contacts.positions[segments.supports[steps]]
    offsets: FloatArray = target[:, GROUND_AXES] - landing
    return offsets


def beyond_reach(setup: Setup, offsets: FloatArray, reach: FloatArray) -> FloatArray:
    """How far each landing has to fall short of its footstep, (x, z) [m], shape (M, 2).

    What is left of `offsets` (M, 2) beyond the agents' `reach` (A,), or of the step beyond `longest_step` legs.
    """
    segments, positions = setup.segments, setup.contacts.positions
    distance = np.linalg.norm(offsets, axis=1)
    beyond_ik = offsets * np.maximum(1.0 - reach[segments.agents] / np.maximum(distance, 1e-12), 0.0)[:, None]
    steps = np.flatnonzero(~segments.stands)
    supports = segments.supports[steps]
    grounded = setup.contacts.liftoffs[supports] >= setup.contacts.strikes[supports + 1]
    strides = (positions[supports + 1] - positions[supports])[:, GROUND_AXES]
    longest = np.where(grounded, setup.options.longest_step * setup.leg_length, np.inf)
    beyond_leg = np.zeros_like(offsets)
    lengths = np.linalg.norm(strides, axis=1)
    beyond_leg[steps] = strides * np.maximum(1.0 - longest / np.maximum(lengths, 1e-12), 0.0)[:, None]
    farther = np.linalg.norm(beyond_leg, axis=1) > np.linalg.norm(beyond_ik, axis=1)
    return np.where(farther[:, None], beyond_leg, beyond_ik)
