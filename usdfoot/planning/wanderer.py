"""Wanderer: where one that wanders is, and its next footstep beside it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from usdfoot.analysis.timing import STAND_TIME, time_steps
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import LEFT
from usdfoot.planning.gait import Gait, derive_gait
from usdfoot.planning.prints import print_orientations, settle_on_treads
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.world import World

__all__ = ["SIDEWAYS", "Footstep", "WanderOptions", "Wanderer", "lay_footstep", "take_step"]

EASY_RISE = 0.42
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

    @cached_property
    def _gait(self) -> Gait:
        """Of steps straight ahead."""
        return derive_gait(self.body, speed=self.speed)

    @property
    def easy_step(self) -> float:
        """How far a step ahead leads at its speed [m]."""
        return self._gait.step_length

    @property
    def pace(self) -> float:
        """How fast easy steps lead ahead [m/s]."""
        return self._gait.speed

    @property
    def side_step(self) -> float:
        """How far a side step leads [m]."""
        return SIDE_STEP * self.body.leg_length


@dataclass(frozen=True, kw_only=True)
class Wanderer:
    """Where one that wanders is."""

    place: FloatArray
    """Middle of the feet (x, z) [m], shape (2,)."""
    height: float
    """Of the ground there [m]."""
    yaw: float
    side: int
    """Foot that stepped last."""
    spin: int = 0
    """Side to which it is turning out of a dead end, 1 = left, 0 = it is in none."""
    facing: float = 0.0
    """How far it looks to the right of where it goes, the left shoulder first [rad]."""

    @property
    def position(self) -> FloatArray:
        """Middle of the feet on the ground [m], shape (3,)."""
        return np.insert(self.place, 1, self.height)


def take_step(wanderer: Wanderer, length: float, turn: float, *, world: World, options: WanderOptions) -> Wanderer:
    """The wanderer after a step of the other foot."""
    yaw, shares = wanderer.yaw + turn, np.array([1.0, 0.75, 0.5, 0.25])
    places = wanderer.place + shares[:, None] * length * planar.direction(np.array(yaw))
    if world.ground is None:
        return Wanderer(place=places[0], height=wanderer.height, yaw=yaw, side=1 - wanderer.side)
    heights = world.ground.heights(places, np.full(len(places), wanderer.height), step_up=options.step).heights
    easy = np.abs(heights - wanderer.height) <= EASY_RISE * options.body.leg_length
    chosen = int(np.argmax(easy))  # onto a ledge, where none is, the whole step
    return Wanderer(place=places[chosen], height=float(heights[chosen]), yaw=yaw, side=1 - wanderer.side)


def lay_footstep(
    wanderer: Wanderer,
    side: int,
    world: World,
    *,
    options: WanderOptions,
    before: Footstep | None = None,
    time: float = 0.0,
) -> Footstep:
    """The footstep of one foot beside the wanderer's place; it strikes a step after the one before, else at `time`."""
    body, yaw = options.body, wanderer.yaw - wanderer.facing
    outward = 0.5 * np.pi if side == LEFT else -0.5 * np.pi
    closed_up = 2.0 * body.half_width + BETWEEN + options.side_step
    width = float(np.interp(np.sin(wanderer.facing), (0.0, 1.0), (body.step_width, closed_up)))
    point = wanderer.place + 0.5 * width * planar.direction(np.array(yaw + outward))
    height, normal = wanderer.height, np.array([[0.0, 1.0, 0.0]])
    if world.ground is not None:
        point = settle_on_treads(
            world.ground,
            point[None],
            np.array([yaw]),
            near=np.array([height]),
            heels=np.array([body.heel]),
            toes=np.array([body.toe]),
            half_widths=np.array([body.half_width]),
        )[0]
        sample = world.ground.heights(point[None], np.array([height]), step_up=options.step)
        if not (sample.walkable[0] and abs(sample.heights[0] - height) <= options.step):  # beside a ledge
            point = wanderer.place
            sample = world.ground.heights(point[None], np.array([height]), step_up=options.step)
        height, normal = float(sample.heights[0]), sample.normals
    position = np.array([point[0], height, point[1]])
    if before is not None:
        distance = np.linalg.norm(position - before.position)
        timing = time_steps(np.array([distance]), body.timing)
        time = before.strike_time + float(timing.step_times[0])
    return Footstep(
        side=side,
        position=position,
        orientation=print_orientations(np.array([yaw]), normal)[0],
        strike_time=time,
    )
