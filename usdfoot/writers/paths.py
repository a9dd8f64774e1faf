"""Asset paths as they stand in written layers: relative, with forward slashes."""

from __future__ import annotations

import os
from pathlib import Path

from pxr import Sdf

from usdfoot.errors import OutputError

__all__ = ["relative_asset"]


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
