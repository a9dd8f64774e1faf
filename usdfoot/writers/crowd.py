"""Writes what holds a crowd's chunks together: one layer per concern (design.md section 3)."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from usdfoot.bridge.chunk_files import ChunkFiles, chunk_files, chunk_folder
from usdfoot.bridge.file_hashes import mark_unchanged
from usdfoot.bridge.scene import Scene
from usdfoot.bridge.tokens import File, Prim
from usdfoot.errors import OutputError
from usdfoot.writers.belongings import check_foreign, tidy
from usdfoot.writers.joined import JoinedFile
from usdfoot.writers.layers import LayerFormat
from usdfoot.writers.materials import material_layers
from usdfoot.writers.placing import PlacedCharacter
from usdfoot.writers.root import expanded_layer, root_layer, scope_layer, stacked_layer
from usdfoot.writers.staging import StagedFiles, staged_files

__all__ = ["CrowdWriter", "check_output", "crowd_format", "open_crowd"]


@contextmanager
def open_crowd(scene: Scene, folder: str | os.PathLike[str], *, intact: Mapping[str, str]) -> Iterator[CrowdWriter]:
    """What writes crowd.usd and all around the chunks; until the block ends, an earlier crowd is as it was.

    Args:
        scene: What was read: units and range.
        folder: Where to. Files of an earlier run are replaced, `overrides.usda` is kept.
        intact: SHA-256 of files that are there and were not written anew, by name.

    Raises:
        OutputError: If the folder cannot be written to, or the output would replace a layer of the scene.
    """
    target = Path(os.path.realpath(folder))
    check_output(scene, target)
    with staged_files(target) as files:
        crowd = CrowdWriter(scene, files, intact=intact)
        yield crowd
    crowd.settle()


class CrowdWriter:
    """Writes a crowd's layers, of several chunks agents and footsteps as these come: while others are still made.

    Args:
        scene: What was read.
        files: All of the crowd.
        intact: SHA-256 of files that were not written anew, by name.
    """

    def __init__(self, scene: Scene, files: StagedFiles, *, intact: Mapping[str, str]) -> None:
        self._scene, self._files, self._intact = scene, files, intact
        self._format = crowd_format(scene)
        self._chunks: list[ChunkFiles] = []
        self._joined: dict[str, JoinedFile] = {}
        self._hashes: Mapping[str, str] = {}
        self._has_materials = False

    def add_chunk(self, chunk: ChunkFiles) -> None:
        """Adds a chunk that is there, after those before it in the crowd."""
        self._chunks.append(chunk)
        place = chunk_folder(self._files.folder, chunk)
        is_settled = place == self._files.folder
        for name in chunk:
            self._files.adopt(name, place / name, content_hash=self._intact.get(name) if is_settled else None)
        if File.AGENTS in chunk:  # else it is of several, even if only one has anybody
            return
        for name, scope, part in (
            (File.AGENTS, Prim.AGENTS, chunk.agents),
            (File.FOOTSTEPS, Prim.PLANS, chunk.footsteps),
        ):
            if name not in self._joined:
                self._joined[name] = JoinedFile(self._files, name, scope_layer(self._format, scope), scope=scope)
            self._joined[name].add(self._files.place_of(part))

    def finish(
        self,
        agents: Sequence[str],
        *,
        characters: Sequence[PlacedCharacter],
        collect: bool = False,
        provenance: Mapping[str, Any],
        report: Mapping[str, Any],
    ) -> tuple[Path, Path]:
        """Writes what holds the chunks together, all of which are there; paths of crowd.usd and report.json.

        Args:
            agents: Names of all agents written.
            characters: Copied if they must be.
            collect: Copy the materials that agents are bound to.
            provenance: For `customLayerData["usdfoot"]` of crowd.usd.
            report: For report.json; content hashes of the written files are added as "files".
        """
        files, folder = self._files, self._files.folder
        for joined in self._joined.values():
            joined.finish()
        materials = material_layers(self._scene, folder, layer_format=self._format, collect=collect)
        for copied in (*(copied for character in characters for copied in character.copies), *materials):
            files.add_layer(copied.name, copied.layer)
            for name, path in copied.files.items():
                files.add_file(name, path)
        anims = [chunk.anims for chunk in self._chunks]
        files.add_layer(File.ANIMS, stacked_layer(self._format, anims))
        files.add_layer(File.EXPANDED, expanded_layer(self._format, agents))
        self._hashes = files.content_hashes()
        files.add_bytes(File.REPORT, _readable({**report, "files": self._hashes}))
        if not (folder / File.OVERRIDES).exists():
            files.add_layer(File.OVERRIDES, stacked_layer(self._format, ()))
        self._has_materials = bool(materials)
        files.add_layer(File.CROWD, root_layer(self._format, provenance, has_materials=self._has_materials))
        return folder / File.CROWD, folder / File.REPORT

    def settle(self) -> None:
        """Removes what earlier crowds left behind, when all files are where they belong."""
        folder = self._files.folder
        tidy(folder, self._chunks, has_materials=self._has_materials)
        mark_unchanged([folder / name for name in self._hashes], marked=folder / File.REPORT)


def _readable(report: Mapping[str, Any]) -> Iterator[bytes]:
    """The report as JSON in pieces, one line for each entry of its lists and mappings; bytes are JSON already."""
    before = b"{\n"
    for key, value in sorted(report.items()):
        yield before + f' "{key}": '.encode()
        if isinstance(value, Mapping):
            entries = [f"{json.dumps(name)}: ".encode() + _compact(value[name]) for name in sorted(value)]
            yield from _lines(b"{", entries, b"}")
        elif isinstance(value, Sequence) and not isinstance(value, str):
            yield from _lines(b"[", [_compact(entry) for entry in value], b"]")
        else:
            yield _compact(value)
        before = b",\n"
    yield b"\n}\n"


def _lines(start: bytes, entries: Sequence[bytes], end: bytes) -> Iterator[bytes]:
    yield start
    if entries:
        yield b"\n  "
        yield b",\n  ".join(entries)
        yield b"\n "
    yield end


def _compact(value: object) -> bytes:
    return value if isinstance(value, bytes) else json.dumps(value, sort_keys=True, allow_nan=False).encode()


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
