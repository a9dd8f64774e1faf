"""Earlier: agents that a run before made, and in which chunks they are."""

from __future__ import annotations

import struct
from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path

from usdfoot.batch.tasks import ChunkTask
from usdfoot.bridge.chunk_files import ChunkFiles, chunk_folder
from usdfoot.bridge.tokens import PROVENANCE, Record
from usdfoot.readers.chunks import list_chunks
from usdfoot.writers.crate.reading import read_data

__all__ = ["find_agents", "with_earlier"]


def find_agents(
    folder: Path, *, intact: Collection[str] | None = None, kept: Collection[ChunkFiles] = ()
) -> dict[tuple[str, str], ChunkFiles]:
    """Files, relative to the folder, of agents made before, by name and hash of what each was made from.

    Args:
        folder: Of the crowd.
        intact: Files of the crowd that are as they were written; None = as far as they tell themselves.
        kept: Chunks in which nobody need be looked for, as they stay as they are.
    """
    settled = {chunk_folder(folder, files) / files.anims for files in kept}
    found: dict[tuple[str, str], ChunkFiles] = {}
    for files in list_chunks(folder, intact=intact):
        if folder / files.anims not in settled:
            found.update(dict.fromkeys(_agent_hashes(folder / files.anims).items(), files))
    return found


def with_earlier(task: ChunkTask, made: Mapping[tuple[str, str], ChunkFiles]) -> ChunkTask:
    """The task with what there is of its agents, `made` by name and hash."""
    return replace(task, earlier=tuple(made.get(key) for key in zip(task.agents, task.hashes, strict=True)))


def _agent_hashes(file: Path) -> Mapping[str, str]:
    """What a layer's agents were made from; nothing if something else wrote it. USD opens it many times slower."""
    try:
        hashes = read_data(file)[PROVENANCE][Record.AGENT_HASHES]
    except (OSError, TypeError, ValueError, LookupError, struct.error):
        return {}
    return {name: said for name, said in hashes.items() if isinstance(said, str)} if isinstance(hashes, dict) else {}
