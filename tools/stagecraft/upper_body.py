"""Pelvis, trunk, head and arms, as curves of what the feet do."""

from dataclasses import dataclass, fields

import numpy as np

from stagecraft.foot_path import FootPath
from stagecraft.pelvis_path import GRAVITY, RATE, smooth
from stagecraft.rig import ARM_ANGLE
from stagecraft.rotation import FloatArray, about_axis, about_x, about_y, about_z, between

DEGREE = np.pi / 180.0


@dataclass(frozen=True, kw_only=True)
class Signals:
    """What the upper body answers to; every array of shape (T,)."""

    heading: FloatArray
    """Heading of the body [rad]."""
    ahead_heading: FloatArray
    """Heading a third of a second later [rad]: where the eyes look."""
    separation: FloatArray
    """Left foot before the right one [m]."""
    balance: FloatArray
    """1 left foot carries, -1 right foot carries."""
    speed: FloatArray
    """Forward [m/s]."""
    pace: FloatArray
    """In any direction [m/s]."""
    gain: FloatArray
    """Forward acceleration [m/s^2]."""
    bank: FloatArray
    """Lean into the turn, to the left [rad]."""
    running: FloatArray
    """0 walking, 1 running."""
    breath: FloatArray
    """Wave of breathing, -1..1."""

    @classmethod
    def measure(
        cls,
        planar: FloatArray,
        heading: FloatArray,
        *,
        feet: list[FootPath],
        ankles: list[FloatArray],
        running: FloatArray,
        breath: float,
        times: FloatArray,
    ) -> "Signals":
        """Signals of a body on the path `planar`, shape (T, 2), above feet with `ankles`, shape (T, 3) each."""
        forward = np.stack([np.sin(heading), np.cos(heading)], axis=1)
        velocity = np.gradient(planar, axis=0) * RATE
        slow_velocity = smooth(velocity, 0.22)
        speed = np.sum(slow_velocity * forward, axis=1)
        turning = smooth(np.gradient(heading) * RATE, 0.2)
        apart = np.sum((ankles[0] - ankles[1])[:, [0, 2]] * forward, axis=1)
        return cls(
            heading=heading,
            ahead_heading=np.interp(times + 0.33, times, smooth(heading, 0.12)),
            separation=smooth(apart, 0.05),
            balance=smooth(feet[0].load - feet[1].load, 0.055),
            speed=speed,
            pace=np.linalg.norm(slow_velocity, axis=1),
            gain=smooth(np.gradient(speed) * RATE, 0.1),
            bank=0.7 * np.arctan(speed * turning / GRAVITY),
            running=running,
            breath=breath * np.sin(2.0 * np.pi * times / 4.0),
        )


def pelvis_rotation(signals: Signals) -> FloatArray:
    """Pelvis to world, shape (T, 3, 3): turned with the leading leg, listed to the swing side, tilted forward."""
    turn = -np.clip(8.5 * DEGREE * signals.separation, -9.0 * DEGREE, 9.0 * DEGREE)
    effort = np.clip(0.35 + 0.5 * signals.pace, 0.0, 1.0)
    list_ = 4.6 * DEGREE * effort * signals.balance - 0.4 * signals.bank
    tilt = _lean(signals) * 0.5
    return about_y(signals.heading + turn) @ about_z(list_) @ about_x(tilt)


def torso_rotations(signals: Signals, pelvis: FloatArray) -> dict[str, FloatArray]:
    """Spine, chest, neck and head to world, shape (T, 3, 3) each."""
    against = np.clip(9.0 * DEGREE * signals.separation, -10.0 * DEGREE, 10.0 * DEGREE)
    chest = (
        about_y(signals.heading + against * (1.0 + 0.4 * signals.running))
        @ about_z(-1.0 * DEGREE * signals.balance - signals.bank)
        @ about_x(_lean(signals) + 0.9 * DEGREE * signals.breath)
    )
    gaze = signals.heading + np.clip(signals.ahead_heading - signals.heading, -0.5, 0.5)
    head = about_y(gaze) @ about_z(-0.3 * signals.bank) @ about_x(0.25 * _lean(signals) + 4.0 * DEGREE)
    return {
        "Spine": pelvis @ between(pelvis, chest, 0.30),
        "Spine1": pelvis @ between(pelvis, chest, 0.65),
        "Chest": chest,
        "Neck": chest @ between(chest, head, 0.45),
        "Head": head,
    }


def arm_rotations(signals: Signals, chest: FloatArray, side: str) -> dict[str, FloatArray]:
    """Clavicle to fingers of one arm to world, shape (T, 3, 3) each."""
    sign = 1.0 if side == "Left" else -1.0
    run = signals.running
    # The left arm comes forward with the right leg; it follows the leg by some 30 ms.
    drive = np.tanh(-sign * _late(signals.separation, 0.03) / 0.75) * 0.75
    swing = (-4.0 + 9.0 * run) * DEGREE + (26.0 + 22.0 * run) * DEGREE * drive - 0.5 * _lean(signals)
    bent = (14.0 + 58.0 * run + 3.0 * np.clip(signals.pace, 0.0, 2.0)) * DEGREE
    elbow = bent + (13.0 - 5.0 * run) * DEGREE * np.clip(1.0 + drive / 0.35, 0.0, 3.0) * np.clip(signals.pace, 0, 1)
    beside = (9.0 + 6.0 * run) * DEGREE
    inward = (8.0 + 10.0 * run) * DEGREE + 10.0 * DEGREE * np.clip(drive, 0.0, 1.0)
    along = np.array([sign * np.sin(ARM_ANGLE), -np.cos(ARM_ANGLE), 0.0])
    hinge = np.array([np.cos(ARM_ANGLE), sign * np.sin(ARM_ANGLE), 0.0])
    clavicle = chest @ about_y(sign * 0.10 * -swing) @ about_z(sign * 1.5 * DEGREE * (run - signals.breath))
    upper = clavicle @ about_x(-swing) @ about_z(-sign * (ARM_ANGLE - beside)) @ about_axis(along, sign * inward)
    fore = upper @ about_axis(hinge, -elbow)
    hand = (
        fore
        @ about_axis(along, sign * (12.0 + 25.0 * run) * DEGREE)
        @ about_z(-sign * 5.0 * DEGREE * np.ones_like(run))
    )
    fingers = hand @ about_z(-sign * (22.0 + 40.0 * run) * DEGREE)
    return {
        f"{side}Shoulder": clavicle,
        f"{side}Arm": upper,
        f"{side}ForeArm": fore,
        f"{side}Hand": hand,
        f"{side}Fingers": fingers,
    }


def resting_arms() -> dict[str, FloatArray]:
    """Both arms hanging at rest beside an upright trunk, one sample: shape (1, 3, 3) each."""
    still = Signals(**{field.name: np.zeros(1) for field in fields(Signals)})
    upright = np.eye(3)[None]
    return arm_rotations(still, upright, "Left") | arm_rotations(still, upright, "Right")


def _lean(signals: Signals) -> FloatArray:
    """Forward lean of the trunk [rad]: 2 degrees in a slow walk, 9 in a run (Novacheck 1998), more when speeding up."""
    steady = (
        1.0 + 1.3 * np.clip(signals.speed, -0.8, 2.0) + (2.0 + 1.3 * np.clip(signals.speed, 0.0, 5.0)) * signals.running
    )
    return DEGREE * (steady + 2.5 * np.clip(signals.gain, -1.6, 2.5))


def _late(curve: FloatArray, delay: float) -> FloatArray:
    """`curve` later by `delay` [s], a little smoother."""
    shifted = np.concatenate([np.full(round(delay * RATE), curve[0]), curve])[: len(curve)]
    return smooth(shifted, 0.04)
