"""Hashes of files, several at a time."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

__all__ = ["HashingThreads", "file_hashes", "intact_files"]

_BLOCK = 1 << 18
"""Bytes hashed at a time: they are still near the processor when they are."""


class HashingThreads:
    """Hashes files that are not written any more, while others still are."""

    def __init__(self) -> None:
        self._threads = ThreadPoolExecutor()  # starts none before there is something to hash
        self._asked: dict[str, Future[str]] = {}

    def ask(self, name: str, path: Path) -> None:
        """Begins to hash a file."""
        self._asked[name] = self._threads.submit(_sha256, path)

    def hashes(self) -> dict[str, str]:
        """SHA-256 of all files asked for, by name, when they are known.

        Raises:
            OSError: If one cannot be read.
        """
        return {name: asked.result() for name, asked in self._asked.items()}

    def stop(self) -> None:
        """Leaves what is not hashed yet."""
        self._threads.shutdown(cancel_futures=True)


def file_hashes(files: Mapping[str, Path]) -> dict[str, str]:
    """SHA-256 of files by name, in the order of the names.

    Raises:
        OSError: If one cannot be read.
    """
    names = sorted(files)
    with ThreadPoolExecutor() as threads:  # hashing lets other threads run
        return dict(zip(names, threads.map(_sha256, (files[name] for name in names)), strict=True))


def intact_files(hashes: Mapping[str, str], folder: Path, *, since: Path | None = None) -> dict[str, str]:
    """Those of the files of a folder that are there with the bytes that their hashes stand for, with these.

    Args:
        hashes: SHA-256 of files by name.
        folder: Where they are.
        since: A file written after all of them: what is older is not read, as nobody wrote into it; None = all are.
    """
    last = None if since is None else since.stat().st_mtime_ns
    found = {name: folder / name for name in hashes if (folder / name).is_file()}
    suspect = {name: path for name, path in found.items() if last is None or path.stat().st_mtime_ns >= last}
    now = {**{name: hashes[name] for name in found}, **file_hashes(suspect)}
    return {name: value for name, value in now.items() if value == hashes[name]}


def _sha256(path: Path) -> str:
    digest, block = hashlib.sha256(), memoryview(bytearray(_BLOCK))
    with path.open("rb", buffering=0) as file:
        while count := file.readinto(block):
            digest.update(block[:count])
    return digest.hexdigest()
