"""Chunks: what one worker writes of a crowd, with the record of what it was made from."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from pathlib import Path

from pxr import Sdf

from usdfoot.bridge.chunks import ChunkLayers, ChunkNotes
from usdfoot.bridge.scene import Scene
from usdfoot.bridge.tokens import PROVENANCE, ChunkFiles, File, Prim, Record
from usdfoot.model.motion import Motion
from usdfoot.writers.agents import agent_samples, write_agent
from usdfoot.writers.animations import animation_samples, write_animation
from usdfoot.writers.footsteps import print_models, write_executed_plan
from usdfoot.writers.layers import LayerFormat, define_prim, new_layer
from usdfoot.writers.moving import follow_transforms
from usdfoot.writers.poses import pose_agents, rest_character
from usdfoot.writers.samples import sampled_attributes
from usdfoot.writers.staging import staged_files

__all__ = ["write_chunk"]

SCOPES = {"agents": Prim.AGENTS, "footsteps": Prim.PLANS, "anims": Prim.ANIMS}
"""Where the agents are in each of a chunk's layers."""


def write_chunk(
    scene: Scene,
    motions: Sequence[Motion],
    folder: str | os.PathLike[str],
    *,
    files: ChunkFiles,
    references: Sequence[tuple[str, str]],
    names: Sequence[str] | None = None,
    base: ChunkLayers | None = None,
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
        base: Layers that have those without a motion as they are to be; they are changed. None = everybody has one.
        notes: What the chunk says of its making.

    Raises:
        OutputError: If the folder cannot be written to.
    """
    order = [motion.name for motion in motions] if names is None else names
    notes = notes or ChunkNotes()
    made_from = {Record.CONTENT_HASH: notes.content_hash}
    told = {Record.AGENT_HASHES: dict(notes.agent_hashes), Record.REPORT: notes.record}
    with staged_files(Path(os.path.realpath(folder))) as staged:
        samples = staged.scratch(f"{File.PENDING}/{files.anims}")
        layers = _chunk_layers(scene, motions, references, order, base, samples)
        layers.agents.customLayerData = layers.footsteps.customLayerData = {PROVENANCE: made_from}
        layers.anims.customLayerData = {PROVENANCE: {**made_from, **told}}
        staged.add_layer(f"{File.PENDING}/{files.agents}", layers.agents)
        staged.add_layer(f"{File.PENDING}/{files.footsteps}", layers.footsteps)
        staged.add_layer(f"{File.PENDING}/{files.anims}", layers.anims)  # while it is missing, the chunk is not done


def _chunk_layers(
    scene: Scene,
    motions: Sequence[Motion],
    references: Sequence[tuple[str, str]],
    names: Sequence[str],
    base: ChunkLayers | None,
    samples: Path,
) -> ChunkLayers:
    """The layers with all agents of a chunk, whose samples are in a file of their own until the layers are saved."""
    units = scene.stage.units
    by_name = {agent.name: agent for agent in scene.crowd.agents}
    cast = [rest_character(character) for character in scene.characters]
    held = [
        follow_transforms(motion, cast[by_name[motion.name].character], scene.crowd.frame_times) for motion in motions
    ]
    layers = _empty_layers(scene) if base is None else base
    _lay_out(layers, names, {motion.name for motion in motions})
    prints = [print_models(resting.foot_length, units) for resting in cast]
    posed = list(pose_agents(held, units))
    attributes = sampled_attributes(
        [agent_samples(agent, units) | animation_samples(agent) for agent in posed], samples
    )
    for agent, sampled, reference in zip(posed, attributes, references, strict=True):
        source = by_name[agent.motion.name]
        with Sdf.ChangeBlock():
            write_agent(
                layers.agents,
                agent,
                sampled,
                reference=Sdf.Reference(*reference),
                units=units,
                visibility=scene.visibility.get(source.name, ()),
            )
            write_animation(layers.anims, agent, sampled, units=units)
            write_executed_plan(
                layers.footsteps,
                source.name,
                source.plan,
                results=agent.motion.results,
                prints=prints[source.character],
                units=units,
                frame=scene.plan_frames.get(source.name),
            )
    codes = [_span(layers.anims, name) for name in names]
    for layer in (layers.agents, layers.footsteps, layers.anims):
        layer.startTimeCode, layer.endTimeCode = min(first for first, _ in codes), max(last for _, last in codes)
    return layers


def _empty_layers(scene: Scene) -> ChunkLayers:
    """Layers of a chunk without anybody."""
    layer_format = LayerFormat(
        units=scene.stage.units, frames_per_second=scene.stage.frames_per_second, start_code=0.0, end_code=0.0
    )
    return ChunkLayers(**{name: new_layer(layer_format) for name in SCOPES})


def _lay_out(layers: ChunkLayers, names: Sequence[str], made: Collection[str]) -> None:
    """Has the layers hold the prims of the agents named, in that order, those of agents to be `made` empty.

    The others come in that order already. A prim takes its place among others only where it gets another name.
    """
    aside = "_" * (1 + max(len(name) for name in names))  # no agent's name
    for field, scope in SCOPES.items():
        layer = getattr(layers, field)
        prim = define_prim(layer, scope, "Scope")
        with Sdf.ChangeBlock():
            for gone in [child.name for child in prim.nameChildren if child.name in made or child.name not in names]:
                del prim.nameChildren[gone]
        for index, name in enumerate(names):
            if index == len(prim.nameChildren):
                Sdf.CreatePrimInLayer(layer, f"{scope}/{name}")
            elif name in made:
                edits = Sdf.BatchNamespaceEdit()
                edits.Add(Sdf.CreatePrimInLayer(layer, f"{scope}/{aside}").path, f"{scope}/{name}", index)
                layer.Apply(edits)


def _span(anims: Sdf.Layer, name: str) -> tuple[int, int]:
    """Whole time codes of an agent's first and last sample."""
    codes = anims.ListTimeSamplesForPath(f"{Prim.ANIMS}/{name}.rotations")
    return round(codes[0]), round(codes[-1])
