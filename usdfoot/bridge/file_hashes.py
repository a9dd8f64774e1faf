"""Hashes of files, several at a time."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

__all__ = ["HashingThreads", "file_hashes", "intact_files", "mark_unchanged"]

_BLOCK = 1 << 18
"""Bytes hashed at a time: they are still near the processor when they are."""
_AFTER = 1000
"""A microsecond [ns], which file systems keep that keep more than whole seconds."""
_TICK, _TICKS = 0.001, 50
"""How long to wait for the clock that stamps files [s], and how often: it ticks each 1 to 10 ms."""


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


def intact_files(hashes: Mapping[str, str], folder: Path, *, marked: Path) -> dict[str, str]:
    """Those of the files of a folder that are there with the bytes that their hashes stand for, with these.

    They are read unless they are as `mark_unchanged` left them.

    Args:
        hashes: SHA-256 of files by name.
        folder: Where they are.
        marked: The file that was marked.
    """
    found = {name: folder / name for name in hashes if (folder / name).is_file()}
    if marked.stat().st_mtime_ns == _last_change(found.values()) + _AFTER:
        return {name: hashes[name] for name in found}
    return {name: value for name, value in file_hashes(found).items() if value == hashes[name]}


def mark_unchanged(files: Iterable[Path], *, marked: Path) -> None:
    """Has a file that tells of others say by its own time that nobody changed these since.

    Its time is set a microsecond after the last change of any of them, which the system notes and nobody can choose:
    whatever is written, put in place or copied later has a later one. Where clocks of files are so coarse that a change
    to come could have the same time, nothing is marked.

    Args:
        files: Complete, under their final names.
        marked: Not one of them.
    """
    last = _last_change(files)
    for _ in range(_TICKS):
        os.utime(marked, ns=(last + _AFTER, last + _AFTER))
        if marked.stat().st_ctime_ns > last:
            return
        time.sleep(_TICK)
    os.utime(marked)


def _last_change(files: Iterable[Path]) -> int:
    """When any of some files was last written, or put where it is [ns]."""
    found = [path.stat() for path in files]
    return max((max(status.st_ctime_ns, status.st_mtime_ns) for status in found), default=0)


def _sha256(path: Path) -> str:
    digest, block = hashlib.sha256(), memoryview(bytearray(_BLOCK))
    with path.open("rb", buffering=0) as file:
        while count := file.readinto(block):
            digest.update(block[:count])
    return digest.hexdigest()
