"""Where the files of a chunk of agents are, and how they are called."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from usdfoot.bridge.tokens import File

__all__ = ["ChunkFiles", "chunk_files", "chunk_folder"]


class ChunkFiles(NamedTuple):
    """Names of the files of one chunk of agents."""

    agents: str
    footsteps: str
    anims: str


def chunk_files(index: int, count: int) -> ChunkFiles:
    """Files of a crowd's chunk: ``anims.0000.usdc``, ``anims.0001.usdc`` and so on.

    Agents and footsteps of a single chunk are ``agents.usdc`` and ``footsteps.usdc`` themselves; of several, the files
    that these two are joined from, numbered like the animations, are in a folder of their own.

    Args:
        index: Of the chunk.
        count: Of all chunks.
    """
    agents: str = File.AGENTS
    footsteps: str = File.FOOTSTEPS
    if count > 1:
        agents, footsteps = (f"{File.CHUNKS}/{_numbered(name, index)}" for name in (agents, footsteps))
    return ChunkFiles(agents=agents, footsteps=footsteps, anims=_numbered(File.ANIMS, index))


def chunk_folder(folder: Path, files: ChunkFiles) -> Path:
    """Where a chunk is that was made last: waiting for the others, or part of the crowd in `folder`."""
    waiting = folder / File.PENDING
    return waiting if (waiting / files.anims).exists() else folder


def _numbered(name: str, index: int) -> str:
    return f"{name.split('.')[0]}.{index:04d}.usdc"
