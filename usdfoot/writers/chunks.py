"""Chunks: what one worker writes of a crowd, with the record of what it was made from."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from pxr import Sdf

from usdfoot.bridge.scene import Scene
from usdfoot.bridge.tokens import PROVENANCE, ChunkFiles, File, Prim, Record
from usdfoot.model.motion import Motion
from usdfoot.writers.agents import write_agent
from usdfoot.writers.animations import write_animation
from usdfoot.writers.footsteps import print_models, write_executed_plan
from usdfoot.writers.layers import LayerFormat, define_prim, new_layer
from usdfoot.writers.moving import follow_transforms
from usdfoot.writers.poses import pose_agents, rest_character
from usdfoot.writers.staging import staged_files

__all__ = ["write_chunk"]


def write_chunk(
    scene: Scene,
    motions: Sequence[Motion],
    folder: str | os.PathLike[str],
    *,
    files: ChunkFiles,
    references: Sequence[tuple[str, str]],
    content_hash: str = "",
    record: str = "",
) -> None:
    """Write the agents, footsteps and animations of one chunk of a crowd, to wait until all chunks are done.

    Every layer carries the content hash, and that of the animations the record, in its `customLayerData`.

    Args:
        scene: The chunk's agents and their characters.
        motions: Finished motions, named like agents of the scene.
        folder: Of the crowd; the chunk goes into a folder of it.
        files: Names of the chunk's files.
        references: Asset and prim path by which each motion's agent refers to its character.
        content_hash: Of all that the chunk was made from.
        record: What the report says of the chunk, as JSON.

    Raises:
        OutputError: If the folder cannot be written to.
    """
    layers = _chunk_layers(scene, motions, files, references)
    for layer in layers.values():
        layer.customLayerData = {PROVENANCE: {Record.CONTENT_HASH: content_hash}}
    layers[files.anims].customLayerData = {PROVENANCE: {Record.CONTENT_HASH: content_hash, Record.REPORT: record}}
    with staged_files(Path(os.path.realpath(folder))) as staged:
        for name, layer in layers.items():
            staged.add_layer(f"{File.PENDING}/{name}", layer)


def _chunk_layers(
    scene: Scene, motions: Sequence[Motion], files: ChunkFiles, references: Sequence[tuple[str, str]]
) -> dict[str, Sdf.Layer]:
    """Layers by file name, the animations last: while they are missing, the chunk is not done."""
    units = scene.stage.units
    by_name = {agent.name: agent for agent in scene.crowd.agents}
    cast = [rest_character(character) for character in scene.characters]
    held = [
        follow_transforms(motion, cast[by_name[motion.name].character], scene.crowd.frame_times) for motion in motions
    ]
    layer_format = LayerFormat(
        units=units,
        frames_per_second=scene.stage.frames_per_second,
        start_code=round(min(float(units.times_to_codes(motion.times[0])) for motion, _ in held)),
        end_code=round(max(float(units.times_to_codes(motion.times[-1])) for motion, _ in held)),
    )
    agents, footsteps, anims = (new_layer(layer_format) for _ in range(3))
    with Sdf.ChangeBlock():
        for layer, scope in ((agents, Prim.AGENTS), (footsteps, Prim.PLANS), (anims, Prim.ANIMS)):
            define_prim(layer, scope, "Scope")
    prints = [print_models(resting.foot_length, units) for resting in cast]
    for agent, reference in zip(pose_agents(held, units), references, strict=True):
        source = by_name[agent.motion.name]
        with Sdf.ChangeBlock():
            write_agent(agents, agent, reference=Sdf.Reference(*reference), units=units)
            write_animation(anims, agent, units=units)
            write_executed_plan(
                footsteps,
                source.name,
                source.plan,
                results=agent.motion.results,
                prints=prints[source.character],
                units=units,
                frame=scene.plan_frames.get(source.name),
            )
    return {files.agents: agents, files.footsteps: footsteps, files.anims: anims}
