"""Wanderers: where they are, and the next footstep of each beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np

from usdfoot.analysis.timing import STAND_TIME, time_steps
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.biped import LEFT
from usdfoot.model.ground import Ground
from usdfoot.planning.gait import derive_gait
from usdfoot.planning.prints import print_orientations, settle_on_treads
from usdfoot.planning.proportions import Proportions

__all__ = [
    "SIDEWAYS",
    "Footstep",
    "Footsteps",
    "WanderOptions",
    "Wanderers",
    "concatenated",
    "follow_feet",
    "joined",
    "lay_footsteps",
    "rows_of",
    "set_out",
    "take_steps",
]

EASY_RISE = 0.25
"""Rise of a step over the leg length above which it is shorter."""
SIDE_STEP = 0.15
"""How far a side step leads, over the leg length."""
SIDEWAYS = 0.5 * np.pi
"""How far shoulders turn in side steps [rad]."""
BETWEEN = 0.01
"""Between the feet when one closes up to the other in side steps [m]."""


@dataclass(frozen=True, kw_only=True)
class Footstep:
    """One planned footstep; the foot lifts off once the next steps are known (`join_footsteps`)."""

    side: int
    """0 = left, 1 = right."""
    position: FloatArray
    """Ground under the ball [m], shape (3,)."""
    orientation: FloatArray
    """Turns +Z into the foot's forward and +Y into the ground's normal, xyzw, shape (4,)."""
    strike_time: float
    """[s]"""


@dataclass(frozen=True, kw_only=True)
class WanderOptions:
    """How one wanders."""

    body: Proportions = field(default_factory=Proportions)
    speed: float = 0.0
    """Straight ahead [m/s], with the steps people take at it; shorter steps are slower. 0 = as easy steps are."""
    stand_time: float = STAND_TIME
    """How long it stands before its first step [s]."""
    radius: float = 0.3
    """Kept free around the middle of the feet [m]."""
    look_ahead: float = 2.0
    """Free way wanted ahead [m] ([P]'s fixed tolerance is `radius`)."""
    wobble: float = 0.15
    """Standard deviation of the change of direction from step to step without a goal [rad]."""
    turn: float = np.radians(40.0)
    """Largest change of direction in a step [rad]."""
    step: float = 0.35
    """Highest rise or drop of the ground [m]."""
    arrival: float = 0.3
    """A goal is reached at this distance [m]."""

    @property
    def side_step(self) -> float:
        """How far a side step leads [m]."""
        return SIDE_STEP * self.body.leg_length


@dataclass(frozen=True, kw_only=True)
class Footsteps:
    """One footstep of each of N that wander; fields as those of `Footstep`."""

    sides: IntArray
    positions: FloatArray
    orientations: FloatArray
    strike_times: FloatArray

    def of(self, row: int) -> Footstep:
        """That of one of them."""
        return Footstep(
            side=int(self.sides[row]),
            position=self.positions[row],
            orientation=self.orientations[row],
            strike_time=float(self.strike_times[row]),
        )


@dataclass(frozen=True, kw_only=True)
class Wanderers:
    """Where N that wander are."""

    places: FloatArray
    """Middles of the feet (x, z) [m], shape (N, 2)."""
    heights: FloatArray
    """Of the ground there [m], shape (N,)."""
    yaws: FloatArray
    """[rad], shape (N,)."""
    sides: IntArray
    """Foot that stepped last, shape (N,)."""
    spins: IntArray
    """Side to which each is turning out of a dead end, 1 = left, 0 = it is in none, shape (N,)."""
    facings: FloatArray
    """How far each looks to the right of where it goes, the left shoulder first [rad], shape (N,)."""
    easy_steps: FloatArray
    """How far a step ahead leads at its speed [m], shape (N,)."""
    paces: FloatArray
    """How fast easy steps lead ahead [m/s], shape (N,)."""

    @property
    def positions(self) -> FloatArray:
        """Middles of the feet on the ground [m], shape (N, 3)."""
        return np.insert(self.places, 1, self.heights, axis=1)

    def __len__(self) -> int:
        return len(self.places)


Table = TypeVar("Table", Footsteps, Wanderers)


def set_out(starts: FloatArray, yaws: FloatArray, speeds: FloatArray, *, options: WanderOptions) -> Wanderers:
    """Those who begin between the feet at starts (N, 3), look along yaws (N,) and walk at speeds (N,) [m/s]."""
    asked, own = np.unique(speeds, return_inverse=True)
    gaits = [derive_gait(options.body, speed=float(speed)) for speed in asked]
    count = len(starts)
    return Wanderers(
        places=starts[:, [0, 2]],
        heights=starts[:, 1],
        yaws=yaws,
        sides=np.full(count, LEFT),
        spins=np.zeros(count, dtype=int),
        facings=np.zeros(count),
        easy_steps=np.array([gait.step_length for gait in gaits])[own],
        paces=np.array([gait.speed for gait in gaits])[own],
    )


def take_steps(
    wanderers: Wanderers, lengths: FloatArray, turns: FloatArray, *, ground: Ground | None, options: WanderOptions
) -> Wanderers:
    """Those that wander after a step of the other foot of each, no longer in a dead end."""
    count, shares = len(wanderers), np.array([1.0, 0.75, 0.5, 0.25])
    yaws = wanderers.yaws + turns
    places = wanderers.places[:, None] + (shares * lengths[:, None])[..., None] * planar.direction(yaws)[:, None]
    heights = np.repeat(wanderers.heights[:, None], len(shares), axis=1)  # (N, 4)
    chosen = np.zeros(count, dtype=int)
    if ground is not None:
        near = heights.ravel()
        sample = ground.heights(places.reshape(-1, 2), near, step_up=options.step)
        heights = np.where(sample.hit, sample.heights, near).reshape(heights.shape)
        easy = np.abs(heights - wanderers.heights[:, None]) <= EASY_RISE * options.body.leg_length
        chosen = np.argmax(easy, axis=1)  # onto a ledge, where none is, the whole step
    rows = np.arange(count)
    return replace(
        wanderers,
        places=places[rows, chosen],
        heights=heights[rows, chosen],
        yaws=yaws,
        sides=1 - wanderers.sides,
        spins=np.zeros(count, dtype=int),
    )


def lay_footsteps(
    wanderers: Wanderers,
    sides: IntArray,
    *,
    ground: Ground | None,
    options: WanderOptions,
    before: Footsteps | None = None,
    time: float = 0.0,
) -> Footsteps:
    """The footsteps of one foot of each beside its place; they strike a step after those before, else at a time [s]."""
    body, yaws, count = options.body, wanderers.yaws - wanderers.facings, len(wanderers)
    points = _beside(wanderers, sides, options)
    heights, normals = wanderers.heights, np.tile([0.0, 1.0, 0.0], (count, 1))
    if ground is not None:
        heels, toes, half_widths = (np.full(count, size) for size in (body.heel, body.toe, body.half_width))
        near = wanderers.heights
        points = settle_on_treads(ground, points, yaws, near=near, heels=heels, toes=toes, half_widths=half_widths)
        sample = ground.heights(points, near, step_up=options.step)
        beside = ~(sample.walkable & (np.abs(sample.heights - near) <= options.step))  # a ledge
        if beside.any():
            points = np.where(beside[:, None], wanderers.places, points)
            sample = ground.heights(points, near, step_up=options.step)
        heights, normals = np.where(sample.hit, sample.heights, near), sample.normals
    positions = np.stack([points[:, 0], heights, points[:, 1]], axis=1)
    if before is None:
        times = np.full(count, time)
    else:
        distances = np.sqrt(np.sum((positions - before.positions) ** 2, axis=1))
        times = before.strike_times + time_steps(distances, body.timing).step_times
    return Footsteps(
        sides=sides,
        positions=positions,
        orientations=print_orientations(yaws, normals),
        strike_times=times,
    )


def follow_feet(wanderers: Wanderers, footsteps: Footsteps, *, options: WanderOptions) -> Wanderers:
    """Those that wander, each as far along its way and as high as the footstep it has taken."""
    forward = planar.direction(wanderers.yaws)
    apart = footsteps.positions[:, [0, 2]] - _beside(wanderers, footsteps.sides, options)
    places = wanderers.places + np.sum(apart * forward, axis=1, keepdims=True) * forward
    return replace(wanderers, places=places, heights=footsteps.positions[:, 1])


def _beside(wanderers: Wanderers, sides: IntArray, options: WanderOptions) -> FloatArray:
    """Where one foot of each stands beside its place (x, z) [m], shape (N, 2)."""
    body, yaws = options.body, wanderers.yaws - wanderers.facings
    outward = np.where(sides == LEFT, 0.5 * np.pi, -0.5 * np.pi)
    closed_up = 2.0 * body.half_width + BETWEEN + options.side_step
    widths = np.interp(np.sin(wanderers.facings), (0.0, 1.0), (body.step_width, closed_up))
    return np.asarray(wanderers.places + 0.5 * widths[:, None] * planar.direction(yaws + outward))


def rows_of(table: Table, rows: IntArray | BoolArray) -> Table:
    """Some rows of a table."""
    return replace(table, **{name: values[rows] for name, values in vars(table).items()})


def concatenated(parts: Sequence[Table]) -> Table:
    """The rows of all parts, one after the other."""
    columns = {name: np.concatenate([vars(part)[name] for part in parts]) for name in vars(parts[0])}
    return replace(parts[0], **columns)


def joined(parts: Sequence[Table], rows: Sequence[IntArray]) -> Table:
    """The table of which each part holds some rows, all parts all of them."""
    return parts[0] if len(parts) == 1 else rows_of(concatenated(parts), np.argsort(np.concatenate(rows)))
