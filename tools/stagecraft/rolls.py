"""How the foot rolls, by gait: after Perry (1992) and Winter (1992) in walking, Novacheck (1998) in running."""

import numpy as np

from stagecraft.footprints import Roll

DEGREE = np.pi / 180.0


def walk_roll(length: float, *, lift: float = 0.04) -> Roll:
    """Walking forward with steps of `length` [m]: heel first, off over the toes, more of both in longer steps."""
    size = float(np.clip(length / 0.7, 0.15, 1.35))
    push = (8.0 + 39.0 * size) * DEGREE
    return Roll(
        strike_pitch=-(3.0 + 16.0 * min(size, 1.15)) * DEGREE,
        heel_off=0.40 - 0.10 * size,
        liftoff_pitch=push,
        swing_pitch=push + 7.0 * DEGREE,
        middle_pitch=(2.0 + 8.0 * size) * DEGREE,
        clearance=0.030,
        lift=lift,
    )


def run_roll(speed: float) -> Roll:
    """Running at `speed` [m/s]: heel first up to 3.5 m/s, then the whole foot; the heel comes up high behind."""
    heel_first = speed < 3.5
    return Roll(
        strike_pitch=-9.0 * DEGREE if heel_first else 0.0,
        settle=0.06,
        heel_off=0.35,
        liftoff_pitch=(40.0 + 3.0 * speed) * DEGREE,
        swing_pitch=(52.0 + 9.0 * speed) * DEGREE,
        middle_pitch=(14.0 + 7.0 * speed) * DEGREE,
        clearance=0.045,
        lift=0.035 * speed,
    )


def side_roll(travel: float, *, lift: float = 0.02) -> Roll:
    """Stepping to the side or on the spot: ball and heel come down together; `travel` of the foot [m]."""
    push = (9.0 + 16.0 * min(travel, 0.8)) * DEGREE
    return Roll(
        strike_pitch=4.0 * DEGREE,
        heel_off=0.6,
        liftoff_pitch=push,
        swing_pitch=push + 2.0 * DEGREE,
        middle_pitch=5.0 * DEGREE,
        clearance=0.032,
        lift=lift,
    )


def back_roll(length: float) -> Roll:
    """Walking backward: the ball comes first, the ball leaves first (Winter, Pluck and Yang 1989)."""
    size = float(np.clip(length / 0.5, 0.3, 1.2))
    return Roll(
        strike_pitch=(10.0 + 10.0 * size) * DEGREE,
        heel_off=0.9,
        liftoff_pitch=0.0,
        swing_pitch=-9.0 * size * DEGREE,
        middle_pitch=3.0 * DEGREE,
        clearance=0.034,
        lift=0.02,
    )


def step_roll(forward: float, left: float, speed: float = 0.0, *, flight: bool = False) -> Roll:
    """The roll that suits a step of the body `forward` and `left` [m]."""
    if flight:
        return run_roll(speed)
    if forward < -0.08 and abs(left) < 1.2 * abs(forward):
        return back_roll(-forward)
    if forward > 0.12 and abs(left) < forward:
        return walk_roll(forward)
    return side_roll(2.0 * float(np.hypot(forward, left)))
