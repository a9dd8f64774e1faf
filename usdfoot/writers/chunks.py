"""Chunks: what one worker writes of a crowd, with the record of what it was made from."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pxr import Sdf

from usdfoot.bridge.chunks import ChunkLayers, ChunkNotes
from usdfoot.bridge.scene import Scene
from usdfoot.bridge.tokens import PROVENANCE, ChunkFiles, File, Prim, Record
from usdfoot.model.motion import Motion
from usdfoot.writers.agents import agent_samples, write_agent
from usdfoot.writers.animations import animation_samples, write_animation
from usdfoot.writers.crate.sampled import Samples
from usdfoot.writers.footsteps import print_models, write_executed_plan
from usdfoot.writers.layers import LayerFormat, author_format, define_prim, new_layer
from usdfoot.writers.moving import follow_transforms
from usdfoot.writers.poses import PosedAgent, RestingCharacter, pose_agents, rest_character
from usdfoot.writers.samples import copy_unsampled, sampled_layer, sampled_prims
from usdfoot.writers.staging import staged_files

__all__ = ["write_chunk"]


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
        base: Layers that have those without a motion as they are to be; may be changed. None = everybody has one.
        notes: What the chunk says of its making.

    Raises:
        OutputError: If the folder cannot be written to.
    """
    notes = notes or ChunkNotes()
    made_from = {Record.CONTENT_HASH: notes.content_hash}
    told = {Record.AGENT_HASHES: dict(notes.agent_hashes), Record.REPORT: notes.record}
    chunk = _chunk_of(scene, motions, references, names, base)
    agents, footsteps, anims = (f"{File.PENDING}/{name}" for name in files)
    with staged_files(Path(os.path.realpath(folder))) as staged:
        staged.save_layer(agents, _agents_layer(chunk, staged.reserve(agents), made_from))
        staged.add_layer(footsteps, _footsteps_layer(chunk, made_from))
        # While this is missing, the chunk is not done.
        staged.save_layer(anims, _anims_layer(chunk, staged.reserve(anims), {**made_from, **told}))


@dataclass(frozen=True, kw_only=True)
class _Chunk:
    """What the layers of a chunk are written from."""

    scene: Scene
    cast: Sequence[RestingCharacter]
    """The scene's characters."""
    posed: Mapping[str, PosedAgent]
    """Agents that are made, by name."""
    names: Sequence[str]
    """Those and the agents that are kept, in order."""
    base: ChunkLayers | None
    """Layers that have the agents that are kept."""
    references: Mapping[str, tuple[str, str]]
    """Asset and prim path of the character of each agent that is made."""
    layer_format: LayerFormat


def _chunk_of(
    scene: Scene,
    motions: Sequence[Motion],
    references: Sequence[tuple[str, str]],
    names: Sequence[str] | None,
    base: ChunkLayers | None,
) -> _Chunk:
    """The motions posed, and how the layers begin."""
    units = scene.stage.units
    by_name = {agent.name: agent for agent in scene.crowd.agents}
    cast = [rest_character(character) for character in scene.characters]
    held = [
        follow_transforms(motion, cast[by_name[motion.name].character], scene.crowd.frame_times) for motion in motions
    ]
    posed = {agent.motion.name: agent for agent in pose_agents(held, units)}
    order = [*posed] if names is None else names
    codes = [posed[name].codes if name in posed else _kept_codes(base, name) for name in order]
    return _Chunk(
        scene=scene,
        cast=cast,
        posed=posed,
        names=order,
        base=base,
        references=dict(zip(posed, references, strict=True)),
        layer_format=LayerFormat(
            units=units,
            frames_per_second=scene.stage.frames_per_second,
            start_code=min(round(own[0]) for own in codes),
            end_code=max(round(own[-1]) for own in codes),
        ),
    )


def _kept_codes(base: ChunkLayers | None, name: str) -> Sequence[float]:
    """Time codes of an agent that is kept."""
    return base.anims.ListTimeSamplesForPath(f"{Prim.ANIMS}/{name}.rotations") if base else ()


def _agents_layer(chunk: _Chunk, file: Path, notes: Mapping[str, Any]) -> Sdf.Layer:
    """A new file's layer with the agents."""
    units = chunk.scene.stage.units
    base = (chunk.base.agents, chunk.base.agents_file) if chunk.base else None
    layer = _sampled_layer(chunk, file, Prim.AGENTS, lambda agent: agent_samples(agent, units), base, notes)
    with Sdf.ChangeBlock():
        for name, agent in chunk.posed.items():
            write_agent(
                layer,
                agent,
                reference=Sdf.Reference(*chunk.references[name]),
                units=units,
                visibility=chunk.scene.visibility.get(name, ()),
            )
    return layer


def _anims_layer(chunk: _Chunk, file: Path, notes: Mapping[str, Any]) -> Sdf.Layer:
    """A new file's layer with the animations."""
    base = (chunk.base.anims, chunk.base.anims_file) if chunk.base else None
    layer = _sampled_layer(chunk, file, Prim.ANIMS, animation_samples, base, notes)
    with Sdf.ChangeBlock():
        for agent in chunk.posed.values():
            write_animation(layer, agent, units=chunk.scene.stage.units)
    return layer


def _sampled_layer(
    chunk: _Chunk,
    file: Path,
    scope: str,
    sample: Callable[[PosedAgent], dict[str, Samples]],
    base: tuple[Sdf.Layer, Path] | None,
    notes: Mapping[str, Any],
) -> Sdf.Layer:
    """A new file's layer with the samples of everybody, and with all else of the agents that are kept."""
    posed = chunk.posed
    kept = {name: base[0].GetPrimAtPath(f"{scope}/{name}") for name in chunk.names if base and name not in posed}
    samples = sampled_prims(base[1], [*kept.values()]) if base else {}
    samples |= {name: sample(agent) for name, agent in posed.items()}
    layer = sampled_layer(file, scope, {name: samples[name] for name in chunk.names})
    author_format(layer, chunk.layer_format)
    layer.customLayerData = {PROVENANCE: notes}
    define_prim(layer, Prim.CROWD, "Xform")
    define_prim(layer, scope, "Scope")
    with Sdf.ChangeBlock():
        for name, spec in kept.items():
            copy_unsampled(spec, layer.GetPrimAtPath(f"{scope}/{name}"))
    return layer


def _footsteps_layer(chunk: _Chunk, notes: Mapping[str, Any]) -> Sdf.Layer:
    """A layer with the plans as executed."""
    layer, units = chunk.base.footsteps if chunk.base else new_layer(chunk.layer_format), chunk.scene.stage.units
    author_format(layer, chunk.layer_format)
    layer.customLayerData = {PROVENANCE: notes}
    _lay_out(layer, Prim.PLANS, chunk.names, chunk.posed)
    prints = [print_models(resting.foot_length, units) for resting in chunk.cast]
    by_name = {agent.name: agent for agent in chunk.scene.crowd.agents}
    with Sdf.ChangeBlock():
        for name, agent in chunk.posed.items():
            write_executed_plan(
                layer,
                name,
                by_name[name].plan,
                results=agent.motion.results,
                prints=prints[by_name[name].character],
                units=units,
                frame=chunk.scene.plan_frames.get(name),
            )
    return layer


def _lay_out(layer: Sdf.Layer, scope: str, names: Sequence[str], made: Collection[str]) -> None:
    """Has a layer hold the prims of the agents named, in that order, those of agents to be `made` empty.

    The others come in that order already. A prim takes its place among others only where it gets another name.
    """
    aside = "_" * (1 + max(len(name) for name in names))  # no agent's name
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
