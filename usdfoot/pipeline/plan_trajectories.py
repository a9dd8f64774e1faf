"""Plan trajectories: tracks of people, on a stage or in a file, become a layer of footstep plans."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

from usdfoot.batch.analysed import build_once
from usdfoot.bridge.names import unique_name
from usdfoot.bridge.scene import StageInfo
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError
from usdfoot.importers.pedestrians import import_pedestrians
from usdfoot.model.ground import Ground
from usdfoot.model.limits import DEFAULT_LIMITS, Limits, check_range
from usdfoot.model.report import Problem
from usdfoot.model.terrain import Terrain, no_terrain
from usdfoot.pipeline.flying import flying_like_clips
from usdfoot.pipeline.plan import PlanReport, save_plans
from usdfoot.pipeline.plan_doubts import find_doubts
from usdfoot.planning.proportions import Proportions
from usdfoot.planning.trajectories import TrajectoryOptions, plan_trajectories
from usdfoot.planning.world import Obstacle
from usdfoot.readers.casting import Casting
from usdfoot.readers.habits import HabitsReader
from usdfoot.readers.listing import ListedScene, list_scene
from usdfoot.readers.movers import Mover, read_movers
from usdfoot.readers.moving_obstacles import MovingObstacles
from usdfoot.readers.obstacles import read_obstacles
from usdfoot.readers.terrain import read_terrain
from usdfoot.readers.walkers import only_proportions
from usdfoot.writers.plans import PlannedAgent

__all__ = ["TrackFormat", "plan_scene_trajectories", "plan_track_file"]

FILE_RATE = 24.0
"""Time codes a second of plans for no scene."""

RATES = (1e-3, 1e6)
"""Nobody is tracked less or more often than this [Hz]."""


@dataclass(frozen=True, kw_only=True)
class TrackFormat:
    """What the numbers of a file of tracks mean, where it does not say so itself.

    Raises:
        UsdfootError: If the rate is out of all bounds.
    """

    unit: str = ""
    """m, cm, mm, ft, in, or metres a unit."""
    rate: float = 0.0
    """Frames a second."""
    layout: str = "auto"
    """Order of the columns: auto, or one of `importers.track_tables.LAYOUTS`."""

    def __post_init__(self) -> None:
        check_range("rate", self.rate, RATES, unit="Hz", or_zero=True)


@dataclass(frozen=True, kw_only=True)
class _Surroundings:
    """The stage that plans are made for."""

    info: StageInfo
    terrain: Terrain
    body: Proportions
    problems: tuple[Problem, ...]
    obstacles: tuple[Obstacle, ...] = ()
    """That stay where they are."""
    moving: Callable[[float], Sequence[Obstacle]] | None = None
    """Others at a time [s]; None = there are none."""
    fly: Callable[[Sequence[PlannedAgent]], list[PlannedAgent]] = list
    """Gives those who run the flights of their clips."""


def plan_scene_trajectories(
    scene: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    agents: str = "*",
    prims: str = "",
    options: TrajectoryOptions | None = None,
    limits: Limits = DEFAULT_LIMITS,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> PlanReport:
    """Plan footsteps for everyone who moves on a stage and write them as a layer.

    These are the agents with usdfoot:agent:trajectory; without any, all animated Points and PointInstancers with ids;
    without any, all animated Xforms and SkelRoots. Agents whose clips show the same habits step as these do, those who
    run fly as long, and in walks both feet stand together no longer.

    Args:
        scene: The USD scene; never changed.
        output: Layer to write: /Plans/<name>, and an `over` of each agent that points at its plan.
        agents: Glob on agents' names or paths.
        prims: Glob on the paths of prims to take instead.
        options: Of the planner.
        limits: How much of the scene is read before it is refused.
        progress: Told what begins: "read", "plan", "write".

    Raises:
        SceneError: If the scene cannot be opened, nothing moves or there is more of something than the limits allow.
        OutputError: If the layer cannot be written.
    """
    progress("read", 0, 0)
    listed = list_scene(scene, agents=agents, limits=limits)
    info = listed.info
    movers, mover_problems = read_movers(listed.stage, info.units, sources=listed.chosen, pattern=prims)
    around = _surroundings_of(listed, limits)
    problems = (*around.problems, *mover_problems)
    if not movers:
        reasons = [problem.message for problem in problems if problem.severity == "error"]
        remedy = "" if reasons else "animate Xforms, SkelRoots, or Points with ids; --prims names other animated prims"
        raise SceneError(
            info.identifier, "no trajectory can be planned" if reasons else "nothing moves", remedy, reasons
        )
    around = replace(_like_clips(around, listed), problems=problems)
    return _planned(movers, around, output, options or TrajectoryOptions(), progress)


def plan_track_file(
    file: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    track_format: TrackFormat | None = None,
    scene: str | os.PathLike[str] | None = None,
    options: TrajectoryOptions | None = None,
    limits: Limits = DEFAULT_LIMITS,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> PlanReport:
    """Plan footsteps for the people of a file of pedestrian data and write them as a layer.

    Args:
        file: ETH, UCY, Juelich, PedPy, JuPedSim or CSV; its y is north, which is -Z on a Y-up stage.
        output: Layer to write, /Plans/person_<id>.
        track_format: Unit, rate and columns, where the file does not tell them.
        scene: Stage the plans are for: its units, terrain and character; None = metres, Y up, level ground, a person.
        options: Of the planner.
        limits: How much of the scene is read before it is refused.
        progress: Told what begins: "read", "plan", "write".

    Raises:
        TrackError: If the file cannot be read or does not say what its numbers mean.
        SceneError: If the scene cannot be opened, or has more of something than the limits allow.
        OutputError: If the layer cannot be written.
    """
    progress("read", 0, 0)
    given = track_format or TrackFormat()
    trajectories, problems = import_pedestrians(file, unit=given.unit, rate=given.rate, layout=given.layout)
    around = _surroundings_of(list_scene(scene, limits=limits), limits) if scene else _nowhere(file)
    taken: set[str] = set()
    movers = [
        Mover(name=unique_name(_prim_name(trajectory.name, Path(file).name), taken), agent="", trajectory=trajectory)
        for trajectory in trajectories
    ]
    if not movers:
        raise SceneError(file, "nobody is in it twice", "a track is two positions or more")
    around = replace(around, problems=(*around.problems, *problems))
    return _planned(movers, around, output, options or TrajectoryOptions(), progress)


def _planned(
    movers: tuple[Mover, ...] | list[Mover],
    around: _Surroundings,
    output: str | os.PathLike[str],
    options: TrajectoryOptions,
    progress: Callable[[str, int, int], None],
) -> PlanReport:
    progress("plan", 0, 0)
    lowest = min(float(mover.trajectory.positions[:, 1].min()) for mover in movers)
    ground = Ground(around.terrain, fallback_height=lowest)
    trajectories = [mover.trajectory for mover in movers]
    plans = plan_trajectories(trajectories, ground, proportions=around.body, options=options)
    planned = [
        PlannedAgent(name=mover.name, plan=plan, size=around.body.foot_length, agent=mover.agent)
        for mover, plan in zip(movers, plans, strict=True)
    ]
    planned = around.fly(planned)
    doubts = find_doubts(
        planned,
        around.terrain,
        bodies=[around.body] * len(planned),
        obstacles=around.obstacles,
        moving=around.moving,
    )
    progress("write", 0, 0)
    made_by = {"planner": "trajectories", "options": asdict(options)}
    file = save_plans(planned, output, around.info, made_by=made_by)
    return PlanReport(file=file, plans={part.name: part.plan for part in planned}, problems=(*around.problems, *doubts))


def _like_clips(around: _Surroundings, listed: ListedScene) -> _Surroundings:
    """The stage whose agents step and fly as in their clips; as people where these show different habits."""
    foreign = [source.plan for source in listed.everyone]
    casting = Casting.to_look(listed.stage, listed.prims, listed.info.units, foreign=foreign)
    followers = [source for source in listed.chosen if source.trajectory is not None]
    reader = HabitsReader(build=build_once)
    habits = {reader.read(casting, source) for source in followers}
    body = replace(around.body, habits=habits.pop()) if len(habits) == 1 else around.body
    fly = partial(flying_like_clips, sources=followers, terrain=around.terrain, casting=casting)
    return replace(around, body=body, fly=fly)


def _surroundings_of(listed: ListedScene, limits: Limits) -> _Surroundings:
    info, prims = listed.info, listed.prims
    terrain, terrain_problems = read_terrain(listed.stage, prims, info.units, limits=limits)
    obstacles, obstacle_problems = read_obstacles(listed.stage, prims, info.units)
    moving = MovingObstacles(prims, info.units)
    return _Surroundings(
        info=info,
        terrain=terrain,
        body=only_proportions(prims, info.units, foreign=tuple(source.plan for source in listed.everyone)),
        problems=(*listed.problems, *terrain_problems, *obstacle_problems),
        obstacles=moving.others(obstacles),
        moving=moving.at if moving else None,
    )


def _nowhere(file: str | os.PathLike[str]) -> _Surroundings:
    """Level ground in metres, Y up."""
    info = StageInfo(
        identifier=str(file),
        units=StageUnits(meters_per_unit=1.0, up_axis="Y", time_codes_per_second=FILE_RATE),
        frames_per_second=FILE_RATE,
        start_code=0.0,
        end_code=0.0,
        layers=(str(file),),
    )
    return _Surroundings(info=info, terrain=no_terrain(), body=Proportions(), problems=())


def _prim_name(name: str, file_name: str) -> str:
    """person_<id>, with what else makes the trajectory's name unique."""
    return "person_" + re.sub(r"\W+", "_", name.removeprefix(file_name).strip()).replace("-", "_")
