"""Folder lock: one run at a time writes into a folder, or the tasks of one job."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from usdfoot.errors import OutputError

try:
    import fcntl
except ImportError:  # as on Windows, where nothing is locked
    fcntl = None  # type: ignore[assignment]

__all__ = ["lock_folder"]


@contextmanager
def lock_folder(folder: Path, *, is_shared: bool = False) -> Iterator[None]:
    """While the block lasts nobody else gets into one for the same folder, but for those who share it.

    No file says so: of who was killed nothing is left. Where the folder cannot be made or locked, as on some disks of a
    network, nobody is kept out.

    Args:
        folder: Made if it does not exist, and removed again if nothing is in it in the end.
        is_shared: Whether others may write at the same time who say so too: chunks of a crowd, each its own.

    Raises:
        OutputError: If another run is in such a block.
    """
    with ExitStack() as stack:
        try:
            missing = [path for path in (folder, *folder.parents) if not path.exists()]
            stack.callback(_remove_empty, missing)
            folder.mkdir(parents=True, exist_ok=True)
            handle = os.open(folder, os.O_RDONLY)
            stack.callback(os.close, handle)
            is_free = _lock(handle, is_shared)
        except OSError:
            is_free = True
        if not is_free:
            raise OutputError(folder, "another run is writing into it", "wait until it is done, or name another folder")
        yield


def _lock(handle: int, is_shared: bool) -> bool:
    """Whether nobody else has locked the folder, or all share it."""
    try:
        if fcntl:
            fcntl.flock(handle, (fcntl.LOCK_SH if is_shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _remove_empty(folders: list[Path]) -> None:
    """Folders from within outwards, as far as nothing is in them."""
    for folder in folders:
        with suppress(OSError):
            folder.rmdir()
