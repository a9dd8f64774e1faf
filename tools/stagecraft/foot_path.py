"""The path of one foot through its footprints: planted exactly, rolling heel to toe, swinging clear of the ground.

Contact: the heel's edge stays put from strike to flat, the ball joint from flat to liftoff while the heel rises after
heel-off (Perry, Gait Analysis, 1992: heel, ankle and forefoot rockers). Swing: the lowest point of the sole rises
from one print and comes down on the next with a clearance of 1.5 to 4 cm in between (Winter 1992, Foot trajectory in
human gait); the ball rides above it by what the pitch of the foot asks for.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from stagecraft.footprints import LEFT, Footprint
from stagecraft.rig import FootShape
from stagecraft.rotation import FloatArray, about_x, about_y, apply

TOUCH = 1e-4
"""Step of the finite difference at the end of a contact [s]."""

PASSING = 0.125
"""Distance between the ankles when one foot swings past the other [m]."""


@dataclass(frozen=True, kw_only=True)
class FootPath:
    """One foot over time."""

    ball: FloatArray
    """Ball joint [m], shape (T, 3)."""
    yaw: FloatArray
    """Heading [rad], shape (T,)."""
    pitch: FloatArray
    """Heel up [rad], shape (T,)."""
    toe_pitch: FloatArray
    """Pitch of the toes in the world [rad], shape (T,)."""
    load: FloatArray
    """1 in contact, 0 in the air, shape (T,)."""

    @property
    def rotation(self) -> FloatArray:
        """Foot to world, shape (T, 3, 3)."""
        return about_y(self.yaw) @ about_x(self.pitch)

    @property
    def toe_rotation(self) -> FloatArray:
        """Toes to world, shape (T, 3, 3)."""
        return about_y(self.yaw) @ about_x(self.toe_pitch)


def trace_foot(
    prints: Sequence[Footprint], others: Sequence[Footprint], times: FloatArray, shape: FootShape
) -> FootPath:
    """Path of one foot through its own footprints.

    Args:
        prints: this foot's footprints in order.
        others: the other foot's, to be passed at a distance.
        times: when [s], shape (T,); before the first strike and after the last liftoff the foot stays as then.
        shape: the foot.
    """
    ball, yaw = np.zeros((len(times), 3)), np.zeros(len(times))
    pitch, toe_pitch, load = np.zeros(len(times)), np.zeros(len(times)), np.zeros(len(times))
    edges = [print_.strike for print_ in prints]
    for number, here in enumerate(prints):
        low = -np.inf if number == 0 else edges[number]
        high = np.inf if number == len(prints) - 1 else here.liftoff
        inside = (times >= low) & (times <= high)
        when = np.clip(times[inside], here.strike, here.liftoff)
        pitch[inside] = contact_pitch(here, when)
        ball[inside] = _contact_ball(here, pitch[inside], shape)
        toe_pitch[inside], yaw[inside], load[inside] = np.minimum(pitch[inside], 0.0), here.yaw, 1.0
        if number + 1 < len(prints):
            there = prints[number + 1]
            swing = (times > here.liftoff) & (times < there.strike)
            phase = (times[swing] - here.liftoff) / (there.strike - here.liftoff)
            ball[swing], pitch[swing], toe_pitch[swing] = _swing(here, there, phase, shape)
            yaw[swing] = here.yaw + _wrap(there.yaw - here.yaw) * _smooth(phase)
            ball[swing] += np.sin(np.pi * phase)[:, None] ** 2 * _detour(here, there, others, shape)
    return FootPath(ball=ball, yaw=np.unwrap(yaw), pitch=pitch, toe_pitch=toe_pitch, load=load)


def contact_pitch(footprint: Footprint, times: FloatArray) -> FloatArray:
    """Pitch of the foot [rad] at `times` within its contact."""
    roll = footprint.roll
    settle = footprint.settle or min(0.16, 0.4 * (footprint.liftoff - footprint.strike))
    landing = np.clip((times - footprint.strike) / settle, 0.0, 1.0)
    start = footprint.flat + roll.heel_off * (footprint.liftoff - footprint.flat)
    leaving = np.clip((times - start) / max(footprint.liftoff - start, 1e-6), 0.0, 1.0)
    return roll.strike_pitch * (1.0 - landing) ** 2 * (1.0 + 2.0 * landing) + roll.liftoff_pitch * leaving**2.4


def sole_depth(pitch: FloatArray, toe_pitch: FloatArray, shape: FootShape) -> FloatArray:
    """How far the lowest point of heel and toes reaches below the sole under the ball joint [m] (at least 0)."""
    heel = -shape.heel_back * np.sin(pitch) - shape.ball_height * (1.0 - np.cos(pitch))
    toes = shape.toe_length * np.sin(toe_pitch) - shape.ball_height * (1.0 - np.cos(toe_pitch))
    return np.maximum(0.0, np.maximum(heel, toes))


def _contact_ball(footprint: Footprint, pitch: FloatArray, shape: FootShape) -> FloatArray:
    """Ball joint while the heel's edge (toes up) or the ball (heel up) stays on the footprint."""
    planted = footprint.position + [0.0, shape.ball_height, 0.0]
    heel_to_ball = np.array([0.0, shape.ball_height, shape.heel_back])
    forward = about_y(footprint.yaw)
    rolled = apply(forward @ about_x(np.minimum(pitch, 0.0)), heel_to_ball)
    return planted + rolled - forward @ heel_to_ball


def _swing(
    here: Footprint, there: Footprint, phase: FloatArray, shape: FootShape
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Ball, pitch and pitch of the toes over a swing at `phase` 0..1."""
    leave, land = contact_pitch(here, np.array([here.liftoff])), contact_pitch(there, np.array([there.strike]))
    duration = there.strike - here.liftoff
    pitch = _pitch_spline(here, leave, land, duration)(phase)
    planted = [_contact_ball(footprint, at, shape)[0] for footprint, at in ((here, leave), (there, land))]
    travel = (planted[1] - planted[0]) * [1.0, 0.0, 1.0]
    push = 2.0 * 16.0 * here.roll.clearance
    ball = planted[0] + travel * _reach(phase)[:, None]
    ground = here.position[1] + (there.position[1] - here.position[1]) * _smooth(phase)
    air = 0.5 * push * phase**2 * (1 - phase) ** 2 + here.roll.lift * _bump(phase)
    ends = [_rounded_depth(at, shape) - sole_depth(at, np.minimum(at, 0.0), shape) for at in (leave, land)]
    air -= ends[0] + (ends[1] - ends[0]) * _smooth(phase)
    ball[:, 1] = ground + shape.ball_height + _rounded_depth(pitch, shape) + air
    room = np.clip((ball[:, 1] - shape.ball_height - ground) / shape.toe_length, 0.0, 0.95)
    unbent = pitch * np.where(pitch > 0.0, _smooth(np.clip(phase / 0.45, 0.0, 1.0)), 1.0)
    return ball, pitch, np.minimum(unbent, np.arcsin(room))


def _detour(here: Footprint, there: Footprint, others: Sequence[Footprint], shape: FootShape) -> FloatArray:
    """How far the swinging foot moves out in the middle of the swing to pass the standing leg [m], shape (3,)."""
    heading = here.yaw + 0.5 * _wrap(there.yaw - here.yaw)
    outward = about_y(heading)[:, 0] * (1.0 if here.side == LEFT else -1.0)
    ahead = about_y(heading)[:, 2]
    phase = np.linspace(0.2, 0.8, 25)
    ankles = here.position + _reach(phase)[:, None] * (there.position - here.position) - shape.ankle_back * ahead
    times = here.liftoff + phase * (there.strike - here.liftoff)
    detour = 0.0
    for other in others:
        offset = ankles - (other.position - shape.ankle_back * about_y(other.yaw)[:, 2])
        near = (times >= other.strike) & (times <= other.liftoff) & (np.abs(offset @ ahead) < 0.22)
        short = PASSING - offset @ outward
        detour = max(detour, float(np.max((short / np.sin(np.pi * phase) ** 2)[near], initial=0.0)))
    return min(detour, 0.075) * outward


def _rounded_depth(pitch: FloatArray, shape: FootShape) -> FloatArray:
    """How far the heel reaches below the sole under the ball [m], without the kink at level feet."""
    heel = -shape.heel_back * np.sin(pitch) - shape.ball_height * (1.0 - np.cos(pitch))
    return 0.5 * (heel + np.sqrt(heel**2 + 0.02**2))


def _pitch_spline(here: Footprint, leave: FloatArray, land: FloatArray, duration: float) -> CubicSpline:
    """Pitch over the swing: heel up after the push, level in the middle, as at the strike in the end."""
    roll = here.roll
    knots = [0.0, 0.14, 0.56, 0.9, 1.0]
    values = [leave[0], roll.swing_pitch, roll.middle_pitch, land[0], land[0]]
    rate = (leave[0] - contact_pitch(here, np.array([here.liftoff - TOUCH]))[0]) / TOUCH
    rates = ((1, rate * duration), (1, 0.0))
    return CubicSpline(knots, values, bc_type=rates)


def _bump(phase: FloatArray) -> FloatArray:
    """A bump of height 1 whose top lies at 0.43 of the swing, with no slope at its ends."""
    return phase**2.2 * (1.0 - phase) ** 2.9 / (0.43137**2.2 * 0.56863**2.9)


def _smooth(phase: FloatArray) -> FloatArray:
    """Minimum-jerk ramp from 0 to 1."""
    return phase**3 * (10.0 + phase * (6.0 * phase - 15.0))


def _reach(phase: FloatArray) -> FloatArray:
    """Way of the swinging foot, 0 to 1: sets out gently and brakes late, as a foot about to strike does."""
    return _smooth(phase) + 1.0 * phase**2 * (1.0 - phase) ** 3 - 4.0 * phase**3 * (1.0 - phase) ** 2


def _wrap(angle: float) -> float:
    """The same angle in [-pi, pi)."""
    return float((angle + np.pi) % (2.0 * np.pi) - np.pi)


def feet_of(prints: Sequence[Footprint]) -> tuple[list[Footprint], list[Footprint]]:
    """The footprints of the left and of the right foot."""
    return ([print_ for print_ in prints if print_.side == LEFT], [print_ for print_ in prints if print_.side != LEFT])
