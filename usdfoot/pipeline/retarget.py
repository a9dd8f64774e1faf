"""Retarget: clips of one rig on a character of another."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from usdfoot import __version__
from usdfoot.bridge.names import unique_name
from usdfoot.bridge.scene import Character, StageInfo
from usdfoot.errors import ClipError, SceneError
from usdfoot.model.report import Outcome, Problem
from usdfoot.readers.candidates import only_character
from usdfoot.readers.characters import read_character
from usdfoot.readers.libraries import read_libraries
from usdfoot.readers.stage import collect_prims, open_stage, read_stage_info
from usdfoot.retarget.clips import RetargetedClip, retarget_clips
from usdfoot.retarget.gaps import find_gaps
from usdfoot.retarget.rig import build_rig, legs_as_rigged
from usdfoot.writers.retargeted import WrittenClip, write_retargeted

__all__ = ["RetargetReport", "retarget"]


@dataclass(frozen=True, kw_only=True)
class RetargetReport(Outcome):
    """Outcome of one run of `retarget`."""

    file: Path
    """The stage written."""
    clips: dict[str, RetargetedClip]
    """By the name of their prims."""


def retarget(
    clips_file: str | os.PathLike[str],
    character_file: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    character_prim: str = "",
    plant: bool | None = None,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> RetargetReport:
    """Put all clips of a stage on a character, feet standing where and when they stood.

    Legs, trunk, neck and arms of both are found by the names of the joints and the shape of the hierarchy. The output
    references the character and is a stage of its own: it can be played, analysed, and animated from.

    Args:
        clips_file: USD file with SkelAnimations and their Skeletons; never changed.
        character_file: USD file with the character; never changed.
        output: Stage to write: .usd, .usda or .usdc.
        character_prim: Path of the character in its file, where there are several.
        plant: Hold the balls of the feet where they stand; None = unless the legs of both rigs have one shape.
        progress: Told what begins: "read", the skeletons in turn, "write".

    Raises:
        SceneError: If a file cannot be opened, has no clips or no such prim.
        SkeletonError: If the character has no usable Skeleton.
        BipedError: If its legs are not found.
        OutputError: If the stage cannot be written or would replace a source.
    """
    progress("read", 0, 0)
    character, info = _read_target(character_file, character_prim)
    target = build_rig(character.skeleton, character.biped, character.bind_pose)
    source = read_libraries(clips_file)
    problems = list(source.problems)
    done: dict[str, RetargetedClip] = {}
    names = set[str]()
    for index, (own, library) in enumerate(zip(source.characters, source.libraries, strict=True)):
        progress(library.skeleton.name, index, len(source.libraries))
        rig = build_rig(own.skeleton, own.biped, own.bind_pose)
        gaps = find_gaps(rig, target)
        problems += [Problem(severity="warning", where=rig.skeleton.name, message=text) for text in gaps]
        for result, clip in zip(retarget_clips(rig, library.clips, target, plant=plant), library.clips, strict=True):
            if isinstance(result, ClipError):
                problems.append(Problem(severity="error", where=clip.name, message=str(result)))
            else:
                done[unique_name(clip.name.rsplit("/", 1)[-1], names)] = result
    if not done:
        raise SceneError(source.info.identifier, "no clip could be retargeted", str(problems[0]) if problems else "")
    progress("write", 0, 0)
    file = write_retargeted(
        output,
        [WrittenClip(name=name, clip=result.clip, contacts=result.contacts) for name, result in done.items()],
        character,
        units=replace(info.units, time_codes_per_second=source.info.units.time_codes_per_second),
        frames_per_second=source.info.frames_per_second,
        sources=[*info.layers, *source.info.layers],
        provenance={"version": __version__, "verb": "retarget", "clips": Path(source.info.identifier).name},
    )
    return RetargetReport(file=file, clips=done, problems=tuple(problems))


def _read_target(file: str | os.PathLike[str], path: str) -> tuple[Character, StageInfo]:
    """The character of a file and its stage's metadata."""
    stage = open_stage(file)
    info = read_stage_info(stage)
    prim = stage.GetPrimAtPath(path) if path else only_character(collect_prims(stage))
    if not prim:
        raise SceneError(info.identifier, f"has no prim {path}", "give the path of the character's SkelRoot")
    character = read_character(prim, info.units, np.array([info.start_code]))
    legs = legs_as_rigged(character.skeleton, character.biped, character.bind_pose)
    return replace(character, skeleton=legs), info
