"""Chunks of an earlier run: which there are, and their records."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from pxr import Sdf, Tf

from usdfoot.bridge.chunk_files import ChunkFiles, chunk_folder
from usdfoot.bridge.tokens import PROVENANCE, File, Record

__all__ = ["is_intact", "list_chunks", "read_record"]


def is_intact(folder: Path, files: ChunkFiles, intact: Collection[str]) -> bool:
    """Whether a chunk is part of the crowd in the folder, with all of its files as they were written."""
    return chunk_folder(folder, files) == folder and _all_in(files, intact)


def read_record(
    folder: Path, files: ChunkFiles, content_hash: str, *, intact: Collection[str] | None = None
) -> str | None:
    """The record of a chunk that is there, whole, and made from what the hash stands for; None otherwise.

    It may be part of the crowd or wait to become one.

    Args:
        folder: Of the crowd.
        files: Names of the chunk's files.
        content_hash: What the chunk must be made from.
        intact: Files of the crowd that are as they were written; None = as far as they tell themselves.
    """
    place = chunk_folder(folder, files)
    if place == folder and not _all_in(files, intact):
        return None
    record = None
    for name in files if place != folder or intact is None else (files.anims,):  # what is intact was made together
        notes = _notes(_opened(place / name))
        if notes.get(Record.CONTENT_HASH) != content_hash:
            return None
        record = notes.get(Record.REPORT, record)
    return record


def list_chunks(folder: Path, *, intact: Collection[str] | None = None) -> Iterator[ChunkFiles]:
    """Files, relative to the folder, of the chunks of the crowd and then of those that wait to become one.

    Args:
        folder: Of the crowd.
        intact: As of `read_record`; the crowd's chunks with others are left out.
    """
    anims, agents, footsteps = (str(name).split(".")[0] for name in (File.ANIMS, File.AGENTS, File.FOOTSTEPS))
    for waiting in ("", f"{File.PENDING}/"):
        for path in sorted((folder / waiting).glob(f"{anims}.[0-9]*.usdc")):
            number, among = path.name.removeprefix(anims), f"{File.CHUNKS}/"
            if not (folder / waiting / f"{among}{agents}{number}").exists():  # the only chunk
                number, among = ".usdc", ""
            files = ChunkFiles(
                agents=f"{waiting}{among}{agents}{number}",
                footsteps=f"{waiting}{among}{footsteps}{number}",
                anims=f"{waiting}{path.name}",
            )
            if waiting or _all_in(files, intact):
                yield files


def _all_in(files: ChunkFiles, intact: Collection[str] | None) -> bool:
    return intact is None or all(name in intact for name in files)


def _opened(path: Path) -> Sdf.Layer | None:
    """The metadata of a layer as it is on disk now; None if it cannot be read."""
    if not path.is_file():
        return None
    try:
        return Sdf.Layer.OpenAsAnonymous(str(path), metadataOnly=True)
    except Tf.ErrorException:
        return None


def _notes(layer: Sdf.Layer | None) -> Mapping[str, Any]:
    """What a layer says of its making."""
    said = layer.customLayerData.get(PROVENANCE) if layer else None
    return said if isinstance(said, dict) else {}
