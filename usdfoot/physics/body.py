"""From the centre of mass to the whole body, for all agents of one character at any instants ([P] 2.5, 2.6)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp

from usdfoot.engine.feet import FLAT_SHARE, FLAT_TIME
from usdfoot.engine.pose_source import Layout, Poses
from usdfoot.maths import planar, quaternion
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import Biped
from usdfoot.model.contact_table import ContactTable
from usdfoot.physics.carriage import carried_offsets
from usdfoot.physics.heading import heading_of
from usdfoot.physics.kernels import GaitArrays, pose_legs, pose_upper_body
from usdfoot.physics.leg_kernel import BACKWARD
from usdfoot.physics.optimise import ComMotion, ComSample
from usdfoot.physics.pelvis import pelvis_sways
from usdfoot.physics.posture import Posture
from usdfoot.physics.rhythm import SIGNALS, Rhythm
from usdfoot.physics.style import BodyStyle
from usdfoot.physics.upper_body import UpperBody

__all__ = ["BodyPoses", "device_gait"]

HEEL_OFF = 0.5
"""Part of the time from flat to liftoff after which the heel rises: in the middle of the stance (Perry 1992)."""
RUN_HEEL_OFF = 0.449
"""Part of the contact after which it rises before a flight (De Cock et al. 2005)."""
LARGEST_LAUNCH = 3.0
"""At the speed of the liftoff a foot would turn by this many of the liftoff's pitch in the swing, at most."""
BALL_FIRST = 0.25
"""A foot that comes down ball first has its heel down after this part of the contact."""
FLIGHT_STRIKE = 0.25
"""After a flight the foot comes down flatter: this part of the strike's pitch."""


@dataclass(frozen=True, kw_only=True)
class BodyPoses:
    """Poses over an optimised centre of mass: a source for planting that needs no clips."""

    layout: Layout
    com: ComMotion
    upper: UpperBody
    gait: GaitArrays
    style: BodyStyle
    carriage: Posture | None = None
    """How the character carries its pelvis, where clips show it."""

    def pose(self, rows: IntArray, times: FloatArray, *, joints: IntArray) -> Poses:
        """Poses of segments `rows` (F,) at `times` [s] (F,); without joints above the legs their rhythm is left out."""
        layout = self.layout
        agents = layout.segments.agents[rows]
        sample = self.com.evaluate(agents, times)
        yaws = heading_of(sample.orientations)
        rhythm = self.com.rhythm(agents, times, yaws)
        turned = self._pelvis_turn(sample, rhythm, yaws)
        biped = self.com.biped
        offsets = pelvis_sways(biped, rhythm)
        if self.carriage is not None:
            offsets = offsets + carried_offsets(self.carriage.at(agents, times), rhythm)
        hung = quaternion.rotate(turned, biped.pelvis) + quaternion.rotate(sample.orientations, offsets)
        pelvis = sample.positions + hung
        rotations = quaternion.compose(turned, biped.pelvis_rotation)
        poses = Poses(
            pelvis_positions=wp.array((pelvis - layout.origins[agents]).astype(np.float32), dtype=wp.vec3f),
            pelvis_rotations=wp.array(rotations.astype(np.float32), dtype=wp.quatf),
            rotations=wp.empty((len(rows), len(layout.skeleton.joints)), dtype=wp.quatf),
        )
        whole = bool(np.setdiff1d(joints, layout.rig.leg_joints).size)
        signals = self._signals(agents, times, rhythm, yaws, sample) if whole else _still(len(rows), self.upper)
        self._launch(poses, agents, times, yaws, signals)
        return poses

    def _launch(self, poses: Poses, agents: IntArray, times: FloatArray, yaws: FloatArray, signals: FloatArray) -> None:
        layout, upper = self.layout, self.upper
        wp.launch(
            pose_upper_body,
            dim=poses.rotations.shape,
            inputs=[
                wp.array(upper.local.astype(np.float32), dtype=wp.quatf),
                wp.array(upper.in_body.astype(np.float32), dtype=wp.quatf),
                wp.array(upper.gains.astype(np.float32), dtype=wp.vec3f),
                wp.array(upper.lags.astype(np.int32), dtype=wp.int32),
                wp.array(signals.astype(np.float32), dtype=wp.float32),
            ],
            outputs=[poses.rotations],
        )
        latest = [self._latest(agents, times, side) for side in (0, 1)]
        wp.launch(
            pose_legs,
            dim=(len(agents), 2),
            inputs=[
                layout.rig.arrays,
                self.gait,
                wp.array(np.stack(latest, axis=1).astype(np.int32), dtype=wp.int32),
                wp.array((times - layout.contacts.starts[agents]).astype(np.float32), dtype=wp.float32),
                wp.array(yaws.astype(np.float32), dtype=wp.float32),
                poses.pelvis_positions,
                poses.pelvis_rotations,
                poses.rotations,
            ],
        )

    def _latest(self, agents: IntArray, times: FloatArray, side: int) -> IntArray:
        rows = self.com.foot_rows
        return rows.contacts[locate(rows.feet, rows.strikes, rows.origins, agents=2 * agents + side, times=times)]

    def _pelvis_turn(self, sample: ComSample, rhythm: Rhythm, yaws: FloatArray) -> FloatArray:
        """Body frame to world with its oscillations, shape (F, 4)."""
        style = self.style
        turn = np.stack(
            [
                style.pitch * rhythm.bob + style.lean * np.clip(self._froude(sample, yaws), -1.0, 2.0),
                -style.turn * rhythm.stride,
                style.sway * rhythm.lean,
            ],
            axis=1,
        )
        return quaternion.compose(sample.orientations, quaternion.from_rotation_vector(turn))

    def _froude(self, sample: ComSample, yaws: FloatArray) -> FloatArray:
        """Froude number of the speed ahead, negative backward, shape (F,)."""
        ahead = np.sum(sample.velocities[:, [0, 2]] * planar.direction(yaws), axis=1)
        return ahead * np.abs(ahead) / (self.com.options.gravity * self.com.biped.nominal_length)

    def _signals(
        self, agents: IntArray, times: FloatArray, rhythm: Rhythm, yaws: FloatArray, sample: ComSample
    ) -> FloatArray:
        """Signals of all joints, one row of them a lag, shape (F, lags, len(SIGNALS))."""
        signals = np.zeros((len(times), self.upper.lag_count, len(SIGNALS)))
        before = yaws
        for lag in range(self.upper.lag_count):
            if lag:
                earlier = times - lag * self.style.tail_lag
                sample = self.com.evaluate(agents, earlier)
                yaws = heading_of(sample.orientations)
                rhythm = self.com.rhythm(agents, earlier, yaws)
            columns = (rhythm.stride, rhythm.lean, rhythm.bob, planar.wrap_angle(yaws - before))
            haste = np.clip(self._froude(sample, yaws), 0.0, 1.0)
            for column, values in enumerate((*columns, sample.velocities[:, 1], haste)):
                signals[:, lag, column] = values
            before = yaws
        return signals


def _still(count: int, upper: UpperBody) -> FloatArray:
    return np.zeros((count, upper.lag_count, len(SIGNALS)))


def device_gait(layout: Layout, biped: Biped, style: BodyStyle) -> GaitArrays:
    """How the feet roll over their prints and swing between them, on the device."""
    contacts = layout.contacts
    clock = contacts.starts[contacts.agents]
    strikes, liftoffs, flats = _pitches(layout, biped, style)
    heights = np.asarray(biped.ball_heights)[contacts.sides] / contacts.normals[:, 1]
    balls = contacts.positions - layout.origins[contacts.agents]
    balls[:, 1] += heights
    ends = np.where(contacts.has_swing, contacts.liftoffs, np.inf)
    heel_offs = _heel_offs(contacts, flats)
    gait = GaitArrays()
    for name, values, kind in (
        ("balls", balls, wp.vec3f),
        ("yaws", contacts.yaws, wp.float32),
        ("strikes", contacts.strikes - clock, wp.float32),
        ("flats", flats - clock, wp.float32),
        ("heel_offs", heel_offs - clock, wp.float32),
        ("liftoffs", ends - clock, wp.float32),
        ("strike_pitches", strikes, wp.float32),
        ("liftoff_pitches", np.where(contacts.has_swing, liftoffs, 0.0), wp.float32),
        ("launches", _launches(contacts, heel_offs), wp.float32),
        ("retracted", _retractions(contacts, style) * biped.nominal_leg_length, wp.float32),
        ("flat_rotations", np.array([foot.flat_rotation for foot in layout.rig.feet]), wp.quatf),
    ):
        setattr(gait, name, wp.array(np.ascontiguousarray(values, dtype=np.float32), dtype=kind))
    gait.nominal = float(biped.nominal_leg_length)
    return gait


def _heel_offs(contacts: ContactTable, flats: FloatArray) -> FloatArray:
    """When the heels rise [s], shape (C,)."""
    walked = flats + HEEL_OFF * (contacts.liftoffs - flats)
    run = np.maximum(flats, contacts.strikes + RUN_HEEL_OFF * (contacts.liftoffs - contacts.strikes))
    return np.where(_flies(contacts), np.minimum(run, walked), walked)


def _flies(contacts: ContactTable) -> BoolArray:
    """Whether a flight follows each contact, shape (C,).

    After the last footstep of a plan that ends in mid gait, which may end before that foot would leave, as before it.
    """
    flies = contacts.has_next & (contacts.liftoffs < np.roll(contacts.strikes, -1))
    last = (contacts.steps >= 0) & contacts.has_next & (np.roll(contacts.steps, -1) < 0)
    return np.where(last, flies & np.roll(flies, 1), flies)


def _launches(contacts: ContactTable, heel_offs: FloatArray) -> FloatArray:
    """Speed at which the heel still rises at the liftoff, as a part of its mean speed since heel-off, shape (C,).

    It rises ever faster, as a parabola, unless the foot would then turn too far in the swing.
    """
    swings = np.where(contacts.has_swing, np.roll(contacts.strikes, -2) - contacts.liftoffs, 1.0)
    return np.minimum(2.0, LARGEST_LAUNCH * (contacts.liftoffs - heel_offs) / np.maximum(swings, 1e-4))


def _retractions(contacts: ContactTable, style: BodyStyle) -> FloatArray:
    """Length of the leg in the middle of the swing after each contact, as a part of the nominal one, shape (C,)."""
    flies = _flies(contacts)
    over = flies | (contacts.has_swing & np.roll(flies, -1))
    return np.where(over, style.run_retraction, style.retraction)


def _pitches(layout: Layout, biped: Biped, style: BodyStyle) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pitch of each contact's foot at its strike and liftoff [rad], and the time it is flat [s], shape (C,) each.

    Feet roll with the length of the step; feet without a heel and backward steps come down on the ball.
    """
    contacts, feet = layout.contacts, layout.rig.feet
    before = _steps_ahead(contacts, -1) / biped.maximal_leg_length
    after = _steps_ahead(contacts, 1) / biped.maximal_leg_length
    heel = np.array([foot.heel_behind > 0.0 for foot in feet])[contacts.sides]
    scale = np.where(before >= 0.0, np.minimum(before / 0.8, 1.2), np.maximum(before, -1.0) * BACKWARD)
    flown = contacts.has_previous & (np.roll(contacts.liftoffs, 1) < contacts.strikes)
    strikes = -style.strike_pitch * scale * np.where(flown, FLIGHT_STRIKE, 1.0)
    strikes = np.where(heel | (strikes > 0.0), strikes, 0.0)
    liftoffs = style.liftoff_pitch * np.clip(np.where(after >= 0.0, after / 0.8, -BACKWARD * after), 0.15, 1.2)
    durations = contacts.liftoffs - contacts.strikes
    rolls = np.where(strikes < 0.0, np.minimum(FLAT_TIME, FLAT_SHARE * durations), BALL_FIRST * durations)
    standing = ~contacts.has_previous | (np.roll(contacts.strikes, 1) == contacts.strikes)
    strikes = np.where(standing & (contacts.strikes <= contacts.starts[contacts.agents]), 0.0, strikes)
    return strikes, liftoffs, contacts.strikes + rolls


def _steps_ahead(contacts: ContactTable, offset: int) -> FloatArray:
    """How far ahead along the foot the step from the contact before (-1) or to the one after (+1) goes [m], (C,)."""
    index = np.arange(len(contacts.sides))
    known = contacts.has_previous if offset < 0 else contacts.has_next
    other = np.where(known, index + offset, index)
    step = (contacts.positions - contacts.positions[other])[:, [0, 2]] * -offset
    return np.sum(step * planar.direction(contacts.yaws), axis=1)
