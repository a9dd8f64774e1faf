"""Where usdfoot's plugins for USD and usdview lie."""

from __future__ import annotations

from pathlib import Path

from usdfoot.bridge.schema import schema_folder

__all__ = ["plugin_folders"]


def plugin_folders() -> tuple[Path, ...]:
    """Folders with a plugInfo.json, for PXR_PLUGINPATH_NAME: the schemas', the validators', usdview's."""
    package = Path(__file__).resolve().parents[1]
    folders = (schema_folder(), package / "validators", package / "usdview")
    return tuple(folder for folder in folders if folder and (folder / "plugInfo.json").is_file())
