"""Belongings: which of the files in a folder are a crowd's."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from pxr import Sdf, Tf

from usdfoot.bridge.chunk_files import ChunkFiles
from usdfoot.bridge.tokens import PROVENANCE, File
from usdfoot.errors import OutputError
from usdfoot.writers.characters import FOLDER

__all__ = ["check_foreign", "tidy"]

_CHUNK_FILE = re.compile(r"(agents|footsteps|anims)\.\d{4}\.usdc")
_REPLACED = (File.CROWD, File.REPORT, File.AGENTS, File.FOOTSTEPS, File.ANIMS, File.EXPANDED, File.MATERIALS)
_UNFINISHED = re.compile(r"\.\d+(-[0-9a-f]{16})?\.(?P<name>.+)")
"""Temporary names, as `writers/staging.py` gives them, and as it once did."""


def check_foreign(folder: Path) -> None:
    """Raise an OutputError if files would be replaced or removed of which none is a crowd's.

    One that is is enough: others may be damaged, or of a run that was killed. The smallest are asked first, since a
    layer of ten thousand agents takes a second to be opened.

    Args:
        folder: Of the crowd, a real path; need not be there.
    """
    there = [path for path in sorted(folder.glob("*")) if _is_written(path.name)]
    by_size = sorted(there, key=lambda path: path.lstat().st_size)
    if there and not any(_is_ours(path) for path in by_size):
        what = "has files that usdfoot would replace and did not write"
        raise OutputError(folder, what, "name another folder, or move them", [path.name for path in there])


def tidy(folder: Path, chunks: Sequence[ChunkFiles], *, has_materials: bool = False) -> None:
    """Remove chunks that a larger crowd left behind, and what runs that were killed did not finish.

    Args:
        folder: Of the crowd, a real path.
        chunks: Files of the chunks that are to stay.
        has_materials: Whether the crowd has a layer of materials.
    """
    if not has_materials:
        (folder / File.MATERIALS).unlink(missing_ok=True)
    shutil.rmtree(folder / File.PENDING, ignore_errors=True)
    names, parts = {folder / name for chunk in chunks for name in chunk}, folder / File.CHUNKS
    for path in [*folder.iterdir(), *_files_below(parts)]:
        unfinished = _UNFINISHED.fullmatch(path.name)
        left = unfinished and (_is_written(unfinished["name"]) or unfinished["name"] == File.OVERRIDES)
        if left or (_CHUNK_FILE.fullmatch(path.name) and path not in names):
            path.unlink()
    for path in _files_below(folder / FOLDER):
        if _UNFINISHED.fullmatch(path.name):
            path.unlink()
    with suppress(OSError):  # it has files, or is not there
        parts.rmdir()


def _files_below(folder: Path) -> list[Path]:
    """Files of a folder and of those in it; none of a link, behind which nothing is a crowd's."""
    return [] if folder.is_symlink() else [path for path in folder.rglob("*") if path.is_file()]


def _is_written(name: str) -> bool:
    """Whether a file of this name is written anew with every crowd."""
    return name in _REPLACED or bool(_CHUNK_FILE.fullmatch(name))


def _is_ours(path: Path) -> bool:
    """Whether a file says that usdfoot wrote it."""
    try:
        if path.name == File.REPORT:
            return "usdfoot" in json.loads(path.read_text(encoding="utf-8"))["versions"]
        layer = Sdf.Layer.OpenAsAnonymous(str(path), metadataOnly=True)
        return bool(layer) and PROVENANCE in layer.customLayerData
    except (Tf.ErrorException, OSError, ValueError, KeyError, TypeError):
        return False
