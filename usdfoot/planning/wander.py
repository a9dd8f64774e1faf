"""Wandering: one footstep at a time through a world that may change, at random or towards goals ([P] 4.2)."""

from __future__ import annotations

from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice

import numpy as np

from usdfoot.analysis.timing import TimingRule, time_footsteps, time_steps
from usdfoot.errors import PlanError
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import LEFT, RIGHT
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.prints import print_orientations, settle_on_treads
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.routes import Route, aim_along, find_route
from usdfoot.planning.spots import HEADROOM, STEEPEST
from usdfoot.planning.world import World, clearances, is_clear

__all__ = ["Footstep", "WanderOptions", "join_footsteps", "plan_wander", "wander"]

EASY_STEP = 0.8
"""Length of an easy walking step over the leg length."""
EASY_RISE = 0.42
"""Rise of a step over the leg length above which it is shorter."""
SLOPE = 8
"""Samples of the way ahead between which the ground may not rise more than a slope and half a step."""
SHOULDERS = 1.2
"""Who comes so near [m] to where it is narrower than its body turns the left shoulder first."""
SIDEWAYS = 0.5 * np.pi
"""How far shoulders turn in side steps [rad]."""
SIDE_STEP = 0.15
"""How far a side step leads, over the leg length."""
BETWEEN = 0.01
"""Between the feet when one closes up to the other in side steps [m]."""
DRAWS = 24
"""Directions tried when the one wanted leads too close to something."""


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
    """Mean of all steps [m/s]; 0 = as fast as such steps are."""
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


def wander(
    world: World,
    start: FloatArray,
    yaw: float,
    *,
    generator: np.random.Generator,
    goals: Sequence[FloatArray] = (),
    options: WanderOptions | None = None,
    start_time: float = 0.0,
) -> Generator[Footstep, World | None, None]:
    """Footsteps one at a time; `send(world)` instead of `next` tells of a world that has changed.

    It stands, then walks: at random for ever, or from goal to goal until it stands at the last. When the way ahead
    leads too close to an obstacle, the bounds or bad ground, directions are drawn at random around the wanted one, ever
    farther from it, until one is free; where none is, it takes the freest, with short steps and on the spot if need be.
    To a goal to which no way is as wide as the body it side-steps through those that are wide enough for that.
    The same generator and worlds give the same footsteps.

    Args:
        world: Bounds, obstacles, terrain.
        start: Between the feet [m], shape (3,).
        yaw: Where it looks [rad].
        generator: Draws the directions.
        goals: Places to go to (x, y, z) [m], each shape (3,); none = wander at random.
        options: How.
        start_time: When it starts walking [s].

    Raises:
        PlanError: If start or a goal is in an obstacle, out of bounds or off the ground, or a goal cannot be reached.
    """
    options = options or WanderOptions()
    walk = _Walk(place=np.asarray(start, dtype=float)[[0, 2]], height=float(start[1]), yaw=yaw, side=LEFT)
    if not is_clear(world, walk.place[None], np.array([walk.height]), radius=options.radius, step=options.step)[0]:
        x, z = walk.place
        what = "is too close to an obstacle, out of bounds or off the ground"
        raise PlanError(f"start ({x:.2f}, {z:.2f}) m", what, "start where there is room to stand")
    pending = [_on_ground(world, np.asarray(goal, dtype=float)) for goal in goals]
    routes = _routes(world, walk.position, pending, options)
    before = _lay(walk, RIGHT, world, options, time=start_time)
    for footstep in (before, _lay(walk, LEFT, world, options, time=start_time)):
        before = footstep
        changed = yield footstep
        world, routes = (changed, []) if changed is not None else (world, routes)
    while pending or not goals:
        if pending and not routes:
            routes = _routes(world, walk.position, pending, options, must_reach=False)
        length, turn, spin = _choose(walk, world, routes, generator, options)
        facing = _facing(walk, turn, world, routes, options)
        turned = max(facing, walk.facing)
        length = min(length, float(np.interp(turned, (0.0, SIDEWAYS), (length, _side_step(options)))))
        walk = replace(_step(walk, length, turn, world, options), spin=spin, facing=facing)
        before = _lay(walk, walk.side, world, options, before=before)
        changed = yield before
        if routes and _is_at(walk, routes[0], options):
            pending, routes = pending[1:], routes[1:]
        world, routes = (changed, []) if changed is not None else (world, routes)
    walk = replace(_step(walk, 0.0, 0.0, world, options), facing=walk.facing)
    yield _lay(walk, walk.side, world, options, before=before)


def plan_wander(
    world: World,
    start: FloatArray,
    yaw: float,
    *,
    generator: np.random.Generator,
    goals: Sequence[FloatArray] = (),
    steps: int = 40,
    options: WanderOptions | None = None,
    start_time: float = 0.0,
    name: str = "wander",
) -> FootstepPlan:
    """The plan of `steps` footsteps of `wander`, or of those it takes to the last goal if that is fewer.

    Raises:
        PlanError: As `wander`; if there are fewer than two steps.
    """
    way = wander(world, start, yaw, generator=generator, goals=goals, options=options, start_time=start_time)
    footsteps = list(islice(way, steps))
    options = options or WanderOptions()
    ends_standing = len(footsteps) < steps
    return join_footsteps(footsteps, name=name, body=options.body, speed=options.speed, ends_standing=ends_standing)


def join_footsteps(
    footsteps: Iterable[Footstep],
    *,
    name: str,
    body: Proportions | None = None,
    speed: float = 0.0,
    ends_standing: bool = False,
) -> FootstepPlan:
    """The plan of footsteps as they came.

    Args:
        footsteps: From `wander`, the first two of which stand.
        name: Of the plan.
        body: That walks.
        speed: Mean of all steps [m/s]; 0 = as fast as such steps are.
        ends_standing: Whether it stands at the end, as `wander` does at its last goal.
    """
    body = body or Proportions()
    steps = list(footsteps)
    if len(steps) < 2:
        raise PlanError(name, f"has {len(steps)} footstep(s)", "let it take at least two")
    positions = np.array([step.position for step in steps])
    times = time_footsteps(
        positions,
        TimingRule(leg_length=body.leg_length),
        speed=speed,
        start_time=steps[0].strike_time,
        starts_standing=True,
        ends_standing=ends_standing,
    )
    return FootstepPlan(
        name=name,
        sides=np.array([step.side for step in steps]),
        positions=positions,
        orientations=np.array([step.orientation for step in steps]),
        strike_times=times.strike_times,
        liftoff_times=times.liftoff_times,
        root_weights=np.zeros(len(steps)),
    )


@dataclass(frozen=True, kw_only=True)
class _Walk:
    """Where the walk is."""

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


def _on_ground(world: World, point: FloatArray) -> FloatArray:
    """The point (3,) on the ground of the level below or just above it."""
    if world.ground is None or not world.ground.has_terrain:
        return point
    sample = world.ground.heights(point[None, [0, 2]], point[[1]])
    return np.array([point[0], sample.heights[0], point[2]]) if sample.hit[0] else point


def _routes(
    world: World, place: FloatArray, goals: Sequence[FloatArray], options: WanderOptions, *, must_reach: bool = True
) -> list[Route]:
    """Routes to goals (3,), each reached from the one before, the first from a place (3,).

    Raises:
        PlanError: If a goal is not clear or, if it must be, cannot be reached.
    """
    headroom, routes = HEADROOM * options.body.leg_length, []
    half_depth = options.body.half_depth(options.radius)
    for goal in goals:
        for radius in dict.fromkeys((options.radius, half_depth)):
            route = find_route(
                world,
                place,
                goal,
                radius=radius,
                step=options.step,
                headroom=headroom,
                must_be_clear=must_reach,
            )
            if route.find(place) >= 0:
                break
        if must_reach and route.find(place) < 0:
            raise PlanError(
                f"goal ({goal[0]:.2f}, {goal[2]:.2f}) m, height {goal[1]:.2f} m",
                f"cannot be reached from ({place[0]:.2f}, {place[2]:.2f}) m, height {place[1]:.2f} m, "
                f"on foot by a body {2 * options.radius:.2f} m wide, sideways {2 * half_depth:.2f} m",
                "open a way, join the levels by a ramp or stairs, or move the goal",
            )
        routes.append(route)
        place = goal
    return routes


def _is_at(walk: _Walk, route: Route, options: WanderOptions) -> bool:
    apart = np.abs(walk.position - route.goal)
    return bool(np.hypot(apart[0], apart[2]) <= options.arrival and apart[1] <= route.step)


def _choose(
    walk: _Walk, world: World, routes: Sequence[Route], generator: np.random.Generator, options: WanderOptions
) -> tuple[float, float, int]:
    """Length [m] and turn [rad] of the next step, and the side to which it turns out of a dead end, 0 if in none."""
    easy = EASY_STEP * options.body.leg_length
    wanted, farthest, needed = generator.normal(scale=options.wobble), easy, options.look_ahead
    aim = None
    if routes:
        aim = aim_along(routes[0], walk.position, ahead=4.0 * options.look_ahead)
    if aim is not None:
        wanted = float(planar.wrap_angle(planar.yaw_of(aim - walk.place) - walk.yaw))
        farthest = min(easy, float(np.linalg.norm(aim - walk.place)))
        needed = farthest
    draws = generator.normal(size=DRAWS) * np.linspace(0.2, 3.0, DRAWS)
    turns = np.clip(np.append(wanted, wanted + draws), -options.turn, options.turn)
    radius = routes[0].radius if routes else options.radius
    free = _free_ways(walk, turns[:1], needed, world, options, radius=radius)
    if free[0] < needed:
        free = _free_ways(walk, turns, needed, world, options, radius=radius)
    chosen, spin = int(np.argmax(free)), 0  # the first of those that are wholly free
    if free[chosen] < min(0.5 * easy, needed):
        spin = walk.spin or (1 if wanted > 0.0 else -1)
        turns, chosen = np.array([spin * options.turn]), 0
        free = _free_ways(walk, turns, needed, world, options, radius=radius)
    slower = 1.0 - 0.6 * abs(turns[chosen]) / options.turn
    return float(min(free[chosen], farthest * slower)), float(turns[chosen]), spin


def _side_step(options: WanderOptions) -> float:
    return SIDE_STEP * options.body.leg_length


def _facing(walk: _Walk, turn: float, world: World, routes: Sequence[Route], options: WanderOptions) -> float:
    """How far it looks to the right of where it goes in the next step: sideways where a narrow way leads."""
    ahead = np.linspace(0.0, SHOULDERS, 9)[:, None]
    points = walk.place + ahead * planar.direction(np.array(walk.yaw + turn))
    narrow = bool(routes) and routes[0].radius < options.radius
    narrow = narrow and clearances(world, points, np.full(len(points), walk.height)).min() < options.radius
    change = (SIDEWAYS if narrow else 0.0) - walk.facing
    return walk.facing + float(np.clip(change, -options.turn, options.turn))


def _free_ways(
    walk: _Walk, turns: FloatArray, ahead: float, world: World, options: WanderOptions, *, radius: float
) -> FloatArray:
    """How far each direction is free [m] for a body of a radius [m], at most `ahead`, shape (T,).

    Who is already too close to something may walk where it does not come closer.
    """
    spacing = 0.5 * radius
    distances = np.arange(1, max(1, int(np.ceil(ahead / spacing))) + 1) * spacing
    points = walk.place + distances[:, None] * planar.direction(walk.yaw + turns)[:, None]  # (T, D, 2)
    heights = np.full((len(turns), len(distances) + 1), walk.height)
    passable = np.ones((len(turns), len(distances)), dtype=bool)
    if world.ground is not None:
        for column in range(len(distances)):  # along the way, each height from the one before
            sample = world.ground.heights(points[:, column], heights[:, column], step_up=options.step)
            passable[:, column] = sample.walkable & (np.abs(sample.heights - heights[:, column]) <= options.step)
            heights[:, column + 1] = sample.heights
        rises = np.abs(heights[:, SLOPE:] - heights[:, :-SLOPE])
        passable[:, SLOPE - 1 :] &= rises <= SLOPE * spacing * np.tan(STEEPEST) + 0.5 * options.step
    here = float(clearances(world, walk.place[None], np.array([walk.height]))[0])
    free = clearances(world, points.reshape(-1, 2), heights[:, 1:].ravel()) >= min(radius, here)
    clear = free.reshape(len(turns), -1) & passable
    first_blocked = np.where(clear.all(axis=1), len(distances), np.argmin(clear, axis=1))
    return np.minimum(first_blocked * spacing, ahead)


def _step(walk: _Walk, length: float, turn: float, world: World, options: WanderOptions) -> _Walk:
    """The walk after a step of the other foot."""
    yaw, shares = walk.yaw + turn, np.array([1.0, 0.75, 0.5, 0.25])
    places = walk.place + shares[:, None] * length * planar.direction(np.array(yaw))
    if world.ground is None:
        return _Walk(place=places[0], height=walk.height, yaw=yaw, side=1 - walk.side)
    heights = world.ground.heights(places, np.full(len(places), walk.height), step_up=options.step).heights
    easy = np.abs(heights - walk.height) <= EASY_RISE * options.body.leg_length
    chosen = int(np.argmax(easy))  # onto a ledge, where none is, the whole step
    return _Walk(place=places[chosen], height=float(heights[chosen]), yaw=yaw, side=1 - walk.side)


def _lay(
    walk: _Walk, side: int, world: World, options: WanderOptions, *, before: Footstep | None = None, time: float = 0.0
) -> Footstep:
    """The footstep of one foot beside the walk's place; it strikes a step after the one before, else at `time`."""
    body, yaw = options.body, walk.yaw - walk.facing
    outward = 0.5 * np.pi if side == LEFT else -0.5 * np.pi
    closed_up = 2.0 * body.half_width + BETWEEN + _side_step(options)
    width = float(np.interp(np.sin(walk.facing), (0.0, 1.0), (body.step_width, closed_up)))
    point = walk.place + 0.5 * width * planar.direction(np.array(yaw + outward))
    height, normal = walk.height, np.array([[0.0, 1.0, 0.0]])
    if world.ground is not None:
        point = settle_on_treads(
            world.ground,
            point[None],
            np.array([yaw]),
            np.array([height]),
            heels=np.array([body.heel]),
            toes=np.array([body.toe]),
        )[0]
        sample = world.ground.heights(point[None], np.array([height]), step_up=options.step)
        if not (sample.walkable[0] and abs(sample.heights[0] - height) <= options.step):  # beside a ledge
            sample, point = world.ground.heights(walk.place[None], np.array([height]), step_up=options.step), walk.place
        height, normal = float(sample.heights[0]), sample.normals
    position = np.array([point[0], height, point[1]])
    if before is not None:
        distance = np.linalg.norm(position - before.position)
        timing = time_steps(np.array([distance]), TimingRule(leg_length=body.leg_length))
        usual = float(timing.step_times[0])
        time = before.strike_time + (max(float(distance) / options.speed, 0.5 * usual) if options.speed else usual)
    return Footstep(
        side=side,
        position=position,
        orientation=print_orientations(np.array([yaw]), normal)[0],
        strike_time=time,
    )
