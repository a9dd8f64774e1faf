"""Which USD is in use, where it comes from, and whether it knows usdfoot's plugins."""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import pxr
from pxr import Plug, Tf, Usd

from usdfoot.bridge.schema import schema_folder
from usdfoot.bridge.tokens import Schema

__all__ = ["SEARCH_PATH", "PluginState", "UsdInstallation", "plugin_states", "usd_installation"]

SEARCH_PATH = "PXR_PLUGINPATH_NAME"


@dataclass(frozen=True, kw_only=True)
class UsdInstallation:
    """The USD this process runs on."""

    version: tuple[int, ...]
    """As (0, 24, 8)."""
    folder: Path
    """Of the module pxr."""
    distribution: str
    """Name and version of the wheel it comes from, "" where it is a program's own."""


@dataclass(frozen=True, kw_only=True)
class PluginState:
    """One of usdfoot's USD plugins."""

    name: str
    folder: Path | None
    """Folder of its plugInfo.json, None where it is not installed."""
    usable: bool
    """Whether this process has it; of usdview's, which only usdview can have, whether it is installed."""
    searched: bool
    """Whether its folder is on `PXR_PLUGINPATH_NAME`, where other programs look."""
    told: str
    """What it gives, or why it gives nothing."""


def usd_installation() -> UsdInstallation:
    """The USD of this process."""
    folder = Path(pxr.__file__).resolve().parent
    distribution = ""
    for name in metadata.packages_distributions().get("pxr", ()):
        found = metadata.distribution(name)
        if Path(str(found.locate_file("pxr"))).resolve() == folder:
            distribution = f"{name} {found.version}"
    return UsdInstallation(version=tuple(Usd.GetVersion()), folder=folder, distribution=distribution)


def plugin_states() -> tuple[PluginState, ...]:
    """Schemas, validators and the usdview plugin."""
    return (_schemas(), _validators(), _usdview())


def _schemas() -> PluginState:
    folder = schema_folder()
    known = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(Schema.PLAN) is not None
    told = "fallback values and documentation of the API schemas"
    told = told if known else "USD was used before usdfoot was imported"
    return PluginState(name="schemas", folder=folder, usable=known, searched=_is_searched(folder), told=told)


def _validators() -> PluginState:
    folder = _plugin_folder("validators")
    count, told = 0, "is not installed"
    if folder is not None:
        try:
            count, told = _load_validators(folder)
        except (ImportError, Tf.ErrorException) as error:
            told = str(error).strip().splitlines()[-1]
    return PluginState(name="validators", folder=folder, usable=count > 0, searched=_is_searched(folder), told=told)


def _load_validators(folder: Path) -> tuple[int, str]:
    """How many validators USD has after loading the plugin, and what to say of them."""
    try:
        from pxr import UsdValidation
    except ImportError:
        return 0, "this USD has no UsdValidation"
    if not hasattr(UsdValidation.ValidationRegistry, "RegisterPluginPrimValidator"):
        return 0, "this USD takes no validators from Python; 26.05 does"
    name = "usdfoot.validators"
    plugins = Plug.Registry()
    if plugins.GetPluginWithName(name) is None:
        plugins.RegisterPlugins(str(folder))
    plugin = plugins.GetPluginWithName(name)
    plugin.Load()
    named = [key for key, value in plugin.metadata["Validators"].items() if isinstance(value, dict)]
    registry = UsdValidation.ValidationRegistry()
    count = sum(registry.HasValidator(f"{name}:{key}") for key in named)
    return count, f"{count} of {len(named)} for UsdValidation"


def _usdview() -> PluginState:
    folder = _plugin_folder("usdview")
    told = "a menu in usdview" if folder else "is not installed"
    return PluginState(
        name="usdview", folder=folder, usable=folder is not None, searched=_is_searched(folder), told=told
    )


def _plugin_folder(room: str) -> Path | None:
    """Folder of a room of this package that is a plugin of USD."""
    folder = Path(__file__).resolve().parents[1] / room
    return folder if (folder / "plugInfo.json").is_file() else None


def _is_searched(folder: Path | None) -> bool:
    """Whether a plugin's folder, or its plugInfo.json, is on USD's search path."""
    places = [Path(place).resolve() for place in os.environ.get(SEARCH_PATH, "").split(os.pathsep) if place]
    return folder is not None and bool({folder.resolve(), folder.resolve() / "plugInfo.json"} & set(places))
