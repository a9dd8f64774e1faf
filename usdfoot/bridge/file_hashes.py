"""Hashes of files, several at a time."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

__all__ = ["file_hashes"]

_BLOCK = 1 << 20
"""Bytes hashed at a time: a chunk need not fit into memory twice."""


def file_hashes(files: Mapping[str, Path]) -> dict[str, str]:
    """SHA-256 of files by name, in the order of the names.

    Raises:
        OSError: If one cannot be read.
    """
    names = sorted(files)
    with ThreadPoolExecutor() as threads:  # hashing lets other threads run
        return dict(zip(names, threads.map(_sha256, (files[name] for name in names)), strict=True))


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        digest = hashlib.sha256()
        while block := file.read(_BLOCK):
            digest.update(block)
    return digest.hexdigest()
