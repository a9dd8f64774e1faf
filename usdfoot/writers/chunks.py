"""Chunks: what one worker writes of a crowd, with the record of what it was made from."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot.bridge.chunk_files import ChunkFiles
from usdfoot.bridge.chunks import ChunkNotes
from usdfoot.bridge.placements import AgentOps
from usdfoot.bridge.scene import Scene
from usdfoot.bridge.tokens import PROVENANCE, File, Prim, Record
from usdfoot.maths.types import FloatArray
from usdfoot.model.motion import Motion
from usdfoot.writers.agents import agent_spec
from usdfoot.writers.animations import animation_spec
from usdfoot.writers.attributes import layer_spec
from usdfoot.writers.crate.kept import KeptPrim
from usdfoot.writers.crate.reading import read_layer
from usdfoot.writers.crate.specs import PackedSamples, Spec
from usdfoot.writers.footsteps import executed_plan, print_models
from usdfoot.writers.layers import LayerFormat
from usdfoot.writers.levels import place_in_levels
from usdfoot.writers.moving import follow_transforms
from usdfoot.writers.own_attributes import own_specs
from usdfoot.writers.placed import hold_root
from usdfoot.writers.poses import PosedAgent, RestingCharacter, pose_agents, rest_character
from usdfoot.writers.staging import staged_files

__all__ = ["ChunkPrims", "read_chunk", "write_chunk"]


@dataclass(frozen=True, kw_only=True)
class ChunkPrims:
    """The prims of a chunk's agents by name, as they are written."""

    agents: Mapping[str, KeptPrim]
    footsteps: Mapping[str, KeptPrim]
    anims: Mapping[str, KeptPrim]


def read_chunk(folder: Path, files: ChunkFiles) -> tuple[ChunkPrims, ChunkNotes]:
    """The prims of a chunk that `write_chunk` wrote, and what it says of its making.

    Args:
        folder: Of the crowd.
        files: Names of the chunk's files, relative to the folder.

    Raises:
        OSError: If a file cannot be read.
        ValueError, LookupError, struct.error: If something else wrote it, or its files are not of one making.
    """
    said, agents = read_layer(folder / files.agents, Prim.AGENTS)
    also_said, footsteps = read_layer(folder / files.footsteps, Prim.PLANS)
    data, anims = read_layer(folder / files.anims, Prim.ANIMS)
    told, made_from = data[PROVENANCE], data[PROVENANCE][Record.CONTENT_HASH]
    if any(layer[PROVENANCE][Record.CONTENT_HASH] != made_from for layer in (said, also_said)):
        raise ValueError("the files are not of one making")
    notes = ChunkNotes(content_hash=made_from, agent_hashes=told[Record.AGENT_HASHES], record=told[Record.REPORT])
    return ChunkPrims(agents=agents, footsteps=footsteps, anims=anims), notes


def write_chunk(
    scene: Scene,
    motions: Sequence[Motion],
    folder: str | os.PathLike[str],
    *,
    files: ChunkFiles,
    references: Sequence[tuple[str, str]],
    names: Sequence[str] | None = None,
    base: ChunkPrims | None = None,
    notes: ChunkNotes | None = None,
) -> None:
    """Write the agents, footsteps and animations of one chunk of a crowd, to wait until all chunks are done.

    Every layer carries the content hash, and that of the animations the other notes, in its `customLayerData`.

    Args:
        scene: The chunk's agents and their characters.
        motions: Finished motions, named like agents of the scene.
        folder: Of the crowd; the chunk goes into a folder of it.
        files: Names of the chunk's files.
        references: Asset and prim path by which each motion's agent refers to its character.
        names: All agents in the order in which they are written; None = as the motions come.
        base: Prims of those without a motion, and perhaps others. None = everybody has one.
        notes: What the chunk says of its making.

    Raises:
        OutputError: If the folder cannot be written to.
    """
    notes = notes or ChunkNotes()
    made_from = {Record.CONTENT_HASH: notes.content_hash}
    told = {Record.AGENT_HASHES: dict(notes.agent_hashes), Record.REPORT: notes.record}
    cast = [rest_character(character) for character in scene.characters]
    posed = _pose(scene, motions, cast)
    order = [*posed] if names is None else names
    anims = _in_order(order, _anims(scene, posed), base.anims if base else {})
    layer_format = _format(scene, [_codes(spec) for spec in anims.values()])

    def layer(scope: str, prims: Mapping[str, Spec | KeptPrim], said: dict[str, Any]) -> Spec:
        return layer_spec(layer_format, scope, prims, data={PROVENANCE: said})

    agents = _in_order(order, _agents(scene, posed, references), base.agents if base else {})
    footsteps = _in_order(order, _footsteps(scene, posed, cast), base.footsteps if base else {})
    with staged_files(Path(os.path.realpath(folder))) as staged:
        staged.add_specs(f"{File.PENDING}/{files.agents}", layer(Prim.AGENTS, agents, made_from))
        staged.add_specs(f"{File.PENDING}/{files.footsteps}", layer(Prim.PLANS, footsteps, made_from))
        # While this is missing, the chunk is not done.
        staged.add_specs(f"{File.PENDING}/{files.anims}", layer(Prim.ANIMS, anims, {**made_from, **told}))


def _pose(scene: Scene, motions: Sequence[Motion], cast: Sequence[RestingCharacter]) -> dict[str, PosedAgent]:
    """The motions posed, by agent."""
    by_name = {agent.name: agent for agent in scene.crowd.agents}
    followed = [
        follow_transforms(motion, cast[by_name[motion.name].character], scene.crowd.frame_times) for motion in motions
    ]
    held = [(motion, hold_root(motion, resting, _ops(scene, motion.name))) for motion, resting in followed]
    return {agent.motion.name: agent for agent in pose_agents(held, scene.stage.units)}


def _ops(scene: Scene, name: str) -> AgentOps | None:
    """Transforms that artists authored over an agent."""
    placement = scene.placements.get(name)
    return placement.agent if placement else None


def _in_order(
    names: Sequence[str], made: Mapping[str, Spec], kept: Mapping[str, KeptPrim]
) -> dict[str, Spec | KeptPrim]:
    return {name: made[name] if name in made else kept[name] for name in names}


def _codes(animation: Spec | KeptPrim) -> FloatArray:
    """Time codes of an animation."""
    if isinstance(animation, KeptPrim):
        samples = animation.layer.field(animation.rows, "rotations", "timeSamples")
    else:
        samples = animation.below[".rotations"].fields["timeSamples"]
    return samples.codes if isinstance(samples, PackedSamples) else np.zeros(1)


def _format(scene: Scene, codes: Sequence[FloatArray]) -> LayerFormat:
    """How layers with the agents of these time codes begin."""
    return LayerFormat(
        units=scene.stage.units,
        frames_per_second=scene.stage.frames_per_second,
        start_code=min(round(own[0]) for own in codes),
        end_code=max(round(own[-1]) for own in codes),
    )


def _agents(scene: Scene, posed: Mapping[str, PosedAgent], references: Sequence[tuple[str, str]]) -> dict[str, Spec]:
    return {
        name: agent_spec(
            agent,
            reference=reference,
            units=scene.stage.units,
            ops=_ops(scene, name),
            visibility=scene.visibility.get(name, ()),
            own=own_specs(
                scene.own_attributes.get(name, {}), character=f"{Prim.AGENTS}/{name}{place_in_levels(reference)}"
            ),
        )
        for (name, agent), reference in zip(posed.items(), references, strict=True)
    }


def _anims(scene: Scene, posed: Mapping[str, PosedAgent]) -> dict[str, Spec]:
    return {name: animation_spec(agent, units=scene.stage.units) for name, agent in posed.items()}


def _footsteps(scene: Scene, posed: Mapping[str, PosedAgent], cast: Sequence[RestingCharacter]) -> dict[str, Spec]:
    """The plans as executed."""
    units = scene.stage.units
    prints = [print_models(resting.foot_length, units) for resting in cast]
    by_name = {agent.name: agent for agent in scene.crowd.agents}
    return {
        name: executed_plan(
            f"{Prim.PLANS}/{name}",
            by_name[name].plan,
            results=agent.motion.results,
            prints=prints[by_name[name].character],
            units=units,
            placement=scene.placements.get(name),
        )
        for name, agent in posed.items()
    }
