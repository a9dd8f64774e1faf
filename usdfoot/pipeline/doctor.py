"""Doctor: what usdfoot runs on here, and what is missing or broken."""

from __future__ import annotations

import importlib
import importlib.util
import platform
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path

from usdfoot import __version__

__all__ = ["Diagnosis", "Symptom", "examine"]

NEEDED = {"numpy": (1, 26), "scipy": (1, 11), "rich": (13,), "warp": (1, 5)}
"""Modules that must be there, and the lowest version that does."""
DISTRIBUTIONS = {
    "warp": "warp-lang",
    "PIL": "pillow",
    "pxr": "usd-core",
    "jupyter_threejs_sage": "jupyter-threejs-sage",
}
"""Where a distribution is not called as its module is."""
LOWEST_PYTHON = (3, 10)
LOWEST_USD = (0, 24, 8)
EXTRAS = {
    "crowd": (("jupedsim",), "usdfoot plan crowd"),
    "report": (
        ("matplotlib", "PIL", "jupyter_threejs_sage"),
        "pictures and pages: usdfoot analyze --plots, usdfoot inspect --html, tools/draw.py",
    ),
    "import": (("pygltflib", "trimesh", "PIL"), "usdfoot import: glTF and terrain"),
    "dask": (("distributed",), "usdfoot animate --scheduler"),
}
"""Modules of the optional extras, and what they are for."""


@dataclass(frozen=True, kw_only=True)
class Symptom:
    """One thing looked at."""

    name: str
    state: str
    """ok, absent (not needed) or broken (needed)."""
    told: str
    """What was found."""
    remedy: str = ""
    """What to do, "" where nothing."""


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """All that was looked at."""

    symptoms: tuple[Symptom, ...]

    @property
    def healthy(self) -> bool:
        """Whether nothing that is needed is broken."""
        return all(symptom.state != "broken" for symptom in self.symptoms)

    def to_json(self) -> dict[str, object]:
        """Plain dictionaries for `--json`."""
        return {"healthy": self.healthy, "symptoms": [asdict(symptom) for symptom in self.symptoms]}


def examine() -> Diagnosis:
    """Look at everything usdfoot needs or can use; nothing raises."""
    symptoms = [
        _symptom("usdfoot", True, f"{__version__} in {Path(__file__).resolve().parents[1]}"),
        _symptom(
            "Python",
            sys.version_info[:2] >= LOWEST_PYTHON,
            f"{platform.python_version()}, {sys.executable}",
            f"use Python {_dotted(LOWEST_PYTHON)} or later",
        ),
    ]
    symptoms += [_module(name, lowest) for name, lowest in NEEDED.items()]
    for name, look in (("USD", _usd), ("Warp devices", _devices), ("plugins", _plugins)):
        symptoms += _guarded(name, look)
    symptoms += [_extra(name, modules, use) for name, (modules, use) in EXTRAS.items()]
    return Diagnosis(symptoms=tuple(symptoms))


def _module(name: str, lowest: tuple[int, ...]) -> Symptom:
    """Whether a module can be imported and is new enough."""
    distribution = DISTRIBUTIONS.get(name, name)
    remedy = f"pip install '{distribution}>={_dotted(lowest)}'"
    try:
        module = importlib.import_module(name)
    except Exception as error:  # a broken library may raise anything; whatever it is, is told
        return _symptom(name, False, f"cannot be imported: {error}", remedy)
    version = getattr(module, "__version__", "") or _installed_version(distribution)
    numbers = tuple(int(part) for part in version.split(".") if part.isdigit())
    return _symptom(name, not numbers or numbers >= lowest, version or "of unknown version", remedy)


def _usd() -> list[Symptom]:
    from usdfoot.bridge.installation import usd_installation

    usd = usd_installation()
    origin = f"from the wheel {usd.distribution}" if usd.distribution else "a program's own, not from a wheel"
    told = f"{_dotted(usd.version[1:])} in {usd.folder}, {origin}"
    return [_symptom("USD", usd.version >= LOWEST_USD, told, f"use USD {_dotted(LOWEST_USD[1:])} or later")]


def _devices() -> list[Symptom]:
    import warp

    from usdfoot.model.device import start_warp

    start_warp()
    names = [f"{device.alias} ({device.name})" for device in warp.get_devices()]
    remedy = "reinstall warp-lang"
    return [_symptom("Warp devices", bool(names), ", ".join(names) or "none", remedy)]


def _plugins() -> list[Symptom]:
    from usdfoot.bridge.installation import SEARCH_PATH, plugin_states

    symptoms = []
    for plugin in plugin_states():
        place = f", in {plugin.folder}" if plugin.folder else ""
        told = f"{plugin.told}{place}" + ("; other programs find it" if plugin.searched else "")
        state, remedy = "ok" if plugin.usable else "absent", ""
        if plugin.usable and not plugin.searched:
            remedy = f'for other programs: export {SEARCH_PATH}="$(usdfoot plugin-path)"'
        if plugin.name == "schemas" and plugin.folder is None:
            state, told, remedy = "broken", "the schemas are not installed", "pip install usdfoot again"
        symptoms.append(Symptom(name=f"plugin {plugin.name}", state=state, told=told, remedy=remedy))
    return symptoms


def _extra(name: str, modules: tuple[str, ...], use: str) -> Symptom:
    """Whether the modules of an extra are there; they are not imported, which may take long."""
    missing = [module for module in modules if importlib.util.find_spec(module) is None]
    if missing:
        told = f"{', '.join(missing)} not installed; for {use}"
        return Symptom(name=f"extra {name}", state="absent", told=told, remedy=f"pip install 'usdfoot[{name}]'")
    versions = ", ".join(f"{module} {_installed_version(DISTRIBUTIONS.get(module, module))}" for module in modules)
    return Symptom(name=f"extra {name}", state="ok", told=f"{versions}; for {use}")


def _guarded(name: str, look: Callable[[], list[Symptom]]) -> list[Symptom]:
    """What a look finds, or that it failed and why."""
    try:
        return look()
    except Exception as error:  # a broken library may raise anything; whatever it is, is told
        remedy = "pip install 'usd-core>=24.8'" if name == "USD" else "put right what is broken above"
        return [_symptom(name, False, f"{type(error).__name__}: {error}", remedy)]


def _symptom(name: str, healthy: bool, told: str, remedy: str = "") -> Symptom:
    return Symptom(name=name, state="ok" if healthy else "broken", told=told, remedy="" if healthy else remedy)


def _installed_version(distribution: str) -> str:
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return ""


def _dotted(version: tuple[int, ...]) -> str:
    return ".".join(str(part) for part in version)
