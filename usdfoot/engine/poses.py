"""Poses of any segment at any instant: the set-up and the output frames are sampled by the same kernels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.engine.clocks import device_clocks
from usdfoot.engine.flight import liftoff_samples, natural_flights
from usdfoot.engine.kernels import LibraryArrays, SegmentArrays, pose_bodies
from usdfoot.engine.pose_source import Layout, Poses
from usdfoot.engine.rig import Rig
from usdfoot.engine.time_warps import blended_durations
from usdfoot.maths.types import BoolArray, FloatArray, IntArray, StyleArray
from usdfoot.model.examples import Examples
from usdfoot.spaces.landings import root_starts

__all__ = [
    "ClipPoses",
    "Seams",
    "Setup",
    "StepBlend",
    "blend_frames",
    "device_library",
    "device_segments",
    "no_seams",
    "place_segments",
    "pose_frames",
    "segment_origins",
]

NOTHING = 1e-9
"""A component of a unit quaternion smaller than this is none."""


@dataclass(frozen=True, kw_only=True)
class StepBlend:
    """Which examples each segment blends and how it is turned."""

    examples: IntArray
    """Heaviest first, padded with weight 0, shape (M, 4); (M, 8) where the root has examples of its own."""
    weights: FloatArray
    """Non-negative, sum 1, of the same shape."""
    twists: FloatArray
    """Turn about the support ball by the end of the step, on top of the examples' own [rad], shape (M,)."""


@dataclass(frozen=True, kw_only=True)
class Seams:
    """Half of each jump between segments and of its rate, on the device; shape (M + 1, ...)."""

    joint_values: wp.array
    joint_slopes: wp.array
    position_values: wp.array
    position_slopes: wp.array


@dataclass(frozen=True, kw_only=True)
class Setup(Layout):
    """What does not change from frame to frame, for all agents of one clip library."""

    examples: Examples
    library: LibraryArrays
    leg_length: float
    """From hip to ankle with the knee straight [m]."""
    hip_width: float
    """Between the hip joints [m]."""
    styles: StyleArray
    """Style of the step that ends with each contact, shape (C,)."""

    @property
    def longest_step(self) -> float:
        """Without a flight: legs so far apart along the way, hips across it [m]."""
        return float(np.hypot(self.options.longest_step * self.leg_length, self.hip_width))


@dataclass(frozen=True, kw_only=True)
class ClipPoses:
    """Poses blended from clips."""

    setup: Setup
    arrays: SegmentArrays
    """Segments and their seams on the device."""

    def pose(self, rows: IntArray, times: FloatArray, *, joints: IntArray) -> Poses:
        """Blended poses, see `pose_frames`."""
        return pose_frames(self.setup, self.arrays, rows=rows, times=times, joints=joints)


def device_library(
    examples: Examples, rig: Rig, *, pelvis: int, slerps: bool = False, frame: str = "support"
) -> LibraryArrays:
    """Examples as device arrays, whose rotations are to be summed, or slerped one after the other.

    Blends are to land from the support ball, or from the root (`frame`).
    """
    library = LibraryArrays()
    rotations, alike = _aligned(examples.rotations)
    library.rotations, library.alike = wp.array(rotations, dtype=wp.quatf), wp.array(alike, dtype=wp.bool)
    library.pelvis_positions = wp.array(examples.pelvis_positions.astype(np.float32), dtype=wp.vec3f, copy=False)
    library.support_balls = wp.array(examples.support_balls.astype(np.float32), dtype=wp.vec3f, copy=False)
    origins = root_starts(examples.departures) if frame == "root" else 0.0
    settles = examples.landings - origins - examples.swing_balls[:, -1, [0, 2]]
    library.settles = wp.array(settles, dtype=wp.vec2d)
    library.turns = wp.array(examples.turns, dtype=wp.float64)
    library.liftoffs = wp.array(liftoff_samples(examples), dtype=wp.float64)
    library.translations = rig.arrays.translations
    library.chains = rig.arrays.chains
    library.pelvis, library.slerps = pelvis, slerps
    return library


def _aligned(rotations: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Rotations (E, S, J, 4) in single precision, and of which joints (J,) they are aligned to one reference.

    That is a joint's mean, from which they all are turned by less than 90 degrees, so that no two need be aligned to be
    summed. What is too small to count beside 1 is 0: the processor takes long over squares of such numbers.
    """
    rotations = np.where(np.abs(rotations) < NOTHING, 0.0, rotations).astype(np.float32)
    moments = np.einsum("esji,esjk->jik", rotations, rotations, optimize=True)
    means = np.linalg.eigh(moments.astype(float))[1][..., -1]
    means *= np.where(means[:, 3:] < 0.0, -1.0, 1.0)
    along = np.einsum("esji,ji->esj", rotations, means.astype(np.float32))
    alike: BoolArray = np.abs(along).min(axis=(0, 1)) > np.sqrt(0.5)
    return np.where((alike & (along < 0.0))[..., None], -rotations, rotations), alike


def segment_origins(setup: Setup) -> FloatArray:
    """Support ball's footstep, or the middle of both in a stand, from the agent's origin [m], shape (M, 3)."""
    positions, supports = setup.contacts.positions, setup.segments.supports
    middle = 0.5 * (positions[supports] + positions[supports - 1])
    places = np.where(setup.segments.stands[:, None], middle, positions[supports])
    origins: FloatArray = places - setup.origins[setup.segments.agents]
    return origins


def device_segments(setup: Setup, blend: StepBlend) -> SegmentArrays:
    """Segments as device arrays, all put on the agents' origins across the ground, their jumps left as they are.

    So what is measured on single precision poses is spared the rounding of an agent far from its origin.
    """
    contacts, supports, stands = setup.contacts, setup.segments.supports, setup.segments.stands
    arrays = SegmentArrays()
    chosen, weights = blend.examples.astype(np.int32), blend.weights.astype(np.float32)
    wide = weights.shape[1] > 4
    natural = natural_flights(setup.examples, blend.examples, blend.weights)
    planned = setup.segments.knot_times[:, -1] - setup.segments.knot_times[:, 0]
    anchors = np.sum(blend.weights * liftoff_samples(setup.examples)[blend.examples], axis=1)
    for name, values, kind in (
        ("examples", chosen[:, :4], wp.vec4i),
        ("weights", weights[:, :4], wp.vec4f),
        ("more_examples", chosen[:, 4:] if wide else 0 * chosen, wp.vec4i),
        ("more_weights", weights[:, 4:] if wide else 0 * weights, wp.vec4f),
        ("support_sides", np.where(stands, -1, contacts.sides[supports]).astype(np.int32), wp.int32),
        ("anchors", anchors.astype(np.float32), wp.float32),
        ("seams_after", np.arange(1, len(supports) + 1, dtype=np.int32), wp.int32),
        ("origins", np.zeros((len(supports), 3), dtype=np.float32), wp.vec3f),
    ):
        setattr(arrays, name, wp.array(np.ascontiguousarray(values), dtype=kind, copy=False))
    seams = no_seams(len(supports), len(setup.skeleton.joints))
    arrays.joint_values, arrays.joint_slopes = seams.joint_values, seams.joint_slopes
    arrays.position_values, arrays.position_slopes = seams.position_values, seams.position_slopes
    arrays.clocks = device_clocks(
        contacts,
        setup.segments,
        setup.path,
        twists=blend.twists,
        natural=natural,
        warps=planned / blended_durations(setup.examples, blend.examples, blend.weights),
        levels=setup.origins[:, 1],
        options=setup.options,
    )
    return arrays


def place_segments(setup: Setup, arrays: SegmentArrays, seams: Seams | None = None) -> SegmentArrays:
    """The arrays of `device_segments` with the segments where they belong, and their seams closed if there are any."""
    placed = SegmentArrays()
    for name in SegmentArrays.vars:  # type: ignore[attr-defined]
        setattr(placed, name, getattr(arrays, name))
    placed.origins = wp.array(segment_origins(setup).astype(np.float32), dtype=wp.vec3f, copy=False)
    for name in vars(seams) if seams else ():
        setattr(placed, name, getattr(seams, name))
    return placed


def no_seams(count: int, joints: int) -> Seams:
    """Seams without a jump for `count` segments."""
    return Seams(
        joint_values=wp.zeros((count + 1, joints), dtype=wp.vec3f),
        joint_slopes=wp.zeros((count + 1, joints), dtype=wp.vec3f),
        position_values=wp.zeros(count + 1, dtype=wp.vec3f),
        position_slopes=wp.zeros(count + 1, dtype=wp.vec3f),
    )


def pose_frames(setup: Setup, arrays: SegmentArrays, *, rows: IntArray, times: FloatArray, joints: IntArray) -> Poses:
    """Blended poses of segments `rows` (F,) at `times` [s] (F,), the `joints` given; feet not yet planted."""
    clock = times - setup.contacts.starts[setup.segments.agents[rows]]
    return blend_frames(setup.library, arrays, rows=rows, clock=clock, joints=joints)


def blend_frames(
    library: LibraryArrays, arrays: SegmentArrays, *, rows: IntArray, clock: FloatArray, joints: IntArray
) -> Poses:
    """Blended poses of segments `rows` (F,) at times on their agents' clocks [s] (F,), the `joints` given."""
    count = len(rows)
    poses = Poses(
        pelvis_positions=wp.empty(count, dtype=wp.vec3f),
        pelvis_rotations=wp.empty(count, dtype=wp.quatf),
        rotations=wp.empty((count, library.rotations.shape[2]), dtype=wp.quatf),
    )
    wp.launch(
        pose_bodies,
        dim=count,
        inputs=[
            library,
            arrays,
            wp.array(joints.astype(np.int32), dtype=wp.int32, copy=False),
            wp.array(rows.astype(np.int32), dtype=wp.int32, copy=False),
            wp.array(clock, dtype=wp.float64, copy=False),
        ],
        outputs=[poses.pelvis_positions, poses.pelvis_rotations, poses.rotations],
    )
    return poses
