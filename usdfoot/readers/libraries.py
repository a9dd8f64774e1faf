"""Clip libraries of a stage on their own skeletons, without agents or plans."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace

import numpy as np
from pxr import Sdf, Usd

from usdfoot.bridge.scene import Character, StageInfo
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.model.clip import Clip, ClipLibrary
from usdfoot.model.report import Problem
from usdfoot.readers.assets import character_prim_of
from usdfoot.readers.characters import read_character
from usdfoot.readers.clip_sources import ClipFinder
from usdfoot.readers.clips import ClipSource, read_clip
from usdfoot.readers.stage import collect_prims, open_stage, read_stage_info
from usdfoot.retarget.rig import legs_as_rigged

__all__ = ["StageClips", "read_libraries"]


@dataclass(frozen=True, kw_only=True)
class StageClips:
    """All clips of a stage."""

    info: StageInfo
    default_prim: str
    """Name of the stage's default prim, "" if it has none."""
    libraries: tuple[ClipLibrary, ...]
    """One for each skeleton that clips were made on."""
    characters: tuple[Character, ...]
    """The characters of those skeletons."""
    problems: tuple[Problem, ...]
    """Clips and skeletons that could not be used."""


def read_libraries(clips_file: str | os.PathLike[str]) -> StageClips:
    """Every usable clip of a stage, on the skeleton it was made on.

    Raises:
        SceneError: If the stage cannot be opened or has no SkelAnimation.
    """
    stage = open_stage(clips_file)
    info = read_stage_info(stage)
    prims = collect_prims(stage)
    finder = ClipFinder(stage, prims)
    animations = finder.animations_below(())
    if not animations:
        raise SceneError(info.identifier, "has no clips", "give a USD file with SkelAnimation prims")
    if not prims.skeletons:
        raise SceneError(info.identifier, "has no Skeleton", "clips need the Skeleton they were made on")
    problems: list[Problem] = []
    by_skeleton: dict[Sdf.Path, list[ClipSource]] = {}
    for animation in animations:
        try:
            source = finder.source_of(animation, prims.skeletons[0])
            by_skeleton.setdefault(source.skeleton_prim.GetPath(), []).append(source)
        except UsdfootError as error:
            problems.append(_problem(animation.GetPath(), error))
    found: list[tuple[Character, ClipLibrary]] = []
    for path, sources in by_skeleton.items():
        try:
            found.append(_read_library(stage, stage.GetPrimAtPath(path), sources, info, problems))
        except UsdfootError as error:
            problems.append(_problem(path, error))
    used = [(character, library) for character, library in found if library.clips]
    root = stage.GetDefaultPrim()
    return StageClips(
        info=info,
        default_prim=root.GetName() if root else "",
        libraries=tuple(library for _, library in used),
        characters=tuple(character for character, _ in used),
        problems=tuple(problems),
    )


def _read_library(
    stage: Usd.Stage, skeleton: Usd.Prim, sources: list[ClipSource], info: StageInfo, problems: list[Problem]
) -> tuple[Character, ClipLibrary]:
    """Character and clips of one skeleton; those that cannot be used are added to the problems."""
    codes = np.array([stage.GetStartTimeCode()])
    character = read_character(character_prim_of(skeleton), info.units, codes)
    legs = legs_as_rigged(character.skeleton, character.biped, character.bind_pose)
    character = replace(character, skeleton=legs)
    clips: list[Clip] = []
    for source in sources:
        try:
            clips.append(read_clip(source, character.skeleton, character.biped, units=info.units))
        except UsdfootError as error:
            problems.append(_problem(source.prim.GetPath(), error))
    library = ClipLibrary(
        skeleton=character.skeleton, biped=character.biped, clips=tuple(clips), bind_pose=character.bind_pose
    )
    return character, library


def _problem(path: Sdf.Path, error: UsdfootError) -> Problem:
    return Problem(severity="error", where=str(path), message=str(error))
