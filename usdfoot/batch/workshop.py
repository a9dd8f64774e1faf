"""Workshop: a scene opened once by a worker, who makes its chunks."""

from __future__ import annotations

import threading
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from usdfoot.batch.analysed import KeptExamples, build_once
from usdfoot.batch.kept import keep_agents
from usdfoot.batch.records import record_of
from usdfoot.batch.sources import SourceFigures
from usdfoot.batch.tasks import ChunkTask, EarlyTask
from usdfoot.bridge.chunks import ChunkNotes
from usdfoot.bridge.tokens import Motion as Source
from usdfoot.engine.animate import PreparedLibraries, animate_crowd
from usdfoot.model.agent import Crowd
from usdfoot.model.device import start_warp
from usdfoot.model.limits import Limits
from usdfoot.model.motion import Motion
from usdfoot.model.report import Problem
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.planning.flights import fly_like_clips
from usdfoot.readers.listing import list_scene
from usdfoot.readers.scene import SceneReader
from usdfoot.writers.chunks import write_chunk

if TYPE_CHECKING:
    from usdfoot.physics.animate import PreparedBodies
    from usdfoot.planning.follow import Following

__all__ = ["MadeChunk", "Workshop", "make_chunk", "open_early"]

_ONE_AT_A_TIME = threading.RLock()
"""Threads of a process, as Dask's workers have, share its scene, of which what is read is kept for who asks next."""


@dataclass(frozen=True, kw_only=True)
class MadeChunk:
    """What became of a chunk's agents."""

    record: str
    """What the report says of them, lines of JSON."""
    kept_agents: int
    """How many of them an earlier run had made."""


class Workshop:
    """Makes chunks of one scene; clips are read and analysed once for all of them.

    Args:
        reader: Of the scene.
        options: Of the sources of motion.
        keep: Folder of a crowd that keeps its clips' analysis.
        given: What `open_early` gave back in other processes, by now.
    """

    def __init__(
        self,
        reader: SceneReader,
        options: MotionOptions,
        *,
        keep: Path | None = None,
        given: Callable[[], Mapping[str, bytes]] = dict,
    ) -> None:
        self._reader = reader
        self._options = options
        build = KeptExamples(keep, given=given).build if keep else build_once
        self._libraries = PreparedLibraries(options, build=build)
        self._bodies: PreparedBodies | None = None
        self._sources = SourceFigures()

    def make(self, task: ChunkTask) -> MadeChunk:
        """Animates and writes a chunk.

        Agents that an earlier chunk has as they are to be are taken from there. Without any agent that can be animated,
        nothing is written.

        Raises:
            SceneError: If none of the agents can be read.
            OutputError: If the folder cannot be written to.
        """
        with _ONE_AT_A_TIME:
            return self._make(task)

    def _make(self, task: ChunkTask) -> MadeChunk:
        scene, kept = self._reader.read(names=task.agents), keep_agents(task)
        clip_problems = self._clip_problems(scene.crowd, kept.entries)
        crowd, unlaid = self._conform(_without(scene.crowd, kept.entries))
        crowd, followings, lost = self._plan_followers(crowd)
        crowd = fly_like_clips(crowd, options=self._options, libraries=self._libraries)
        motions, problems = self._animate(crowd)
        record = record_of(
            crowd.agents,
            motions,
            [*kept.problems, *clip_problems, *unlaid, *lost, *problems],
            sources=self._sources.of(crowd, motions),
            names=task.agents,
            trajectories=_trajectory_figures(followings, motions),
            kept=kept.entries,
            anims=task.files.anims,
            content_hash=task.content_hash,
        )
        written = {*kept.entries, *(motion.name for motion in motions)}
        if written:
            references = dict(zip(task.agents, task.references, strict=True))
            hashes = dict(zip(task.agents, task.hashes, strict=True))
            write_chunk(
                replace(scene, crowd=crowd),
                motions,
                task.folder,
                files=task.files,
                references=[references[motion.name] for motion in motions],
                names=[name for name in task.agents if name in written],
                base=kept.prims,
                notes=ChunkNotes(
                    content_hash=task.content_hash,
                    agent_hashes={name: hashed for name, hashed in hashes.items() if name in written},
                    record=record,
                ),
            )
        return MadeChunk(record=record, kept_agents=len(kept.entries))

    def _conform(self, crowd: Crowd) -> tuple[Crowd, list[Problem]]:
        """The crowd with its plans on the terrain, where that is asked for; without terrain that is said."""
        if not self._options.conform:
            return crowd, []
        if not crowd.terrain.meshes:
            what = "conform: the scene has no terrain to lay footsteps on; apply UsdfootTerrainAPI to its ground"
            return crowd, [Problem(severity="warning", where="conform", message=what)]
        from usdfoot.planning.prints import conform_plans

        return conform_plans(crowd), []

    def _plan_followers(self, crowd: Crowd) -> tuple[Crowd, Mapping[str, Following], list[Problem]]:
        """The crowd with plans for all who follow trajectories; without any, what plans them is not even loaded."""
        if not crowd.followers:
            return crowd, {}, []
        from usdfoot.planning.followers import plan_followers

        return plan_followers(crowd, options=self._options, libraries=self._libraries)

    def _animate(self, crowd: Crowd) -> tuple[list[Motion], list[Problem]]:
        """Motions and problems of a crowd; without agents that physics moves, its kernels are not even loaded."""
        if all(agent.motion == Source.CLIPS for agent in crowd.agents):
            return animate_crowd(crowd, options=self._options, libraries=self._libraries)
        from usdfoot.physics.animate import PreparedBodies, animate_all

        self._bodies = self._bodies or PreparedBodies(self._options)
        return animate_all(crowd, options=self._options, libraries=self._libraries, bodies=self._bodies)

    def _clip_problems(self, crowd: Crowd, kept: Collection[str]) -> list[Problem]:
        """What is wrong with the clips of agents that are kept, as their making would tell."""
        libraries = {agent.library for agent in crowd.everyone if agent.name in kept and agent.motion != Source.PHYSICS}
        return [problem for index in sorted(libraries) for problem in self._libraries.prepared(crowd, index).problems]


def _trajectory_figures(followings: Mapping[str, Following], motions: Sequence[Motion]) -> dict[str, dict[str, Any]]:
    """How near those who follow a trajectory keep to it, by agent name."""
    if not followings:
        return {}
    from usdfoot.planning.followers import following_figures

    own = [motion for motion in motions if motion.name in followings]
    return {motion.name: following_figures(followings[motion.name], motion) for motion in own}


def _without(crowd: Crowd, names: Collection[str]) -> Crowd:
    """The crowd without some of its agents."""
    return replace(
        crowd,
        agents=tuple(agent for agent in crowd.agents if agent.name not in names),
        followers=tuple(follower for follower in crowd.followers if follower.name not in names),
    )


def make_chunk(task: ChunkTask) -> MadeChunk:
    """Makes a chunk in any process.

    The process keeps the scene open for the chunks to come, and only this scene. Its threads make one chunk at a time.
    """
    state = task.scene, task.inputs, task.frames, task.options, task.limits, task.folder, task.keeps_examples
    with _ONE_AT_A_TIME:
        return _workshop(*state).make(task)


@lru_cache(maxsize=1)
def _workshop(
    scene: str, inputs: str, frames: tuple[int, int], options: MotionOptions, limits: Limits, folder: str, keeps: bool
) -> Workshop:
    """The workshop of a scene in the state that `inputs` stands for."""
    reader = _reader(scene, inputs, options, limits, folder).at_frames(frames)
    return Workshop(reader, options, keep=Path(folder) if keeps else None)


def open_early(task: EarlyTask) -> dict[str, bytes]:
    """Opens a scene in a process that is going to make chunks of it, and reads and analyses what these will need.

    Nothing is written. If the scene's files are the same when chunks are asked for, none of this need be done again.

    Returns:
        Files of the clips' analysis that the crowd's folder lacks, by name, if the task asks for them.

    Raises:
        UsdfootError: If it cannot be done, which chunks will tell too.
    """
    start_warp()
    with _ONE_AT_A_TIME:
        reader = _reader(task.scene, task.inputs, task.options, task.limits, task.folder)
        names = task.agents or reader.names
        crowd = reader.read(names=names[:1]).crowd
        libraries = {agent.library for agent in crowd.everyone if agent.motion != Source.PHYSICS}
        kept, cut = KeptExamples(Path(task.folder)), {}
        for library in libraries:
            cut.update(kept.cut(crowd.libraries[library], samples=task.options.samples))
        starts = range(0, len(names), 2 * task.chunk_size)  # chunks between these are the other process's
        reader.read_walks([name for start in starts for name in names[start : start + task.chunk_size]])
    return cut if task.gives_examples else {}


@lru_cache(maxsize=1)
def _reader(scene: str, inputs: str, options: MotionOptions, limits: Limits, folder: str) -> SceneReader:
    """A scene in the state that `inputs` stands for, opened and listed once; at no frames yet."""
    return SceneReader(
        list_scene(scene, limits=limits, reload=True),
        motion=options.motion,
        tuning=options.tuning,
        crowd=Path(folder),
        limits=limits,
        sampling=options.sampling,
        foreseen=False,
        build=KeptExamples(Path(folder)).find,
    )
