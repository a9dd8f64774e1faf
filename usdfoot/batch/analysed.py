"""Analysed: the examples of clip libraries kept by a process and beside a crowd, not to be cut again for a few agents.

A file is named by all it was made from, holds arrays and text only (numpy's npz, never pickled), and is the same bytes
whoever writes it.
"""

from __future__ import annotations

import io
import json
import logging
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from functools import lru_cache
from pathlib import Path
from typing import Any, BinaryIO
from zipfile import BadZipFile

import numpy as np

from usdfoot import __version__
from usdfoot.analysis.examples import build_examples
from usdfoot.bridge.tokens import File
from usdfoot.bridge.versions import library_versions
from usdfoot.errors import OutputError
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.examples import Examples
from usdfoot.model.hashing import library_hash
from usdfoot.model.report import Problem
from usdfoot.writers.staging import staged_files

__all__ = ["KeptExamples", "build_once", "forget_examples", "tidy_examples"]

_logger = logging.getLogger(__name__)

_LIBRARIES = 4
"""How many libraries' examples a process has at hand."""

_TEXT = "text"
"""Entry of a file with what are no arrays, as JSON."""

_DAMAGED = (
    ValueError,
    KeyError,
    TypeError,
    AttributeError,
    EOFError,
    MemoryError,
    RuntimeError,
    BadZipFile,
    zlib.error,
)
"""What numpy, zip and JSON raise where a file's bytes are not those that were written; it is made again then."""


class KeptExamples:
    """Examples cut from clips, or as an earlier run cut them.

    Args:
        folder: Of the crowd.
        given: What other processes' `cut` gave back, by now.
    """

    def __init__(self, folder: Path, *, given: Callable[[], Mapping[str, bytes]] = dict) -> None:
        self._folder = folder
        self._given = given

    def cut(self, library: ClipLibrary, *, samples: int) -> dict[str, bytes]:
        """The file that `build` would write for a library, by name; nothing if it is there. It is not written."""
        name = _name_of(library, samples)
        if self._read(name, library, samples) is not None:
            return {}
        return {name: _bytes_of(*build_once(library, samples=samples))}

    def find(self, library: ClipLibrary, *, samples: int) -> tuple[Examples, list[Problem]]:
        """What `build_examples` makes of a library, read if it is there; nothing is written."""
        kept = self._read(_name_of(library, samples), library, samples)
        return build_once(library, samples=samples) if kept is None else kept

    def build(self, library: ClipLibrary, *, samples: int) -> tuple[Examples, list[Problem]]:
        """What `build_examples` makes of a library, read if it is there, else kept for the next time if it can be."""
        name = _name_of(library, samples)
        kept = self._read(name, library, samples)
        if kept is not None:
            return kept
        given = self._given().get(name)
        cut = _read(io.BytesIO(given), library, samples) if given else None
        examples, problems = cut or build_once(library, samples=samples)
        try:
            with staged_files(self._folder) as files:
                files.add_bytes(name, [given if given and cut else _bytes_of(examples, problems)])
        except OutputError as error:  # the crowd itself may have room
            _logger.warning("the clips' analysis is not kept: %s", error)
        return examples, problems

    def _read(self, name: str, library: ClipLibrary, samples: int) -> tuple[Examples, list[Problem]] | None:
        return _read(self._folder / name, library, samples)


def build_once(library: ClipLibrary, *, samples: int) -> tuple[Examples, list[Problem]]:
    """What `build_examples` makes of a library. A process that lives on has the last few libraries' at hand."""
    examples, problems = _examples_of(_HashedLibrary(content=library_hash(library), library=library), samples)
    return examples, list(problems)


def forget_examples() -> None:
    """Have the process cut the steps of every library anew."""
    _examples_of.cache_clear()


@dataclass(frozen=True, kw_only=True)
class _HashedLibrary:
    """A library that equals those with the same content."""

    content: str
    library: ClipLibrary = field(compare=False)


@lru_cache(maxsize=_LIBRARIES)
def _examples_of(hashed: _HashedLibrary, samples: int) -> tuple[Examples, tuple[Problem, ...]]:
    examples, problems = build_examples(hashed.library, samples=samples)
    return examples, tuple(problems)


def tidy_examples(folder: Path, libraries: Sequence[ClipLibrary], *, samples: int) -> None:
    """Remove what was kept of other libraries than these; of none, all."""
    names = {_name_of(library, samples) for library in libraries}
    place = folder / File.EXAMPLES
    if place.is_symlink():  # nothing of ours is there
        return
    for path in place.glob("*.npz"):
        if f"{File.EXAMPLES}/{path.name}" not in names:
            path.unlink()
    if place.is_dir() and not any(place.iterdir()):
        place.rmdir()


def _name_of(library: ClipLibrary, samples: int) -> str:
    versions = {"usdfoot": __version__, **library_versions()}
    return f"{File.EXAMPLES}/{library_hash(library, versions, samples)}.npz"


def _bytes_of(examples: Examples, problems: Sequence[Problem]) -> bytes:
    """Examples and problems as npz."""
    values = {each.name: getattr(examples, each.name) for each in fields(Examples)}
    arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray)}
    words = {name: value for name, value in values.items() if name not in arrays}
    text = json.dumps({"words": words, "problems": [asdict(problem) for problem in problems]}, sort_keys=True)
    stream = io.BytesIO()
    arrays[_TEXT] = np.array(text)
    np.savez(stream, **arrays)  # type: ignore[arg-type]  # allow_pickle=False would be an array of numpy 1.26's
    return stream.getvalue()


def _read(file: Path | BinaryIO, library: ClipLibrary, samples: int) -> tuple[Examples, list[Problem]] | None:
    """What `_bytes_of` made of a library's; None if it is not there, or not whole."""
    try:
        with np.load(file, allow_pickle=False) as found:
            arrays = dict(found)
        text = json.loads(str(arrays.pop(_TEXT)))
        words: dict[str, Any] = {name: tuple(value) for name, value in text["words"].items()}
        examples = Examples(**arrays, **words)
        count = len(examples.styles)
        fits = examples.rotations.shape == (count, samples, len(library.skeleton.joints), 4)
        fits = fits and all(array.shape[:1] == (count,) for array in arrays.values())
        return (examples, [Problem(**problem) for problem in text["problems"]]) if fits else None
    except (OSError, *_DAMAGED):
        return None
