"""Chunks of an earlier run: what they were made from, and their records."""

from __future__ import annotations

from pathlib import Path

from pxr import Sdf, Tf

from usdfoot.bridge.tokens import PROVENANCE, ChunkFiles, Record, chunk_folder

__all__ = ["read_record"]


def read_record(folder: Path, files: ChunkFiles, content_hash: str) -> str | None:
    """The record of a chunk that is there, whole, and made from what the hash stands for; None otherwise.

    It may be part of the crowd or wait to become one.

    Args:
        folder: Of the crowd.
        files: Names of the chunk's files.
        content_hash: What the chunk must be made from.
    """
    place = chunk_folder(folder, files)
    record = None
    for name in files:
        notes = _notes(place / name)
        if notes.get(Record.CONTENT_HASH) != content_hash:
            return None
        record = notes.get(Record.REPORT, record)
    return record


def _notes(path: Path) -> dict[str, str]:
    """What a layer says of its making; nothing if it cannot be read."""
    if not path.is_file():
        return {}
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(path), metadataOnly=True)
    except Tf.ErrorException:
        return {}
    return dict(layer.customLayerData.get(PROVENANCE, {}))
