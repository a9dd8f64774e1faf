"""Paths: of files to be written, and of assets as they stand in written layers."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from pxr import Sdf

from usdfoot.errors import OutputError

__all__ = ["folder_path", "layer_path", "relative_asset"]

ARGUMENTS = ":SDF_FORMAT_ARGS:"
"""What USD takes for the beginning of a file format's arguments, anywhere in a name."""
SUFFIXES = (".usd", ".usda", ".usdc")


def relative_asset(asset: str, folder: Path) -> str:
    """Asset path relative to the folder, anchored by ./ or ../.

    Args:
        asset: A file, or an asset within a package as USD writes it.
        folder: Real path of the folder of the layer that will hold the path.

    Raises:
        OutputError: If the asset lives in memory only.
    """
    if Sdf.Layer.IsAnonymousLayerIdentifier(asset):
        raise OutputError(asset, "lives in memory only and cannot be referenced", "save the scene to a file first")
    if "://" in asset:
        return asset
    path = Path(os.path.relpath(os.path.realpath(asset), folder)).as_posix()
    return path if path.startswith("../") else f"./{path}"


def folder_path(folder: str | os.PathLike[str]) -> Path:
    """Real path of a folder to be written to.

    Args:
        folder: Its name, perhaps of one that is to be made.

    Raises:
        OutputError: If there is no name, which would be the current folder, or USD could not open what is in it.
    """
    if not os.fspath(folder):
        raise OutputError("output", "no folder is named", "name one; . is the current folder")
    return _real_path(folder)


def layer_path(file: str | os.PathLike[str], *, sources: Iterable[str | os.PathLike[str]] = ()) -> Path:
    """Real path of a layer to be written.

    Args:
        file: Its name, perhaps of a file that will be replaced.
        sources: Files it is made from, which must not be replaced.

    Raises:
        OutputError: If the name is no USD layer's, or that of a source, or USD could not open it.
    """
    target = _real_path(file)
    if target.suffix not in SUFFIXES:
        raise OutputError(file, "is no name of a USD layer", f"name a file that ends in {', '.join(SUFFIXES)}")
    if str(target) in {os.path.realpath(source) for source in sources}:
        raise OutputError(file, "would replace what it is made from", "name another file")
    return target


def _real_path(name: str | os.PathLike[str]) -> Path:
    path = os.path.realpath(name)
    if ARGUMENTS in path:
        raise OutputError(name, f"holds {ARGUMENTS}, where USD ends a file's name", "name another")
    return Path(path)
