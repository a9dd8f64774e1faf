"""Provenance: what crowd.usd says of its making, so that it can be made again in the same way."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

from usdfoot import __version__
from usdfoot.bridge.scene import Scene
from usdfoot.model.levels import DetailLevels
from usdfoot.model.limits import DEFAULT_LIMITS, Limits
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.report import combined_hash, relative_path

__all__ = ["CHUNK_SIZE", "CallRecord", "call_of", "options_of", "provenance_of"]

CHUNK_SIZE = 100
"""Agents a chunk unless told otherwise."""

Options = TypeVar("Options", bound=Any)


@dataclass(frozen=True, kw_only=True)
class CallRecord:
    """What `animate` was asked for, beside the options of motion."""

    agents: str | Sequence[str] = "*"
    """Globs on agents' names or paths."""
    frames: tuple[int, int] | None = None
    """First and last time code; None = all of the plans."""
    chunk_size: int = CHUNK_SIZE
    """Agents a chunk."""
    collect: bool = False
    """Whether the characters' files are copied."""
    levels: DetailLevels | None = None
    """Of detail."""
    limits: Limits = DEFAULT_LIMITS
    """How much of a scene is read before it is refused."""


def provenance_of(
    scene: Scene, options: MotionOptions, folder: Path, *, call: CallRecord, inputs: Mapping[str, str]
) -> dict[str, Any]:
    """What crowd.usd says about its making: program, options, scene, and a hash of everything that was read (`inputs`).

    The scene's path is relative to the folder. It is a string, not an asset: the crowd does not depend on the scene,
    but `usdfoot validate` finds the terrain there. Of a stage that was edited in memory no files have the hash.
    """
    return {
        "version": __version__,
        "scene": relative_path(scene.stage.identifier, folder),
        "contentHash": combined_hash(inputs) if scene.stage.as_saved else "",
        "options": _given(asdict(options)),
        "call": {
            "agents": "\n".join([call.agents] if isinstance(call.agents, str) else call.agents),
            "chunkSize": call.chunk_size,
            "collect": call.collect,
            **({"levels": str(call.levels)} if call.levels else {}),
            **({"firstFrame": call.frames[0], "lastFrame": call.frames[1]} if call.frames else {}),
            **({"limits": asdict(call.limits)} if call.limits != DEFAULT_LIMITS else {}),
        },
    }


def call_of(provenance: Mapping[str, Any]) -> CallRecord:
    """What a crowd's provenance says `animate` was asked for; the defaults where it says nothing."""
    said = provenance.get("call", {})
    usual = CallRecord()
    given = {"firstFrame", "lastFrame"} <= set(said)
    return CallRecord(
        agents=str(said.get("agents", "*")).split("\n"),
        frames=(int(said["firstFrame"]), int(said["lastFrame"])) if given else None,
        chunk_size=int(said.get("chunkSize", usual.chunk_size)),
        collect=bool(said.get("collect", usual.collect)),
        levels=DetailLevels.parse(said["levels"]) if "levels" in said else None,
        limits=_filled(DEFAULT_LIMITS, said.get("limits", {})),
    )


def options_of(provenance: Mapping[str, Any]) -> MotionOptions:
    """The options that a crowd was made with; what its provenance does not say has its default.

    Raises:
        UsdfootError: If a value is out of its range.
    """
    return _filled(MotionOptions(), provenance.get("options", {}))


def _filled(options: Options, given: Mapping[str, Any]) -> Options:
    """Options with the values given by field; fields that are options themselves are filled too."""
    known = {field.name: getattr(options, field.name) for field in fields(options)}
    values = {name: value for name, value in given.items() if name in known}
    inner = {name: _filled(known[name], value) for name, value in values.items() if is_dataclass(known[name])}
    return replace(options, **{**values, **inner})


def _given(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options without those that are None, which USD's dictionaries cannot say."""
    return {
        key: _given(value) if isinstance(value, Mapping) else value
        for key, value in options.items()
        if value is not None
    }
