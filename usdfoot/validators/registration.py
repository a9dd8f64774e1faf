"""Registers the validators with USD, whether it found their plugin by itself or not."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from pxr import Plug, Usd, UsdValidation

from usdfoot.validators.animations import check_complete, check_contacts, check_joints, check_rotations
from usdfoot.validators.feet import check_feet
from usdfoot.validators.fixers import complete_fixers, plan_fixers, rotation_fixers
from usdfoot.validators.plans import check_plan

__all__ = ["PLUGIN", "plugin_folder", "register_validators"]

PLUGIN = "usdfoot.validators"
"""Name of the plugin, which is the module USD imports, and the first part of the validators' names."""

Check = Callable[[Usd.Prim, Any], list[Any]]

CHECKS: dict[str, tuple[Check, Callable[[], Sequence[Any]]]] = {
    "AnimationComplete": (check_complete, complete_fixers),
    "JointArrays": (check_joints, tuple),
    "Quaternions": (check_rotations, rotation_fixers),
    "PlanArrays": (check_plan, plan_fixers),
    "Contacts": (check_contacts, tuple),
    "FeetOnFootsteps": (check_feet, tuple),
}
"""Check and maker of the fixers of each validator."""


def plugin_folder() -> Path:
    """Folder of the plugin's plugInfo.json, which goes on `PXR_PLUGINPATH_NAME`."""
    return Path(__file__).resolve().parent


def register_validators() -> None:
    """Register every validator that is not yet; nothing happens where USD takes none from Python (before 26.05).

    USD reads what plugins say of their validators only once, when its validation registry is first used. Later than
    that the validators are registered with the same words as explicit ones.
    """
    registry = UsdValidation.ValidationRegistry
    if not hasattr(registry, "RegisterPluginPrimValidator"):
        return
    if Plug.Registry().GetPluginWithName(PLUGIN) is None:
        Plug.Registry().RegisterPlugins(str(plugin_folder()))
    for name, (check, fixers) in CHECKS.items():
        _register(registry(), name, check, _made(fixers))


def _register(registry: Any, name: str, check: Check, fixers: list[Any]) -> None:
    full_name = f"{PLUGIN}:{name}"
    if registry.HasValidator(full_name):
        return
    # Versions that take no fixers have no such argument.
    options = {"fixers": fixers} if fixers else {}
    if registry.GetValidatorMetadata(full_name) is not None:
        registry.RegisterPluginPrimValidator(full_name, check, **options)
        return
    told, keywords = _plug_info(name)
    metadata = UsdValidation.ValidatorMetadata(
        name=full_name,
        keywords=keywords,
        doc=told["doc"],
        schemaTypes=told["schemaTypes"],
        isTimeDependent=told.get("isTimeDependent", False),
    )
    registry.RegisterPrimValidator(metadata, check, **options)


def _made(fixers: Callable[[], Sequence[Any]]) -> list[Any]:
    """The fixers; none where USD knows fixers but cannot make them in Python (as 26.05)."""
    try:
        return list(fixers())
    except (AttributeError, RuntimeError, TypeError):
        return []


def _plug_info(name: str) -> tuple[dict[str, Any], list[str]]:
    """What plugInfo.json tells of a validator, and the keywords of all."""
    info = json.loads((plugin_folder() / "plugInfo.json").read_text(encoding="utf-8"))
    validators = info["Plugins"][0]["Info"]["Validators"]
    return validators[name], validators["keywords"]
