"""Import clips: motion capture and animation files of other programs become one stage of clips."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from usdfoot import __version__
from usdfoot.analysis.biped import find_biped
from usdfoot.analysis.motion import joint_kinematics
from usdfoot.analysis.rest_pose import mean_stand, set_on_ground, stands
from usdfoot.analysis.same_bones import merged_captures
from usdfoot.bridge.names import unique_name
from usdfoot.errors import BipedError, ClipError, UsdfootError
from usdfoot.importers.amc import import_amc, skeleton_files
from usdfoot.importers.asf import import_asf
from usdfoot.importers.bones import upright
from usdfoot.importers.bvh import import_bvh
from usdfoot.importers.gltf import import_gltf
from usdfoot.importers.units import metres_in
from usdfoot.model.biped import SIDES
from usdfoot.model.capture import Capture
from usdfoot.model.limits import DEFAULT_LIMITS, Limits
from usdfoot.model.report import Problem
from usdfoot.writers.clips import write_clips

__all__ = ["CLIP_SUFFIXES", "ClipFormat", "ImportedClips", "import_clips"]

GLTF_SUFFIXES = (".gltf", ".glb")
CLIP_SUFFIXES = (".bvh", ".asf", ".amc", *GLTF_SUFFIXES)
"""Of files that can be imported as clips."""
LEGS = (0.4, 1.4)
"""Thigh and shin of people and near it [m]; others are asked about."""


@dataclass(frozen=True, kw_only=True)
class ClipFormat:
    """What files do not say about themselves."""

    unit: str = ""
    """Of lengths: m, cm, mm, ft, in, or metres a unit."""
    rate: float = 0.0
    """Frames a second of AMC files [Hz]; samples a second of glTF files, 0 = as their keys are."""
    up: str = "Y"
    """Axis that points up in files other than glTF: Y | Z."""
    limits: Limits = DEFAULT_LIMITS
    """How much a file may hold."""


@dataclass(frozen=True, kw_only=True)
class ImportedClips:
    """Outcome of one import."""

    file: Path
    """The stage written."""
    captures: Mapping[str, Capture]
    """Skeletons with their clips, by name."""
    problems: tuple[Problem, ...]
    """Files that were skipped (errors) and what was odd (warnings)."""


def import_clips(
    files: Sequence[str | os.PathLike[str]],
    output: str | os.PathLike[str],
    *,
    clip_format: ClipFormat | None = None,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> ImportedClips:
    """Write the clips of motion capture files as a USD stage that `analyze` reads and agents use.

    Clips on the same bones share a Skeleton. Its rest pose stands on level feet, faces +Z and has the pelvis over the
    origin: the file's own pose where that stands, else one made of the clips.

    Args:
        files: .bvh, .asf with their .amc, .gltf, .glb.
        output: .usd, .usda or .usdc to write.
        clip_format: Units and rates that the files do not state.
        progress: Told which file is read, how many are done, and of how many.

    Raises:
        UsdfootError: If no file can be used; the first error.
        OutputError: If the stage cannot be written.
    """
    clip_format = clip_format or ClipFormat()
    paths = [Path(file) for file in files]
    captures: list[Capture] = []
    _check_unit(paths, clip_format.unit)
    skeletons = skeleton_files(paths)
    problems: list[Problem] = []
    errors: list[UsdfootError] = []
    for done, path in enumerate(paths):
        progress(path.name, done, len(paths))
        if path in skeletons.values():
            continue
        try:
            found, odd = _read(path, skeletons.get(path), clip_format)
            captures += found
            problems += odd
        except UsdfootError as error:
            errors.append(error)
    if not captures:
        raise errors[0] if errors else ClipError("files", "there are none", "name at least one")
    problems += [Problem(severity="error", where=error.where, message=str(error)) for error in errors]
    progress("write", 0, 0)
    standing = []
    for capture in merged_captures(captures):
        rested, doubts = _at_rest(capture)
        standing.append(rested)
        problems += doubts
    names: set[str] = set()
    named = {unique_name(Path(capture.skeleton.name).stem, names): capture for capture in standing}
    provenance = {"version": __version__, "sources": ", ".join(path.name for path in paths)}
    target = write_clips(output, named, sources=paths, provenance=provenance)
    return ImportedClips(file=target, captures=named, problems=tuple(problems))


def _check_unit(paths: Sequence[Path], unit: str) -> None:
    """Raises ClipError if a unit is asked for that no file can have."""
    if (
        unit
        and metres_in(unit, "unit", error=ClipError) != 1.0
        and {path.suffix.lower() for path in paths} <= set(GLTF_SUFFIXES)
    ):
        raise ClipError(paths[0], f"is in metres, as glTF defines it, not {unit}", "leave --unit out")


def _read(path: Path, skeleton: Path | None, said: ClipFormat) -> tuple[list[Capture], tuple[Problem, ...]]:
    """Captures of one file, an AMC file with its ASF file, and what was odd."""
    suffix = path.suffix.lower()
    if suffix == ".bvh":
        capture = import_bvh(path, unit=said.unit, limits=said.limits)
        stated = capture.clips[0].rate
        if said.rate and not np.isclose(said.rate, stated, rtol=1e-3):
            what = f"says it has {stated:g} frames a second, not {said.rate:g}"
            raise ClipError(path, what, "leave --rate out, or import files that need it apart")
        return [upright(capture, up=said.up)], ()
    if suffix in GLTF_SUFFIXES:
        found, left_out = import_gltf(path, rate=said.rate, limits=said.limits)
        return list(found), left_out
    if suffix == ".asf":
        raise ClipError(path, "has no AMC file that moves it", "name its AMC files as well")
    if suffix != ".amc":
        raise ClipError(path, f"{suffix or 'no suffix'} is unknown", f"{', '.join(CLIP_SUFFIXES)} can be imported")
    if skeleton is None:
        raise ClipError(path, "has no ASF file", "name it as well; of several, 02.asf belongs to 02_01.amc")
    bones = import_asf(skeleton, unit=said.unit, limits=said.limits)
    capture, odd = import_amc(path, bones, rate=said.rate, limits=said.limits)
    return [upright(capture, up=said.up)], odd


def _at_rest(capture: Capture) -> tuple[Capture, list[Problem]]:
    """The capture with a rest pose that stands, and doubts about its size and axes."""
    where = capture.skeleton.name
    try:
        roles = _legs(capture)
    except BipedError as error:
        message = f"{error}; it keeps the file's own rest pose"
        return capture, [Problem(severity="warning", where=where, message=message)]
    skeleton = capture.skeleton
    if not stands(skeleton, roles):
        skeleton = mean_stand(skeleton, capture.clips, roles)
    rested = replace(capture, skeleton=set_on_ground(skeleton, capture.clips, roles))
    messages = _doubts(rested, roles)
    return rested, [Problem(severity="warning", where=where, message=f"{where}: {message}") for message in messages]


def _legs(capture: Capture) -> dict[str, int]:
    """Joint by role: as found in the file's own pose if that stands, else in the first sample of its first clip."""
    skeleton, clip = capture.skeleton, capture.clips[0]
    posed = replace(skeleton, rest_translations=clip.translations[0], rest_rotations=clip.rotations[0])
    try:
        roles = find_biped(skeleton, {})
    except BipedError:
        return find_biped(posed, {})
    return roles if stands(skeleton, roles) else find_biped(posed, {})


def _doubts(capture: Capture, roles: Mapping[str, int]) -> list[str]:
    """What suggests that the unit or the upward axis is another."""
    clips = capture.clips
    joints = np.array([[roles[f"{side} {role}"] for role in ("hip", "knee", "ankle")] for side in SIDES])
    moved = [clip.translations for clip in clips], [clip.rotations for clip in clips]
    places, _ = joint_kinematics(capture.skeleton, *moved, joints=joints.ravel())
    hips, knees, ankles = places.reshape(-1, 2, 3, 3).transpose(2, 0, 1, 3)
    length = np.median(np.linalg.norm(knees - hips, axis=-1) + np.linalg.norm(ankles - knees, axis=-1))
    messages = []
    if not LEGS[0] < length < LEGS[1]:
        messages.append(f"legs are {length:.3g} m long. Is the unit right?")
    down = (ankles - hips).mean(axis=(0, 1))
    axis = int(np.argmax(np.abs(down)))
    if axis != 1 or down[1] > 0.0:
        messages.append(f"legs point along {'-+'[int(down[axis] > 0)]}{'XYZ'[axis]}. Is --up right?")
    return messages
