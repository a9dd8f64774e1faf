"""Facing: people in a jam keep looking where they get to, and turn when they really go somewhere else."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.planning.facing import STAND, TURN, TURN_RATE, face_tracks

TIME_STEP = 0.1
LEG = 0.86


def looks(points: FloatArray, yaw: float = np.nan) -> FloatArray:
    """Where somebody looks along a track (T, 2), without the stand and the turn before it [rad], shape (T,)."""
    (faced,) = face_tracks(
        points[:, None],
        time_step=TIME_STEP,
        yaws=np.array([yaw]),
        heights=np.zeros((len(points), 1)),
        turned=np.zeros((len(points), 1)),
        legs=np.array([LEG]),
        names=["one"],
    )
    assert faced.yaws is not None
    first = round(STAND / TIME_STEP) + round(TURN / TIME_STEP)
    return faced.yaws[first : first + len(points)]


def track(*legs: tuple[float, float, float]) -> FloatArray:
    """A track of so many seconds at velocities (x, z) [m/s] one after the other, shape (T, 2)."""
    velocities = np.concatenate([np.tile(leg[1:], (round(leg[0] / TIME_STEP), 1)) for leg in legs])
    return np.asarray(np.cumsum(TIME_STEP * velocities, axis=0))


def away(yaws: FloatArray, yaw: float) -> FloatArray:
    """How far directions are from another one [degrees]."""
    return np.degrees(np.abs(planar.wrap_angle(yaws - yaw)))


def test_who_walks_looks_where_it_goes():
    yaws = looks(track((8.0, 0.0, 1.3), (8.0, 1.3, 0.0)))
    assert away(yaws[:60], 0.0).max() < 10.0
    assert away(yaws[-60:], 0.5 * np.pi).max() < 10.0


def test_who_is_pushed_to_and_fro_in_a_jam_keeps_looking_where_it_wants_to_go():
    jam = [(1.5, 0.1 * (-1.0) ** push, 0.12 * (-1.0) ** (push // 2)) for push in range(20)]
    points = track((5.0, 0.0, 1.3), *jam, (5.0, 0.0, 1.3))
    assert away(looks(points), 0.0).max() < 30.0


def test_who_is_pushed_back_slowly_steps_back():
    points = track((5.0, 0.0, 1.3), (6.0, 0.0, -0.1), (4.0, 0.0, 0.0), (6.0, 0.0, 1.0))
    assert away(looks(points), 0.0).max() < 30.0


def test_who_steps_aside_for_somebody_and_back_does_not_turn_its_back_on_the_way():
    points = track((5.0, 0.0, 1.3), (1.0, 0.5, 0.0), (3.0, 0.0, 0.0), (1.0, -0.5, 0.0), (5.0, 0.0, 1.3))
    assert away(looks(points), 0.0).max() < 60.0


def test_who_goes_back_turns_round_no_faster_than_people_do():
    yaws = looks(track((6.0, 0.0, 1.3), (6.0, 0.0, -1.3)))
    assert away(yaws[:40], 0.0).max() < 10.0
    assert away(yaws[-40:], np.pi).max() < 10.0
    assert np.abs(np.diff(yaws)).max() <= TURN_RATE * TIME_STEP + 1e-9


def test_who_stands_looks_as_at_first():
    assert_allclose(looks(np.full((50, 2), 3.0), yaw=1.0), 1.0, atol=1e-9)
    assert np.isfinite(looks(np.full((50, 2), 3.0))).all()


def test_ways_turned_about_are_looked_along_so():
    points = track((5.0, 0.2, 1.3), (4.0, -0.05, -0.1), (5.0, 1.0, 0.5))
    turned = planar.rotate(np.full(len(points), 0.7), points)
    assert_allclose(looks(turned), looks(points) + 0.7, atol=1e-9)
