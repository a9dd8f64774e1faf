"""Feet: where the target's feet go so that they stand where the source's did."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from usdfoot.analysis.feet import heels_ahead
from usdfoot.analysis.motion import rest_leg_length
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.contacts import FootContacts
from usdfoot.retarget.frames import Frames
from usdfoot.retarget.poses import WorldPoses
from usdfoot.retarget.rig import Rig

__all__ = ["FootShape", "Sizes", "ball_goals", "hip_goals", "largest_slide", "measure_sizes"]

SIDES = (0, 1)
UP = np.array([0.0, 1.0, 0.0])
HIP_WIDTHS = 0.05
"""Hips narrower or wider than the source's by less, as a part of the leg, stand over feet as far apart."""


@dataclass(frozen=True, kw_only=True)
class FootShape:
    """A foot in its anatomical frame, +Y up and +Z along it when flat."""

    ball: FloatArray
    """Ball joint from the ankle [m], shape (3,)."""
    heel: FloatArray
    """The heel's point of the sole from the ankle [m], shape (3,)."""
    ball_height: float
    """Ball joint above the sole [m]."""

    @property
    def ankle_height(self) -> float:
        """Ankle joint above the sole [m]."""
        return self.ball_height - float(self.ball[1])


@dataclass(frozen=True, kw_only=True)
class Sizes:
    """How the source's lengths become the target's."""

    scales: FloatArray
    """Leg of the target over that of each clip, shape (C,)."""
    feet: tuple[FootShape, FootShape]
    """Of the target."""
    hip_rise: float
    """How much higher the target's ankles are than the source's in its size, and so its hips [m]."""
    hip_lag: float
    """How much farther its ankles are behind the balls, and so its hips [m]."""
    ball_rises: FloatArray
    """The same of the balls, shape (2,) [m]."""
    spread: float
    """How much farther out each foot stands than the source's in the target's size [m]."""


def measure_sizes(source: Rig, target: Rig, *, frames: tuple[Frames, Frames], poses: WorldPoses) -> Sizes:
    """Sizes of two rigs and of the source's clips, which may have proportions of their own."""
    own, leg = (rest_leg_length(rig.skeleton, rig.biped) for rig in (source, target))
    before, feet = _feet(source, frames[0]), _feet(target, frames[1])
    rises = [to.ankle_height - leg / own * at.ankle_height for at, to in zip(before, feet, strict=True)]
    lags = [to.ball[2] - leg / own * at.ball[2] for at, to in zip(before, feet, strict=True)]
    ball_rises = [to.ball_height - leg / own * at.ball_height for at, to in zip(before, feet, strict=True)]
    return Sizes(
        scales=np.array([leg / world.leg_length for world in poses.worlds]),
        feet=feet,
        hip_rise=float(np.mean(rises)),
        hip_lag=float(np.mean(lags)),
        ball_rises=np.array(ball_rises),
        spread=_spread(_hip_width(target) - leg / own * _hip_width(source), HIP_WIDTHS * leg),
    )


def _hip_width(rig: Rig) -> float:
    """From each hip to the middle of the body [m]."""
    return 0.5 * float(np.linalg.norm(rig.place(rig.biped.hips[0]) - rig.place(rig.biped.hips[1])))


def _spread(difference: float, negligible: float) -> float:
    """The difference less what is negligible, towards 0."""
    return float(np.sign(difference)) * max(abs(difference) - negligible, 0.0)


def _feet(rig: Rig, frames: Frames) -> tuple[FootShape, FootShape]:
    """Both feet of a rig in its own size."""
    shapes = []
    for side in SIDES:
        ankle, ball = rig.biped.ankles[side], rig.biped.balls[side]
        into = quaternion.inverse(quaternion.compose(rig.turn(ankle), frames[ankle]))
        across = quaternion.rotate(into, rig.place(ball) - rig.place(ankle))
        height = float(rig.biped.ball_heights[side])
        heel = np.array([0.0, across[1] - height, float(heels_ahead(across[2], -across[1], np.array(height)))])
        shapes.append(FootShape(ball=across, heel=heel, ball_height=height))
    return shapes[0], shapes[1]


def hip_goals(source: Rig, poses: WorldPoses, sizes: Sizes) -> FloatArray:
    """Where the middle between the target's hips has to be [m], shape (N, 3)."""
    scale = sizes.scales[poses.runs.owners][:, None]
    left = _outward(source, poses)[:, 0]
    ahead = np.stack([-left[:, 2], left[:, 1], left[:, 0]], axis=1)
    middle = poses.places[:, list(source.biped.hips)].mean(axis=1)
    return scale * middle + sizes.hip_rise * UP - sizes.hip_lag * ahead


def ball_goals(source: Rig, poses: WorldPoses, *, feet: FloatArray, sizes: Sizes, plant: bool) -> FloatArray:
    """Where the target's ball joints have to be [m], shape (N, 2, 3).

    Args:
        source: Rig of the clips.
        poses: The clips.
        feet: Anatomical frames of both feet in the world, shape (N, 2, 4).
        sizes: Of source and target.
        plant: Hold the balls where they stand.
    """
    scale = sizes.scales[poses.runs.owners][:, None, None]
    balls = scale * poses.places[:, list(source.biped.balls)] + sizes.ball_rises[:, None] * UP
    if not plant:
        return balls
    outward = sizes.spread * _outward(source, poses)
    balls += outward
    for world, own, size in zip(poses.worlds, poses.samples, sizes.scales, strict=True):
        times = world.clip.times
        for side in SIDES:
            contacts = world.contacts[side]
            middles = 0.5 * (np.maximum(contacts.flat_times, times[0]) + np.minimum(contacts.liftoff_times, times[-1]))
            places = size * contacts.positions + _points_at(times, outward[own, side], middles)
            scaled = replace(contacts, positions=places)
            balls[own, side] = _led(times, balls[own, side], feet[own, side], scaled, sizes.feet[side])
    return balls


def _outward(source: Rig, poses: WorldPoses) -> FloatArray:
    """Level unit vectors from the middle of the body to each side, shape (N, 2, 3)."""
    hips = poses.places[:, list(source.biped.hips)]
    left = (hips[:, 0] - hips[:, 1]) * np.array([1.0, 0.0, 1.0])
    left = left / np.maximum(np.linalg.norm(left, axis=1, keepdims=True), 1e-9)
    return np.stack([left, -left], axis=1)


def _led(
    times: FloatArray, balls: FloatArray, feet: FloatArray, contacts: FootContacts, shape: FootShape
) -> FloatArray:
    """Ball joint of one foot such that it stands still where it is planted and rolls about its heel before, (T, 3).

    In the air it goes along its path, led from one contact to the next.

    Args:
        times: Of the samples [s], shape (T,).
        balls: The source's path in the target's size [m], shape (T, 3).
        feet: Anatomical frame of the foot in the world, shape (T, 4).
        contacts: Of the foot, positions in the target's size.
        shape: The foot.
    """
    last = len(contacts.strike_times) - 1
    if last < 0:
        return balls
    planted = contacts.positions + shape.ball_height * UP  # (K, 3)
    from_heel = shape.ball - shape.heel
    heels = planted - quaternion.rotate(_turns_at(times, feet, contacts.flat_times), from_heel)
    landing = heels + quaternion.rotate(_turns_at(times, feet, contacts.strike_times), from_heel)
    landing -= _points_at(times, balls, contacts.strike_times)
    leaving = planted - _points_at(times, balls, contacts.liftoff_times)
    index = np.searchsorted(contacts.strike_times, times, side="right") - 1
    before, after = np.maximum(index, 0), np.minimum(index + 1, last)
    start, end = contacts.liftoff_times[before], contacts.strike_times[after]
    swing = (index >= 0) & (index < last) & (times > start)
    fraction = np.zeros(len(times))
    fraction[swing] = (times - start)[swing] / (end[swing] - start[swing])
    share = _eased(fraction)[:, None]
    offsets = leaving[before] * (1.0 - share) + landing[after] * share
    led = balls + np.where((index < 0)[:, None], landing[0], offsets)
    stands = (index >= 0) & (times <= start)
    led[stands] = planted[before[stands]]
    rolls = stands & (times < contacts.flat_times[before])
    led[rolls] = heels[before[rolls]] + quaternion.rotate(feet[rolls], from_heel)
    return led


def _eased(fraction: FloatArray) -> FloatArray:
    """Rises from 0 to 1 over 0..1 without velocity or acceleration at the ends."""
    return fraction**3 * (10.0 + fraction * (6.0 * fraction - 15.0))


def _points_at(times: FloatArray, points: FloatArray, wanted: FloatArray) -> FloatArray:
    """Points (T, 3) at wanted times (K,), held before the first and after the last sample."""
    return np.stack([np.interp(wanted, times, column) for column in points.T], axis=1)


def _turns_at(times: FloatArray, turns: FloatArray, wanted: FloatArray) -> FloatArray:
    """Rotations (T, 4) at wanted times (K,)."""
    signed = quaternion.continuous(turns)
    return quaternion.normalised(np.stack([np.interp(wanted, times, column) for column in signed.T], axis=1))


def largest_slide(times: FloatArray, balls: FloatArray, contacts: FootContacts) -> float:
    """At least the largest distance between two positions of the ball (T, 3) in one planted interval [m].

    It is the diagonal of the box around them; 0 where the foot is never planted.
    """
    slides = [0.0]
    for flat, liftoff in zip(contacts.flat_times, contacts.liftoff_times, strict=True):
        places = balls[(times >= flat) & (times <= liftoff)]
        slides.append(float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0)
    return max(slides)
