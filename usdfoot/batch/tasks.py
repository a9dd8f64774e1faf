"""Tasks: a crowd cut into chunks, each of which any worker can make from the scene's file alone."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from usdfoot import __version__
from usdfoot.bridge.chunk_files import ChunkFiles, chunk_files
from usdfoot.bridge.scene import Character, Scene
from usdfoot.bridge.tokens import File
from usdfoot.bridge.versions import library_versions
from usdfoot.model.agent import Agent, Follower
from usdfoot.model.hashing import content_hash, library_hash
from usdfoot.model.limits import Limits
from usdfoot.physics.motion_options import MotionOptions

__all__ = ["ChunkTask", "EarlyTask", "agents_a_chunk", "cut_chunks", "early_task", "inputs_of"]

LARGE_CROWD = 4
"""From so many chunks on a crowd keeps its clips' analysis: of a smaller one that would be much of what it is."""


FRAMES_AT_ONCE = 250_000
"""Frames of all agents of a chunk together: about half a gigabyte of a person's."""


def agents_a_chunk(asked: int, *, frames: int) -> int:
    """How many agents a chunk has: as many as are asked for, fewer in a shot so long that memory would not do."""
    return max(1, min(asked, FRAMES_AT_ONCE // frames))


@dataclass(frozen=True, kw_only=True)
class ChunkTask:
    """What a worker is told: names and numbers, never what was read of the scene."""

    index: int
    """Of the chunk."""
    scene: str
    """The scene's file."""
    inputs: str
    """Hash of the sizes and times of the scene's files: a worker that has read others must read again."""
    frames: tuple[int, int]
    """First and last time code of the crowd."""
    options: MotionOptions
    limits: Limits
    folder: str
    files: ChunkFiles
    agents: tuple[str, ...]
    references: tuple[tuple[str, str], ...]
    """Asset and prim path of each agent's character, as the layers refer to it."""
    hashes: tuple[str, ...]
    """Of everything each agent is made from."""
    content_hash: str
    """Of everything the chunk is made from."""
    keeps_examples: bool = False
    """Whether the clips' analysis is kept in the folder."""
    earlier: tuple[ChunkFiles | None, ...] = ()
    """Files, relative to the folder, that have each agent made from the same; None or nothing at all = none have."""


@dataclass(frozen=True, kw_only=True)
class EarlyTask:
    """What a worker is told of a scene while others still find out which chunks there are; fields as of `ChunkTask`."""

    scene: str
    inputs: str
    options: MotionOptions
    limits: Limits
    folder: str
    chunk_size: int
    """How many agents a chunk is to have."""
    agents: tuple[str, ...] = ()
    """Of a chunk that there is; nobody = everybody will be asked for."""
    gives_examples: bool = False
    """Whether who asks wants back what is cut of the clips."""


def cut_chunks(
    scene: Scene,
    references: Sequence[tuple[str, str]],
    *,
    names: Sequence[str],
    folder: Path,
    options: MotionOptions,
    limits: Limits,
    size: int,
) -> tuple[ChunkTask, ...]:
    """The agents of a scene, in its order, `size` to a chunk.

    An agent that is muted or cannot be read keeps its place, so that the other chunks stay as they are without it.

    Args:
        scene: As read.
        references: Asset and prim path of each character of the scene.
        names: Of all agents that were asked for.
        folder: Where the crowd goes.
        options: Of the sources of motion.
        limits: How much of a scene is read.
        size: Agents a chunk.
    """
    readable = {agent.name: agent for agent in scene.crowd.everyone}
    hashes = _Hashes(scene, references, options)
    inputs = inputs_of(scene.stage.layers, folder)
    parts = [
        [readable[name] for name in names[start : start + size] if name in readable]
        for start in range(0, len(names), size)
    ]
    return tuple(
        ChunkTask(
            index=index,
            scene=scene.stage.identifier,
            inputs=inputs,
            frames=(int(scene.frame_codes[0]), int(scene.frame_codes[-1])),
            options=options,
            limits=limits,
            folder=str(folder),
            files=chunk_files(index, len(parts)),
            agents=tuple(agent.name for agent in part),
            references=tuple(references[agent.character] for agent in part),
            hashes=hashed,
            content_hash=content_hash(hashed),
            keeps_examples=len(parts) >= LARGE_CROWD,
        )
        for index, part in enumerate(parts)
        if part
        for hashed in [hashes.of(part)]
    )


def early_task(task: ChunkTask) -> EarlyTask:
    """What makes a worker ready for a chunk, and for others of the scene."""
    return EarlyTask(
        scene=task.scene,
        inputs=task.inputs,
        options=task.options,
        limits=task.limits,
        folder=task.folder,
        chunk_size=len(task.agents),
        agents=task.agents,
    )


def inputs_of(layers: Sequence[str], folder: Path) -> str:
    """Hash of the sizes and times of a scene's files, and of what artists changed; those in memory have none."""
    layers = (*layers, str(folder / File.OVERRIDES))
    found = [os.stat(layer) if os.path.isfile(layer) else None for layer in layers]
    return content_hash(list(layers), [(status.st_size, status.st_mtime_ns) if status else None for status in found])


class _Hashes:
    """Content hashes of agents; what they share is hashed once."""

    def __init__(self, scene: Scene, references: Sequence[tuple[str, str]], options: MotionOptions) -> None:
        stage, crowd = scene.stage, scene.crowd
        versions = {"usdfoot": __version__, **library_versions()}
        self._times = crowd.frame_times
        self._placements = scene.placements
        self._visibility = scene.visibility
        self._own_attributes = scene.own_attributes
        self._common = content_hash(
            versions, options, stage.units, stage.frames_per_second, crowd.terrain, crowd.frame_rate
        )
        self._libraries = [library_hash(library) for library in crowd.libraries]
        self._characters = [
            content_hash(
                _placeless(character), reference, self._times if len(character.skeleton_to_agent) > 1 else None
            )
            for character, reference in zip(scene.characters, references, strict=True)
        ]

    def of(self, agents: Sequence[Agent | Follower]) -> tuple[str, ...]:
        """One an agent. Frames count only as far as they lie within its own interval: outside it has none."""
        starts, stops = np.array([agent.interval for agent in agents]).T
        last = len(self._times) - 1
        begins = np.maximum(self._times.searchsorted(starts, side="right") - 1, 0)
        ends = np.minimum(self._times.searchsorted(stops), last)
        frames = zip(self._times[begins].tolist(), self._times[ends].tolist(), strict=True)
        return tuple(self._hash_of(agent, between) for agent, between in zip(agents, frames, strict=True))

    def _hash_of(self, agent: Agent | Follower, frames: tuple[float, float]) -> str:
        said = (self._placements, self._visibility, self._own_attributes)
        placed = [by_name.get(agent.name) for by_name in said]
        shared = self._common, self._libraries[agent.library], self._characters[agent.character]
        return content_hash(_unnumbered(agent), placed, frames, *shared)


def _unnumbered(agent: Agent | Follower) -> Agent | Follower:
    """The agent as it is whatever the numbers of its library and character, which others change."""
    same = object.__new__(type(agent))  # a fifth of the time of `replace`
    vars(same).update({**vars(agent), "library": 0, "character": 0})
    return same


def _placeless(character: Character) -> Character:
    """The character as it is whichever of its agents is read first."""
    return replace(character, path="", skeleton=replace(character.skeleton, name=""))
