"""Reads a whole scene: stage in, crowd and characters out."""

from __future__ import annotations

import logging
import os
from collections import deque
from collections.abc import Collection, Sequence
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from pxr import Usd

from usdfoot.bridge.placements import Placement
from usdfoot.bridge.scene import Scene, StageInfo
from usdfoot.bridge.tokens import File
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Agent, Crowd, Follower
from usdfoot.model.limits import DEFAULT_LIMITS, Limits
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.report import Problem
from usdfoot.model.sampling import ALL_FRAMES, SamplingOptions
from usdfoot.model.trajectory import RootTrajectory
from usdfoot.model.tuning import BodyTuning
from usdfoot.readers.agents import AgentSource
from usdfoot.readers.casting import Casting, skipped
from usdfoot.readers.clip_sources import ClipFinder
from usdfoot.readers.distances import distance_problems
from usdfoot.readers.far_agents import SamplingReader
from usdfoot.readers.frames import find_frames, frames_problems, rate_problems, spans_of
from usdfoot.readers.listing import ListedScene, list_scene
from usdfoot.readers.overrides import read_overrides
from usdfoot.readers.placements import PlacementReader
from usdfoot.readers.recasting import recast
from usdfoot.readers.stage import StagePrims
from usdfoot.readers.terrain import read_terrain
from usdfoot.readers.tuning import UNTUNED
from usdfoot.readers.unfollowed import find_unfollowed
from usdfoot.readers.visibility import read_visibilities
from usdfoot.readers.walks import WalkReader

if TYPE_CHECKING:
    from usdfoot.engine.animate import ExamplesBuilder
    from usdfoot.planning.world import Obstacle

__all__ = ["SceneReader", "read_scene"]

Walking = TypeVar("Walking", Agent, Follower)

_logger = logging.getLogger(__name__)


def read_scene(
    scene: str | os.PathLike[str] | Usd.Stage,
    *,
    agents: str = "*",
    frames: tuple[int, int] | None = None,
    motion: str | None = None,
    tuning: BodyTuning = UNTUNED,
    limits: Limits = DEFAULT_LIMITS,
) -> Scene:
    """Everything usdfoot needs of a stage, in canonical space; the stage is not changed.

    What cannot be used becomes a problem of the crowd, and the rest goes on.

    Args:
        scene: File or open stage.
        agents: Glob on the names or prim paths of the agents to read.
        frames: First and last time code of the output; None = from the first strike to the last liftoff of all agents.
        motion: Of all agents; None = what each says. Agents that physics moves need no clips.
        tuning: Of all agents, over what each says.
        limits: How much of a scene is read.

    Raises:
        SceneError: If the stage cannot be opened, is too large, or no agent at all can be used.
    """
    read = SceneReader(scene, agents=agents, frames=frames, motion=motion, tuning=tuning, limits=limits).read()
    for problem in read.crowd.problems:
        _logger.log(logging.ERROR if problem.severity == "error" else logging.WARNING, "%s", problem.message)
    return read


class SceneReader:
    """A stage opened once, whose agents can be read a few at a time; the rest is read only once.

    Args:
        scene: File or open stage, never changed, or what is listed of one.
        agents: Glob on the names or prim paths of the agents that can be read, or several; of what is listed, those
            that were chosen then.
        frames: First and last time code of the output; None = from the first strike to the last liftoff of all agents.
        motion: Of all agents; None = what each says. Agents that physics moves need no clips.
        tuning: Of all agents, over what each says.
        crowd: Folder of the crowd, whose overrides.usda mutes agents and changes plans.
        limits: How much of a scene is read.
        sampling: Who is sampled at which frames.
        foreseen: Whether all plans are read at once, for what is wrong with any and for the frames if none are given;
            else each is read with its agent.
        build: Cuts the steps of clips for those who follow paths; None = anew.

    Raises:
        SceneError: If the stage cannot be opened, the glob matches nobody, the frames are none, or it is too large.
    """

    def __init__(
        self,
        scene: str | os.PathLike[str] | Usd.Stage | ListedScene,
        *,
        agents: str | Sequence[str] = "*",
        frames: tuple[int, int] | None = None,
        motion: str | None = None,
        tuning: BodyTuning = UNTUNED,
        crowd: Path | None = None,
        limits: Limits = DEFAULT_LIMITS,
        sampling: SamplingOptions = ALL_FRAMES,
        foreseen: bool = True,
        build: ExamplesBuilder | None = None,
    ) -> None:
        listed = scene if isinstance(scene, ListedScene) else list_scene(scene, agents=agents, limits=limits)
        stage, prims, self.info = listed.stage, listed.prims, listed.info
        self._listed = listed
        self._motion, self._tuning, self._sampling_options, self._limits = motion, tuning, sampling, limits
        self._overrides = read_overrides(crowd, self.info.units, most_footsteps=limits.footsteps)
        self.names = tuple(source.name for source in listed.chosen)
        over = self._overrides.over(listed.chosen)
        self._chosen, self._recast_problems = recast(over, stage, everyone=listed.everyone)
        self._terrain, self._terrain_problems = read_terrain(stage, prims, self.info.units, limits=limits)
        self._doubts: dict[str, tuple[Problem, ...]] = {}
        self._obstacle_problems: tuple[Problem, ...] = ()
        self._walks = WalkReader(
            stage,
            self.info.units,
            everyone=listed.everyone,
            overrides=self._overrides,
            planned=self._plan_paths(stage, prims, motion, build),
            most_footsteps=limits.footsteps,
        )
        everyone, _ = recast(self._overrides.over(listed.everyone), stage, everyone=listed.everyone)
        absent = {source.name for source in listed.everyone} - {source.name for source in self._chosen}
        self._placer = PlacementReader(
            self._overrides, self._walks, everyone=everyone, absent=absent, units=self.info.units
        )
        self._placements: dict[str, Placement] = {}
        walks = [*self._walks.read_all(self._chosen)] if foreseen else []
        spans = spans_of(walks, self.info)
        codes = find_frames(spans, self.info, frames, most=limits.frames)
        self._frame_problems = [*rate_problems(self.info, sampling.every), *frames_problems(spans, codes)]
        self._frame_problems += distance_problems(walks, self.info)
        self._set_frames(codes)

    def _set_frames(self, codes: FloatArray) -> None:
        stage, prims = self._listed.stage, self._listed.prims
        foreign = (
            *(source.plan for source in self._listed.everyone),
            *(stage.GetPrimAtPath(path) for path in self._terrain.meshes),
        )
        self._casting = Casting(
            prims=prims,
            foreign=foreign,
            units=self.info.units,
            frame_codes=codes,
            finder=ClipFinder(stage, prims),
            motion=self._motion,
            tuning=self._tuning,
            most_frames=self._limits.frames,
        )
        self._cast: dict[str, Agent | Follower | None] = {}
        self._codes = codes
        self._sampling = SamplingReader(stage, self._sampling_options, self.info.units, codes)

    def at_frames(self, frames: tuple[int, int]) -> SceneReader:
        """A reader of the same scene at other frames, to which it is known already where agents go."""
        other = copy(self)
        other._set_frames(find_frames(np.zeros((0, 2)), self.info, frames, most=self._limits.frames))
        return other

    def read_walks(self, names: Collection[str]) -> None:
        """Reads where these agents go, who are to be read later."""
        wanted = set(names)
        deque(self._walks.read_all([source for source in self._chosen if source.name in wanted]), maxlen=0)

    @property
    def frame_count(self) -> int:
        """How many frames the crowd has."""
        return len(self._codes)

    def read(self, *, names: Collection[str] | None = None) -> Scene:
        """The agents with these names and all they need.

        Args:
            names: Of agents; None = all that the glob matches.

        Raises:
            SceneError: If none of them can be used.
        """
        casting = self._casting
        wanted = None if names is None else set(names)
        sources = [source for source in self._chosen if wanted is None or source.name in wanted]
        self._walks.ask(sources)
        everyone = [self._performer_of(source) for source in sources]
        cast = [performer for performer in everyone if isinstance(performer, Agent)]
        followers = [performer for performer in everyone if isinstance(performer, Follower)]
        problems = (
            *self._listed.problems,
            *find_unfollowed(self._overrides, {source.name for source in self._listed.everyone}),
            *self._recast_problems,
            *self._walks.problems,
            *self._placer.problems,
            *self._frame_problems,
            *casting.problems,
            *casting.unfit_clips(),
            *self._terrain_problems,
            *self._obstacle_problems,
            *(doubt for agent in cast if agent.flights_open for doubt in self._doubts.get(agent.name, ())),
        )
        if self._listed.chosen and not self._chosen:
            muted = f"{File.OVERRIDES} makes all of them inactive"
            raise SceneError(self.info.identifier, "no agent can be used", names=[muted])
        _require_agents(self.info, self._listed.everyone, len(cast) + len(followers), problems)
        crowd = Crowd(
            agents=tuple(cast),
            libraries=tuple(casting.libraries),
            terrain=self._terrain,
            frame_times=self.info.units.codes_to_times(self._codes),
            frame_rate=self.info.units.time_codes_per_second,
            followers=tuple(followers),
            problems=problems,
        )
        seen = [source for source, performer in zip(sources, everyone, strict=True) if performer]
        own = {source.name: casting.own_attributes_of(source) for source in seen}
        return Scene(
            stage=self.info,
            crowd=crowd,
            characters=tuple(casting.characters),
            frame_codes=self._codes,
            placements={
                source.name: self._placements[source.name] for source in seen if source.name in self._placements
            },
            visibility=read_visibilities(seen),
            own_attributes={name: attributes for name, attributes in own.items() if attributes},
        )

    def _performer_of(self, source: AgentSource) -> Agent | Follower | None:
        """An agent with all it needs, None if it cannot be used; read once."""
        if source.name not in self._cast:
            self._cast[source.name] = self._read_performer(source)
        return self._cast[source.name]

    def _read_performer(self, source: AgentSource) -> Agent | Follower | None:
        given = self._walks.walk_of(source)
        if isinstance(given, UsdfootError):
            return None
        try:
            placed = self._placer.place(source, given, self._casting)
        except UsdfootError as error:
            self._placer.problems.append(skipped(source, error))
            return None
        self._placements.update({source.name: placed.placement} if placed.placement else {})
        if isinstance(placed.walk, RootTrajectory):
            follower = self._casting.cast_follower(source, placed.walk)
            return self._sampled(follower, placed.walk) if follower else None
        agent = self._casting.cast(source, placed.walk, placed.root)
        if agent and self._walks.is_planned(source.name, given):
            agent = replace(agent, flights_open=True)
        return self._sampled(agent, placed.walk) if agent else None

    def _sampled(self, performer: Walking, walk: FootstepPlan | RootTrajectory) -> Walking:
        """The performer with its frames; one below a transform that moves undoes that at all of them."""
        if len(self._casting.characters[performer.character].skeleton_to_agent) > 1:
            return performer
        frames = self._sampling.frames_of(walk, performer.name)
        return performer if frames == performer.sampled else replace(performer, sampled=frames)

    def _plan_paths(
        self, stage: Usd.Stage, prims: StagePrims, motion: str | None, build: ExamplesBuilder | None
    ) -> dict[str, FootstepPlan | UsdfootError]:
        """Plans of all agents that follow a path, or why there is none, by agent name."""
        if not any(source.path for source in self._chosen):
            return {}
        from usdfoot.readers.habits import HabitsReader
        from usdfoot.readers.moving_obstacles import MovingObstacles
        from usdfoot.readers.obstacles import read_obstacles  # with all that plans paths, for who follows one
        from usdfoot.readers.path_plans import plan_paths
        from usdfoot.readers.walkers import read_walkers

        habits = HabitsReader(motion=motion, build=build)
        walkers, errors = read_walkers(
            *(stage, prims, self.info.units), sources=self._chosen, everyone=self._listed.everyone, habits=habits
        )
        obstacles: tuple[Obstacle, ...] = ()
        if walkers:
            obstacles, self._obstacle_problems = read_obstacles(stage, prims, self.info.units)
        moving = MovingObstacles(prims, self.info.units)
        found = plan_paths(walkers, self._terrain, obstacles=obstacles, moving=moving)
        self._doubts = {
            walker.name: (*walker.doubts(), *([found.waits[walker.name]] if walker.name in found.waits else []))
            for walker in walkers
        }
        return {**found.plans, **found.errors, **errors}


def _require_agents(info: StageInfo, everyone: Sequence[AgentSource], usable: int, problems: Sequence[Problem]) -> None:
    """Raises SceneError if nothing is left to animate."""
    if usable:
        return
    errors = [problem.message for problem in problems if problem.severity == "error"]
    if not everyone and not errors:
        raise SceneError(
            info.identifier,
            "has no footstep plan",
            "add a PointInstancer with UsdfootPlanAPI: protoIndices, positions, usdfoot:plan:strikeTimes, "
            "usdfoot:plan:liftoffTimes",
        )
    raise SceneError(info.identifier, "no agent can be used", names=errors)
