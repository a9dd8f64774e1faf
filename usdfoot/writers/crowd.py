"""Writes a crowd: one layer per concern, all of them or none (design.md section 3)."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pxr import Sdf

from usdfoot.bridge.scene import Scene
from usdfoot.bridge.tokens import File, Prim, anims_chunk
from usdfoot.errors import OutputError
from usdfoot.model.motion import Motion
from usdfoot.writers.agents import write_agent
from usdfoot.writers.animations import write_animation
from usdfoot.writers.characters import place_characters
from usdfoot.writers.footsteps import write_executed_plan
from usdfoot.writers.layers import LayerFormat, define_prim, new_layer
from usdfoot.writers.moving import follow_transforms
from usdfoot.writers.poses import rest_character
from usdfoot.writers.root import expanded_layer, root_layer, stacked_layer
from usdfoot.writers.staging import staged_files

__all__ = ["check_output", "write_crowd"]


def write_crowd(
    scene: Scene,
    motions: Sequence[Motion],
    folder: str | os.PathLike[str],
    *,
    provenance: Mapping[str, Any],
    report: Mapping[str, Any],
    collect: bool = False,
) -> tuple[Path, ...]:
    """Write crowd.usd and all that belongs to it into a folder.

    Args:
        scene: What was read: units, characters, agents.
        motions: Finished motions, named like the agents of the scene's crowd.
        folder: Where to; made if it does not exist. Files of an earlier run are replaced, `overrides.usda` is kept.
        provenance: For `customLayerData["usdfoot"]` of crowd.usd.
        report: For report.json; content hashes of the written files are added as "files".

        collect: Copy the characters' files into the folder instead of referencing them where they are.

    Returns:
        Paths of crowd.usd and report.json.

    Raises:
        OutputError: If the folder cannot be written to, or the output would replace a layer of the scene.
    """
    target = Path(os.path.realpath(folder))
    check_output(scene, target)
    layer_format = crowd_format(scene)
    placed = place_characters(scene.characters, target, layer_format=layer_format, collect=collect)
    layers = _body_layers(scene, motions, [character.reference for character in placed], layer_format)
    with staged_files(target) as files:
        for copied in (character.copy for character in placed if character.copy):
            files.add_layer(copied.name, copied.layer)
            for name, path in copied.files.items():
                files.add_file(name, path)
        for name, layer in layers.items():
            files.add_layer(name, layer)
        files.add_layer(File.EXPANDED, expanded_layer(layer_format, [motion.name for motion in motions]))
        files.add_text(File.REPORT, _readable({**report, "files": files.content_hashes()}) + "\n")
        if not (target / File.OVERRIDES).exists():
            files.add_layer(File.OVERRIDES, stacked_layer(layer_format, ()))
        files.add_layer(File.CROWD, root_layer(layer_format, provenance))
    return target / File.CROWD, target / File.REPORT


def _readable(report: Mapping[str, Any]) -> str:
    """The report as JSON, one line for each entry of its lists and mappings."""
    lines = []
    for key, value in sorted(report.items()):
        if isinstance(value, Mapping):
            entries = [f"{json.dumps(name)}: {_compact(value[name])}" for name in sorted(value)]
            text = "{\n  " + ",\n  ".join(entries) + "\n }" if entries else "{}"
        elif isinstance(value, Sequence) and not isinstance(value, str):
            text = "[\n  " + ",\n  ".join(map(_compact, value)) + "\n ]" if value else "[]"
        else:
            text = _compact(value)
        lines.append(f" {json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(lines) + "\n}"


def _compact(value: object) -> str:
    return json.dumps(value, sort_keys=True, allow_nan=False)


def crowd_format(scene: Scene) -> LayerFormat:
    """Stage metadata of the crowd: the scene's units and rates, and the range of its frames."""
    return LayerFormat(
        units=scene.stage.units,
        frames_per_second=scene.stage.frames_per_second,
        start_code=float(scene.frame_codes[0]),
        end_code=float(scene.frame_codes[-1]),
    )


def check_output(scene: Scene, folder: Path) -> None:
    """Raise an OutputError if a file to be written is a layer of the scene."""
    outputs = {folder / name for name in (File.CROWD, File.OVERRIDES, File.AGENTS, File.FOOTSTEPS, File.ANIMS)}
    outputs |= {folder / name for name in (File.EXPANDED, anims_chunk(0))}
    layers = {Path(os.path.realpath(layer)) for layer in scene.stage.layers}
    over = sorted(str(path) for path in outputs & layers)
    if over:
        raise OutputError(folder, "the output would replace layers of the scene", "name another folder", over)


def _body_layers(
    scene: Scene, motions: Sequence[Motion], references: Sequence[Sdf.Reference], layer_format: LayerFormat
) -> dict[str, Sdf.Layer]:
    """Layers of agents, footsteps and animations by file name."""
    agents, footsteps, chunk = (new_layer(layer_format) for _ in range(3))
    by_name = {agent.name: agent for agent in scene.crowd.agents}
    cast = [rest_character(character) for character in scene.characters]
    units = layer_format.units
    with Sdf.ChangeBlock():
        for layer, scope in ((agents, Prim.AGENTS), (footsteps, Prim.PLANS), (chunk, Prim.ANIMS)):
            define_prim(layer, scope, "Scope")
    for motion in motions:
        agent = by_name[motion.name]
        reference = references[agent.character]
        held, resting = follow_transforms(motion, cast[agent.character], scene.crowd.frame_times)
        with Sdf.ChangeBlock():
            write_agent(agents, held, resting=resting, reference=reference, units=units)
            write_animation(chunk, held, resting=resting, units=units)
            write_executed_plan(
                footsteps, motion.name, agent.plan, results=motion.results, size=resting.foot_length, units=units
            )
    stack = stacked_layer(layer_format, [anims_chunk(0)])
    return {anims_chunk(0): chunk, File.ANIMS: stack, File.FOOTSTEPS: footsteps, File.AGENTS: agents}
