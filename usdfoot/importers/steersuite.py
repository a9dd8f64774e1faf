"""SteerSuite test cases: agents, goals and obstacles of a scenario file (metres, +Y up, ground (x, z))."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from usdfoot.importers.xml_tree import Element, parse_xml
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.report import Problem
from usdfoot.planning.scenario import Scenario, Seeker
from usdfoot.planning.world import Obstacle, World, box_outline, clearances

__all__ = ["import_steersuite"]

ROOT = "SteerBenchTestCase"
OBSTACLES = (
    "obstacle",
    "obstacleRegion",
    "circleObstacle",
    "polygonObstacle",
    "orientedBoxObstacle",
    "orientedWallObstacle",
)
CIRCLE = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
TRIES, ROUNDS = 8, 50
"""Places tried at once, and how often, before a region counts as full."""
IGNORED = ("header", "suggestedCameraView")


@dataclass(frozen=True, kw_only=True)
class _Chance:
    """What the file leaves to chance is drawn here, and what was odd is noted."""

    generator: np.random.Generator
    lowest: FloatArray
    highest: FloatArray
    """Corners of the world (x, z) [m]."""
    world: World
    """The obstacles."""
    problems: list[Problem]

    def clear_place(
        self, element: Element, radius: float, *, within: tuple[FloatArray, FloatArray], seekers: list[Seeker]
    ) -> FloatArray:
        """A place (x, z) in a region, clear of obstacles and of seekers.

        Raises:
            SceneError: If there seems to be none.
        """
        places = np.array([seeker.start[[0, 2]] for seeker in seekers]).reshape(-1, 2)
        apart = radius + np.array([seeker.radius for seeker in seekers])
        for _ in range(ROUNDS):
            tries = self.generator.uniform(*within, size=(TRIES, 2))
            free = np.all(np.linalg.norm(tries[:, None] - places, axis=2) >= apart, axis=1)
            free[free] = clearances(self.world, tries[free]) >= radius
            if free.any():
                return tries[int(np.argmax(free))]
        raise element.error(f"has no room for another agent of radius {radius:g} m", "give it fewer, or wider bounds")

    def note(self, element: Element, what: str) -> None:
        """Add a warning that names the line."""
        error = element.error(what)
        self.problems.append(Problem(severity="warning", where=error.where, message=str(error)))

    def box(self, element: Element) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner (x, z); some files have them the wrong way round."""
        low, high = (np.array([element.need(f"{axis}{end}").number() for axis in "xz"]) for end in ("min", "max"))
        if np.any(low > high):
            self.note(element, "has a minimum above its maximum; they were swapped")
        return np.minimum(low, high), np.maximum(low, high)


def import_steersuite(
    file: str | os.PathLike[str], *, generator: np.random.Generator
) -> tuple[Scenario, tuple[Problem, ...]]:
    """The scenario of a SteerSuite test case (versions 1.0 to 1.2), and what was odd or left out.

    Goals that are places are kept in order; others (fleeing, following, flows) are left out with a warning, and an
    agent without any stays where it is. An emitter gives one agent.

    Args:
        file: XML file.
        generator: Draws what the file leaves to chance: places, directions, goals. Same generator, same scenario.

    Raises:
        SceneError: If the file cannot be read or is malformed (the line is named), or a region cannot hold its agents.
    """
    root = parse_xml(file)
    if root.tag != ROOT:
        raise root.error("is no SteerSuite test case", f"its root element is <{ROOT}>")
    nowhere = np.zeros(2)
    chance = _Chance(generator=generator, lowest=nowhere, highest=nowhere, world=World(), problems=[])
    lowest, highest = chance.box(root.need("header").need("worldBounds"))
    obstacles = tuple(obstacle for child in root.children for obstacle in _obstacles(child, chance))
    chance = replace(chance, lowest=lowest, highest=highest, world=World(obstacles=obstacles))
    seekers: list[Seeker] = []
    for child in root.children:
        if child.tag in ("agent", "agentEmitter"):
            if child.tag == "agentEmitter":
                chance.note(child, "emits agents one after the other; one of them was taken")
            seekers.append(_agent(child, chance, seekers))
        elif child.tag == "agentRegion":
            region = child.need("regionBounds")
            within, radius = chance.box(region), _radius(child)
            for _ in range(_count(child.need("numAgents"))):
                start = chance.clear_place(region, radius, within=within, seekers=seekers)
                seekers.append(_walker(child, f"agent{len(seekers)}", start, chance))
        elif child.tag not in IGNORED and child.tag not in OBSTACLES:
            raise child.error("is not part of a SteerSuite test case", "remove it")
    places = [place[[0, 2]] for seeker in seekers for place in (seeker.start, *seeker.goals)]
    bounds = box_outline(
        np.min([lowest, *(place - 1.0 for place in places)], axis=0),
        np.max([highest, *(place + 1.0 for place in places)], axis=0),
    )
    problems = {problem.message: problem for problem in chance.problems}
    return Scenario(seekers=tuple(seekers), obstacles=obstacles, bounds=bounds), tuple(problems.values())


def _obstacles(element: Element, chance: _Chance) -> Iterator[Obstacle]:
    """What an element of the file puts in the way: nothing, one obstacle or several."""
    name = f"{element.tag}_{element.line}"
    if element.tag == "obstacle":
        yield Obstacle(name=name, outline=box_outline(*chance.box(element)))
    elif element.tag == "circleObstacle":
        circle = element.need("radius").number() * np.stack([np.sin(CIRCLE), np.cos(CIRCLE)], axis=1)
        yield Obstacle(name=name, outline=_place(element.need("position")) + circle)
    elif element.tag == "polygonObstacle":
        corners = [_place(vertex) for vertex in element.all("vertex")]
        if len(corners) < 3:
            raise element.error(f"has {len(corners)} <vertex>", "three or more are needed")
        yield Obstacle(name=name, outline=np.array(corners))
    elif element.tag in ("orientedBoxObstacle", "orientedWallObstacle"):
        yield from _oriented(element, name, chance)
    elif element.tag == "obstacleRegion":
        half = 0.5 * element.need("obstacleSize").number()
        lowest, highest = chance.box(element.need("regionBounds"))
        for number in range(_count(element.need("numObstacles"))):
            centre = chance.generator.uniform(lowest, highest)
            yield Obstacle(name=f"{name}_{number}", outline=box_outline(centre - half, centre + half))


def _oriented(element: Element, name: str, chance: _Chance) -> Iterator[Obstacle]:
    """A turned box; a doorway cuts it in two."""
    size, centre = _place(element.need("size")), _place(element.need("position"))
    turn = element.find("thetaY")
    yaw = np.radians(turn.number()) if turn is not None else 0.0
    if turn is not None and yaw:
        chance.note(turn, "was taken for degrees about +Y")
    spans = [(-0.5 * size[0], 0.5 * size[0])]
    door = element.find("doorway")
    if door is not None:
        middle, half = door.need("value").number(), door.need("doorRadius").number()
        spans = [(spans[0][0], middle - half), (middle + half, spans[0][1])]
    for number, (left, right) in enumerate(spans):
        if left < right:
            box = box_outline(np.array([left, -0.5 * size[1]]), np.array([right, 0.5 * size[1]]))
            suffix = f"_{number}" if len(spans) > 1 else ""
            yield Obstacle(name=name + suffix, outline=centre + planar.rotate(np.full(4, yaw), box))


def _agent(element: Element, chance: _Chance, others: list[Seeker]) -> Seeker:
    """An agent at its place, or anywhere in the world."""
    position = element.need("initialConditions").need("position")
    if _is_random(position):
        start = chance.clear_place(position, _radius(element), within=(chance.lowest, chance.highest), seekers=others)
    else:
        start = _place(position)
    given = element.find("name")
    named = given.text if given is not None and given.text else f"agent{len(others)}"
    return _walker(element, named, start, chance)


def _walker(element: Element, name: str, start: FloatArray, chance: _Chance) -> Seeker:
    """An agent at a place, with its direction and goals."""
    direction = element.need("initialConditions").find("direction")
    yaw = None
    if direction is not None:
        drawn = _is_random(direction)
        yaw = chance.generator.uniform(-np.pi, np.pi) if drawn else float(planar.yaw_of(_place(direction)))
    goals, speeds = [], []
    for goal in element.need("goalSequence").children:
        place = _goal(goal, _radius(element), chance)
        if place is None:
            chance.note(goal, "is no place to go to; it was left out")
            continue
        goals.append(place)
        speed = goal.find("desiredSpeed")
        speeds.append(speed.number() if speed is not None else 0.0)
    return Seeker(
        name=name,
        start=np.array([start[0], 0.0, start[1]]),
        yaw=yaw,
        goals=np.insert(np.array(goals or [start]), 1, 0.0, axis=1),
        speed=next((speed for speed in speeds if speed > 0.0), 1.3),
        radius=_radius(element),
    )


def _goal(element: Element, radius: float, chance: _Chance) -> FloatArray | None:
    """The place (x, z) of a goal; None if it is none."""
    if element.tag == "seekAxisAlignedBoxRegion":
        return 0.5 * np.add(*chance.box(element.need("goalRegionBounds")))
    if element.tag != "seekStaticTarget":
        return None
    location, drawn = element.need("targetLocation"), element.find("random")
    if _is_random(location) or (drawn is not None and drawn.text == "true"):
        return chance.clear_place(location, radius, within=(chance.lowest, chance.highest), seekers=[])
    return _place(location)


def _radius(element: Element) -> float:
    radius = element.need("initialConditions").need("radius")
    if radius.number() <= 0.0:
        raise radius.error(f"is {radius.number():g}", "it must be more than 0")
    return radius.number()


def _count(element: Element) -> int:
    if not element.text.isdigit():
        raise element.error(f"holds {element.text!r}", "a whole number of at least 0 is needed")
    return int(element.text)


def _is_random(element: Element) -> bool:
    random = element.find("random")
    if random is not None and random.text not in ("true", "false"):
        raise random.error(f"holds {random.text!r}", "true or false is needed")
    return random is not None and random.text == "true"


def _place(element: Element) -> FloatArray:
    """X and z of an element."""
    return np.array([element.need("x").number(), element.need("z").number()])
