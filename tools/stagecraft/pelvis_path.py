"""The path of the pelvis over footprints.

In the plane it passes midway between the feet at every change of feet and sways towards the foot that carries
(4 cm in all: Inman, Ralston and Todd, Human Walking, 1981). Its height is lowest in double support and highest in mid
stance when walking, by 3 to 5 cm at ordinary steps (Murray 1964; Gard, Miff and Kuo 2004); in a run it falls freely
in flight and is lowest in mid stance (Novacheck 1998, The biomechanics of running). All heights go down together
until both legs reach.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import Akima1DInterpolator
from scipy.ndimage import gaussian_filter1d

from stagecraft.footprints import Footprint
from stagecraft.rig import FootShape
from stagecraft.rotation import FloatArray

GRAVITY = 9.81
RATE = 240.0
"""Samples a second of every curve before it is cut into frames."""
STANDS_BEHIND, WALKS_AHEAD = 0.088, 0.036
"""Pelvis behind the midpoint of the balls when standing [m], and how far it comes forward in a step of 0.7 m."""
SWAY = 0.40
"""Part of the way from the path to the standing foot that the pelvis sways."""
EXCURSION = (0.010, 0.062, 0.8)
"""Rise of the pelvis in mid stance [m]: the first, plus the second [1/m] times the square of the step's length, which
counts up to the third [m]; 1.8 cm at 0.35 m, 4.1 cm at 0.71 m."""


@dataclass(frozen=True, kw_only=True)
class Exchange:
    """From one footprint to the next: double support, or flight."""

    before: Footprint
    after: Footprint

    @property
    def flight(self) -> bool:
        """No foot on the ground in between."""
        return self.before.liftoff < self.after.strike

    @property
    def middle(self) -> float:
        """Middle of the double support or the flight [s]."""
        return 0.5 * (self.before.liftoff + self.after.strike)

    def times(self) -> list[float]:
        """When the pelvis is midway between the feet [s]: once, or from settling to setting out when they stand."""
        if self.before.liftoff - self.after.strike < 0.5:
            return [self.middle]
        settled = self.after.strike + (0.3 if self.after.strike > self.before.strike else 0.0)
        return [settled, max(self.before.liftoff - 0.25, settled + 0.1)]


@dataclass(frozen=True, kw_only=True)
class Knot:
    """Height of the pelvis at an instant."""

    time: float
    height: float
    rate: float = 0.0
    bend: float | None = None
    """Vertical acceleration [m/s^2]; None: that of a cosine between this knot and its neighbours."""
    group: int
    """Knots of one group move together when the legs do not reach."""


def exchanges(prints: Sequence[Footprint]) -> list[Exchange]:
    """All changes of feet, in order."""
    return [Exchange(before=before, after=after) for before, after in itertools.pairwise(prints)]


def planar_path(prints: Sequence[Footprint], times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Place of the pelvis in the plane (x, z) [m], shape (T, 2), and heading of the body [rad], shape (T,).

    Args:
        prints: the footprints.
        times: evenly spaced, `RATE` a second.
    """
    changes = exchanges(prints)
    yaws = np.unwrap([print_.yaw for print_ in prints])
    keys, places, headings = [], [], []
    for number, change in enumerate(changes):
        heading = 0.5 * (yaws[number] + yaws[number + 1])
        middle = 0.5 * (change.before.position + change.after.position)[[0, 2]]
        forward = np.array([np.sin(heading), np.cos(heading)])
        step = float((change.after.position - change.before.position)[[0, 2]] @ forward)
        behind = STANDS_BEHIND - WALKS_AHEAD * np.clip(step / 0.7, 0.0, 1.0)
        for key in change.times():
            keys.append(key)
            places.append(middle - behind * forward)
            headings.append(heading)
    clipped = np.clip(times, keys[0], keys[-1])
    path = Akima1DInterpolator(keys, np.array(places), method="makima")(clipped)
    heading = Akima1DInterpolator(keys, np.array(headings), method="makima")(clipped)
    return smooth(path + _sway(prints, times, path), 0.045), smooth(heading, 0.06)


def height_knots(prints: Sequence[Footprint], standing_height: float) -> list[Knot]:
    """Knots of the pelvis height, not yet lowered to what the legs reach."""
    knots: list[Knot] = []
    changes = exchanges(prints)
    for number, change in enumerate(changes):
        ground = 0.5 * (change.before.position[1] + change.after.position[1])
        length = float(np.linalg.norm((change.after.position - change.before.position)[[0, 2]]))
        if knots and not change.flight and not changes[number - 1].flight:
            knots.append(_mid_stance(changes[number - 1], change, standing_height))
        height = ground + standing_height - 0.5 * _excursion(length)
        if change.flight:
            duration = change.after.strike - change.before.liftoff
            rate = 0.5 * GRAVITY * duration
            knots.append(Knot(time=change.before.liftoff, height=height, rate=rate, bend=-GRAVITY, group=number))
            knots.append(Knot(time=change.after.strike, height=height, rate=-rate, bend=-GRAVITY, group=number))
        else:
            knots += [Knot(time=time, height=height, group=number) for time in change.times()]
    return knots


def height_curve(knots: Sequence[Knot], times: FloatArray) -> FloatArray:
    """Height at `times` [m], shape (T,): a quintic between neighbouring knots, level outside."""
    when = np.array([knot.time for knot in knots])
    bends = [_bend(knots, number) for number in range(len(knots))]
    heights = np.where(times <= when[0], knots[0].height, knots[-1].height)
    for number, (here, there) in enumerate(itertools.pairwise(knots)):
        inside = (times >= here.time) & (times <= there.time)
        duration = there.time - here.time
        u = (times[inside] - here.time) / duration
        heights[inside] = (
            here.height * (1 - 10 * u**3 + 15 * u**4 - 6 * u**5)
            + here.rate * duration * (u - 6 * u**3 + 8 * u**4 - 3 * u**5)
            + bends[number] * duration**2 * (0.5 * u**2 - 1.5 * u**3 + 1.5 * u**4 - 0.5 * u**5)
            + there.height * (10 * u**3 - 15 * u**4 + 6 * u**5)
            + there.rate * duration * (-4 * u**3 + 7 * u**4 - 3 * u**5)
            + bends[number + 1] * duration**2 * (0.5 * u**3 - u**4 + 0.5 * u**5)
        )
    return heights


def lower(knots: Sequence[Knot], times: FloatArray, excess: FloatArray) -> list[Knot]:
    """The knots, each group lowered by the largest `excess` [m] of the curve near it, shape (T,)."""
    when = np.array([knot.time for knot in knots])
    nearest = np.abs(times[:, None] - when[None, :]).argmin(axis=1)
    worst = np.zeros(len(knots))
    np.maximum.at(worst, nearest, excess)
    groups: dict[int, float] = {}
    for knot, drop in zip(knots, worst, strict=True):
        groups[knot.group] = max(groups.get(knot.group, 0.0), float(drop))
    return [replace(knot, height=knot.height - groups[knot.group]) for knot in knots]


def allowed_height(ankle: FloatArray, hip_offset: FloatArray, pelvis: FloatArray, longest: FloatArray) -> FloatArray:
    """Greatest height of the pelvis [m] at which a leg of length `longest` reaches the ankle, shape (T,).

    Args:
        ankle: ankle in the world [m], shape (T, 3).
        hip_offset: hip from the pelvis in the world's axes [m], shape (T, 3).
        pelvis: pelvis, its x and z [m], shape (T, 2).
        longest: hip to ankle at most [m], shape (T,).
    """
    across = pelvis + hip_offset[:, [0, 2]] - ankle[:, [0, 2]]
    reach = np.maximum(longest**2 - np.sum(across**2, axis=1), 0.01)
    return ankle[:, 1] + np.sqrt(reach) - hip_offset[:, 1]


def smooth(curve: FloatArray, width: float) -> FloatArray:
    """`curve` (sampled at `RATE`) seen through a Gaussian of standard deviation `width` [s]."""
    return gaussian_filter1d(curve, width * RATE, axis=0, mode="nearest")


def standing_height(shape: FootShape, pelvis: float) -> float:
    """Height of the pelvis over the ground when walking upright [m]: a little above the rest pose."""
    return pelvis + 0.06 * shape.ball_height


def _mid_stance(before: Exchange, after: Exchange, standing: float) -> Knot:
    support = after.before
    travel = 0.5 * np.linalg.norm((after.after.position - before.before.position)[[0, 2]])
    low = 0.5 * (before.before.position[1] + after.after.position[1])
    ground = 0.5 * (low + support.position[1])
    height = ground + standing + 0.5 * _excursion(float(travel))
    times = (before.times()[-1], after.times()[0])
    return Knot(time=0.5 * (times[0] + times[1]), height=height, group=-1 - int(1000 * support.strike))


def _excursion(length: float) -> float:
    """How far the pelvis rises over the standing leg in a step of `length` [m]."""
    least, growth, longest = EXCURSION
    return least + growth * min(length, longest) ** 2


def _bend(knots: Sequence[Knot], number: int) -> float:
    """Acceleration at a knot: as authored, or the mean of the cosines to both neighbours."""
    if knots[number].bend is not None:
        return float(knots[number].bend or 0.0)
    bends = []
    for other in (number - 1, number + 1):
        if 0 <= other < len(knots):
            gap = knots[other].time - knots[number].time
            bends.append(0.5 * (knots[other].height - knots[number].height) * (np.pi / gap) ** 2)
    return float(np.mean(bends))


def _sway(prints: Sequence[Footprint], times: FloatArray, path: FloatArray) -> FloatArray:
    """Offset of the pelvis towards each standing foot, across its heading, shape (T, 2)."""
    offset = np.zeros_like(path)
    changes = exchanges(prints)
    for before, after in itertools.pairwise(changes):
        foot = after.before
        start, end = before.times()[-1], after.times()[0]
        middle = int(np.argmin(np.abs(times - 0.5 * (start + end))))
        across = np.array([np.cos(foot.yaw), -np.sin(foot.yaw)])
        away = float((foot.position[[0, 2]] - path[middle]) @ across)
        wave = np.sin(np.pi * np.clip((times - start) / (end - start), 0.0, 1.0))
        flight = 0.6 if before.flight or after.flight else 1.0
        offset += flight * SWAY * np.clip(away, -0.12, 0.12) * wave[:, None] * across
    return offset
