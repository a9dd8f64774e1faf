"""Chunk notes: what a chunk says of its making."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["ChunkNotes"]


@dataclass(frozen=True, kw_only=True)
class ChunkNotes:
    """What a chunk was made from and what became of it, kept with it so that a later run need not make it again."""

    content_hash: str = ""
    """Of all that the chunk was made from."""
    agent_hashes: Mapping[str, str] = field(default_factory=dict)
    """Of all that each agent written was made from, by name."""
    record: str = ""
    """What the report says of the chunk, lines of JSON."""
