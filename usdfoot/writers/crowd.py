"""Writes what holds a crowd's chunks together: one layer per concern (design.md section 3)."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from usdfoot.bridge.chunks import JsonText
from usdfoot.bridge.file_hashes import mark_unchanged
from usdfoot.bridge.scene import Scene
from usdfoot.bridge.tokens import ChunkFiles, File, Prim, chunk_files, chunk_folder
from usdfoot.errors import OutputError
from usdfoot.writers.belongings import check_foreign, tidy
from usdfoot.writers.layers import LayerFormat
from usdfoot.writers.materials import material_layers
from usdfoot.writers.placing import PlacedCharacter
from usdfoot.writers.root import expanded_layer, root_layer, scope_layer, stacked_layer
from usdfoot.writers.staging import staged_files

__all__ = ["check_output", "write_crowd"]


def write_crowd(
    scene: Scene,
    agents: Sequence[str],
    folder: str | os.PathLike[str],
    *,
    chunks: Sequence[ChunkFiles],
    characters: Sequence[PlacedCharacter],
    collect: bool = False,
    provenance: Mapping[str, Any],
    report: Mapping[str, Any],
    intact: Mapping[str, str],
) -> tuple[Path, ...]:
    """Write crowd.usd and all around the chunks, which are there already; till now an earlier crowd was as it was.

    Args:
        scene: What was read: units and range.
        agents: Names of all agents written.
        folder: Where to. Files of an earlier run are replaced, `overrides.usda` is kept.
        chunks: Files of the chunks.
        characters: Copied if they must be.
        collect: Copy the materials that agents are bound to.
        provenance: For `customLayerData["usdfoot"]` of crowd.usd.
        intact: SHA-256 of files that are there and were not written anew, by name.
        report: For report.json; content hashes of the written files are added as "files".

    Returns:
        Paths of crowd.usd and report.json.

    Raises:
        OutputError: If the folder cannot be written to, or the output would replace a layer of the scene.
    """
    target = Path(os.path.realpath(folder))
    check_output(scene, target)
    layer_format = crowd_format(scene)
    materials = material_layers(scene, target, layer_format=layer_format, collect=collect)
    with staged_files(target) as files:
        for chunk in chunks:
            place = chunk_folder(target, chunk)
            for name in chunk:
                files.adopt(name, place / name, content_hash=intact.get(name) if place == target else None)
        for copied in (*(copied for character in characters for copied in character.copies), *materials):
            files.add_layer(copied.name, copied.layer)
            for name, path in copied.files.items():
                files.add_file(name, path)
        files.add_layer(File.ANIMS, stacked_layer(layer_format, [chunk.anims for chunk in chunks], text=True))
        if File.AGENTS not in chunks[0]:  # of several, even if only one has anybody
            for name, scope, parts in (
                (File.AGENTS, Prim.AGENTS, [chunk.agents for chunk in chunks]),
                (File.FOOTSTEPS, Prim.PLANS, [chunk.footsteps for chunk in chunks]),
            ):
                files.add_joined(name, scope_layer(layer_format, scope), map(files.place_of, parts), scope=scope)
        files.add_layer(File.EXPANDED, expanded_layer(layer_format, agents))
        hashes = files.content_hashes()
        files.add_text(File.REPORT, _readable({**report, "files": hashes}) + "\n")
        if not (target / File.OVERRIDES).exists():
            files.add_layer(File.OVERRIDES, stacked_layer(layer_format, (), text=True))
        files.add_layer(File.CROWD, root_layer(layer_format, provenance, has_materials=bool(materials)))
    tidy(target, chunks, has_materials=bool(materials))
    mark_unchanged([target / name for name in hashes], marked=target / File.REPORT)
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
    return value if isinstance(value, JsonText) else json.dumps(value, sort_keys=True, allow_nan=False)


def crowd_format(scene: Scene) -> LayerFormat:
    """Stage metadata of the crowd: the scene's units and rates, and the range of its frames."""
    return LayerFormat(
        units=scene.stage.units,
        frames_per_second=scene.stage.frames_per_second,
        start_code=float(scene.frame_codes[0]),
        end_code=float(scene.frame_codes[-1]),
    )


def check_output(scene: Scene, folder: Path) -> None:
    """Raise an OutputError if a file to be written is a layer of the scene, or is there and not usdfoot's."""
    names = File.CROWD, File.OVERRIDES, File.ANIMS, File.EXPANDED, File.MATERIALS
    outputs = {folder / name for name in names}
    outputs |= {folder / name for name in chunk_files(0, 1)}
    layers = {Path(os.path.realpath(layer)) for layer in scene.stage.layers}
    over = sorted(str(path) for path in outputs & layers)
    if over:
        raise OutputError(folder, "the output would replace layers of the scene", "name another folder", over)
    check_foreign(folder)
