"""Staging: files are written under temporary names and renamed only once all of them are there."""

from __future__ import annotations

import errno
import logging
import os
import secrets
import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from pxr import Sdf, Tf, UsdUtils

from usdfoot.bridge.file_hashes import HashingThreads, file_hashes
from usdfoot.errors import OutputError
from usdfoot.writers.crate.specs import Spec
from usdfoot.writers.crate.writing import write_layer

__all__ = ["StagedFiles", "staged_files"]

_logger = logging.getLogger(__name__)

_EXPECTED_WARNING = "Upgrading crate file"
"""Time codes need a younger .usdc than USD starts with; it says so for every file."""

_NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_AT_ONCE = 1 << 18
"""What is written at a time of many small values [bytes]: the system takes as long for less."""
_MORE = 1 << 20
"""More than is missing of a layer that nearly fits on a disk [bytes]."""


class StagedFiles:
    """Files on their way into a folder, in the order in which they will be renamed.

    Args:
        folder: Existing folder they are for.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._mark = f"{os.getpid()}-{secrets.token_hex(8)}"  # other machines have processes of the same number
        self._temporary: dict[str, Path] = {}
        self._adopted: dict[str, Path] = {}
        self._hashes: dict[str, str] = {}
        self._hashing = HashingThreads()

    def reserve(self, name: str, *, within: str = ".") -> Path:
        """Where a file is to be written that will have the name: in this folder of theirs till then."""
        self._temporary[name] = self._hidden(f"{within}/{name}")
        return self._temporary[name]

    def add_layer(self, name: str, layer: Sdf.Layer, *, within: str = ".") -> None:
        """Save a layer; a file named .usd has the layer's own format."""
        arguments = {"format": str(layer.GetFileFormat().formatId)} if name.endswith(".usd") else {}
        path = self.reserve(name, within=within)
        self.save(name, lambda: layer.Export(str(path), args=arguments))

    def add_specs(self, name: str, root: Spec) -> None:
        """Save a binary layer of specs."""
        with self.reserve(name).open("wb", buffering=_AT_ONCE) as stream:
            write_layer(stream, root)

    def save(self, name: str, save: Callable[[], bool]) -> None:
        """Have USD save a layer where the file of a name is to be written."""
        path, delegate = self._temporary[name], UsdUtils.CoalescingDiagnosticDelegate()
        try:
            saved = save()
        except Tf.ErrorException as error:
            _check_room(path)
            raise OutputError(self.folder / name, "cannot be written", str(error).strip().splitlines()[-1]) from error
        for diagnostic in delegate.TakeUncoalescedDiagnostics():
            if _EXPECTED_WARNING not in diagnostic.commentary:
                _logger.warning("%s: %s", name, diagnostic.commentary)
        if not saved:
            _check_room(path)
            raise OutputError(
                self.folder / name, "cannot be written", "see that the folder has room and may be written to"
            )

    def hash_now(self, name: str) -> None:
        """Begin to hash a file that is not written any more."""
        self._hashing.ask(name, self.place_of(name))

    def add_text(self, name: str, text: str) -> None:
        """Save a text file."""
        self.reserve(name).write_text(text, encoding="utf-8", newline="\n")

    def add_bytes(self, name: str, content: Iterable[bytes]) -> None:
        """Save a file of any kind, of which there are several parts."""
        with self.reserve(name).open("wb") as stream:
            stream.writelines(content)

    def add_file(self, name: str, source: Path) -> None:
        """Copy a file."""
        shutil.copyfile(source, self.reserve(name))

    def adopt(self, name: str, source: Path, *, content_hash: str | None = None) -> None:
        """Take a file that is there already, under another name or its own; if all fails it stays where it is.

        Args:
            name: In the folder.
            source: Where it is.
            content_hash: Its SHA-256 if that is known.
        """
        self._check_place(self.folder / name)
        self._adopted[name] = source
        if content_hash:
            self._hashes[name] = content_hash
        else:
            self._hashing.ask(name, source)

    def place_of(self, name: str) -> Path:
        """Where a file is now."""
        return self._adopted[name] if name in self._adopted else self._temporary[name]

    def content_hashes(self) -> dict[str, str]:
        """SHA-256 of every file so far, by name."""
        known = {**self._hashes, **self._hashing.hashes()}
        unknown = {name: path for name, path in {**self._adopted, **self._temporary}.items() if name not in known}
        return {**known, **file_hashes(unknown)}

    def commit(self) -> tuple[Path, ...]:
        """Rename all files to their final names, adopted first, the last added last; gives back their paths."""
        finals = []
        for name, path in {**self._adopted, **self._temporary}.items():
            if path != self.folder / name:
                os.replace(path, self.folder / name)
            finals.append(self.folder / name)
        self._adopted.clear()
        self._temporary.clear()
        return tuple(finals)

    def discard(self) -> None:
        """Remove what has not been renamed, as far as that can be done."""
        self._hashing.stop()
        for path in self._temporary.values():
            with suppress(OSError):
                path.unlink()
                if path.parent != self.folder:
                    path.parent.rmdir()  # unless others wait there too
        self._temporary.clear()

    def _hidden(self, name: str) -> Path:
        final = self.folder / name
        self._check_place(final)
        return final.with_name(f".{self._mark}.{final.name}")

    def _check_place(self, final: Path) -> None:
        """Has the folder of a file be there, and within this one."""
        if not final.parent.resolve().is_relative_to(self.folder.resolve()):
            raise OutputError(final.parent, f"leads out of {self.folder}", "remove the link, or name another folder")
        final.parent.mkdir(parents=True, exist_ok=True)


def _check_room(path: Path) -> None:
    """Raise the OSError, of a full disk or another, for which USD could not write a file; USD does not tell it.

    Args:
        path: What USD made of the file, in a folder that may be written to; overwritten.
    """
    written = path.stat().st_size if path.exists() else 0
    with path.open("wb") as stream:
        stream.write(bytes(written + _MORE))
        stream.flush()
        os.fsync(stream.fileno())


@contextmanager
def staged_files(folder: Path) -> Iterator[StagedFiles]:
    """Files that appear in `folder` all together when the block ends, or not at all if it raises.

    Args:
        folder: Made if it does not exist.

    Raises:
        OutputError: If the folder cannot be made or written to; OSError of files that are elsewhere.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(folder, f"cannot be made ({error.strerror})", "name a folder you may write to") from error
    files = StagedFiles(folder)
    try:
        yield files
        files.commit()
    except OSError as error:
        if isinstance(error.filename, str) and not Path(error.filename).is_relative_to(folder):
            raise
        remedy = "make room, or name another folder" if error.errno in _NO_ROOM else "name a folder you may write to"
        raise OutputError(folder, f"cannot be written to ({error.strerror})", remedy) from error
    finally:
        files.discard()
