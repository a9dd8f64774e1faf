"""AMC: Acclaim's motion files, which move the bones of an ASF file."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from usdfoot.errors import ClipError
from usdfoot.importers.asf import ANGLES, AcclaimSkeleton
from usdfoot.importers.bones import bone_clip, bone_skeleton, euler_rotations, with_ball_ends
from usdfoot.importers.text_lines import TextLine, number_rows, read_text_lines
from usdfoot.maths import quaternion
from usdfoot.model.capture import Capture
from usdfoot.model.clip import Clip
from usdfoot.model.limits import DEFAULT_LIMITS, Limits, check_limit
from usdfoot.model.report import Problem

__all__ = ["import_amc", "skeleton_files"]


def import_amc(
    file: str | os.PathLike[str], skeleton: AcclaimSkeleton, *, rate: float = 0.0, limits: Limits = DEFAULT_LIMITS
) -> tuple[Capture, tuple[Problem, ...]]:
    """The skeleton with the clip of a file, in the files' axes, and what was odd.

    The clip's first sample is at its frame number over the rate.

    Args:
        file: AMC file.
        skeleton: Of its ASF file.
        rate: Frames a second, which the file does not say.
        limits: How many frames it may have.

    Raises:
        ClipError: If the rate is missing or the file malformed; the line is named.
        SceneError: If it has more frames than the limits allow.
    """
    path = Path(file)
    if not rate:
        raise ClipError(path, "does not say how many frames a second it has", "give --rate: 120 for files of CMU")
    model = bone_skeleton(skeleton.file, with_ball_ends(skeleton.file, skeleton.bones))
    clip, unmoved = _read_clip(path, skeleton, rate, limits)
    problems = []
    if unmoved:
        message = f"{path}: does not move {', '.join(unmoved)}, which keep still"
        problems.append(Problem(severity="warning", where=str(path), message=message))
    return Capture(skeleton=model, clips=(bone_clip(model, clip),)), tuple(problems)


def skeleton_files(paths: Sequence[Path]) -> dict[Path, Path | None]:
    """The ASF file of each AMC file: the only one, else that with the longest name that its own begins with."""
    skeletons = [path for path in paths if path.suffix.lower() == ".asf"]
    pairs: dict[Path, Path | None] = {}
    for motion in (path for path in paths if path.suffix.lower() == ".amc"):
        fitting = [path for path in skeletons if len(skeletons) == 1 or motion.stem.startswith(path.stem)]
        pairs[motion] = max(fitting, key=lambda path: len(path.stem), default=None)
    return pairs


def _read_clip(path: Path, skeleton: AcclaimSkeleton, rate: float, limits: Limits) -> tuple[Clip, tuple[str, ...]]:
    """The clip, and the bones that could move and are not in the file."""
    freedoms = dict(zip(skeleton.bones.names, skeleton.freedoms, strict=True))
    radians, starts, rows = _read_frames(path, freedoms, skeleton.radians, limits)
    count = len(starts)
    joints = len(freedoms)
    translations = np.tile(skeleton.bones.offsets, (count, 1, 1))
    rotations = np.tile([0.0, 0.0, 0.0, 1.0], (count, joints, 1))
    for joint, (name, kinds) in enumerate(freedoms.items()):
        if name not in rows:
            continue
        values = number_rows(rows[name], len(kinds), f"degrees of freedom of {name}")
        turned = [column for column, (kind, _) in enumerate(kinds) if kind == "r"]
        turns = euler_rotations(radians * values[:, turned[::-1]], [kinds[column][1] for column in turned[::-1]])
        axis = skeleton.axes[joint]
        rotations[:, joint] = quaternion.compose(quaternion.compose(axis, turns), quaternion.inverse(axis))
        for column, (kind, way) in enumerate(kinds):
            if kind == "t":
                along = quaternion.rotate(axis, np.eye(3)[way]) if joint else np.eye(3)[way]
                translations[:, joint] += skeleton.metres * values[:, column, None] * along
    clip = Clip(
        name=path.stem,
        rate=rate,
        start_time=starts[0] / rate,
        translations=translations,
        rotations=quaternion.continuous(rotations),
    )
    return clip, tuple(name for name, kinds in freedoms.items() if kinds and name not in rows)


def _read_frames(
    path: Path, freedoms: Mapping[str, object], radians: float, limits: Limits
) -> tuple[float, list[int], dict[str, list[TextLine]]]:
    """Radians in a unit of angle, the frames' numbers, and each bone's numbers, a line a frame.

    Raises:
        ClipError: If frames are not numbered one after the other, or do not all have the same bones, once each.
    """
    numbers: list[int] = []
    rows: dict[str, list[TextLine]] = {}
    opening: TextLine | None = None
    for line in read_text_lines(path):
        first = line.words[0]
        if first.startswith(":"):
            radians = ANGLES.get(first[1:].lower(), radians)
        elif first.isdecimal() and len(line.words) == 1:
            _check_frame(opening, rows, len(numbers))
            if numbers and int(first) != numbers[-1] + 1:
                raise line.error(f"frame {first} follows {numbers[-1]}", "frames are numbered one after the other")
            numbers.append(int(first))
            check_limit(path, "frames", len(numbers), limit=limits.frames)
            opening = line
        elif opening is None:
            raise line.error(f"{first!r} stands before the first frame", "a frame begins with its number")
        else:
            if first not in freedoms:
                raise line.error(f"{first!r} is no bone of the ASF file", "the AMC file may belong to another one")
            own = rows.setdefault(first, [])
            if len(own) != len(numbers) - 1:
                twice = len(own) == len(numbers)
                raise line.error(
                    f"frame {numbers[-1]} has {first} {'twice' if twice else 'and frames before it have not'}",
                    "every frame has the same bones, each once",
                )
            own.append(line.with_words(line.words[1:]))
    if opening is None:
        raise ClipError(path, "has no frames", "a frame begins with its number")
    _check_frame(opening, rows, len(numbers))
    return radians, numbers, rows


def _check_frame(opening: TextLine | None, rows: Mapping[str, Sequence[TextLine]], count: int) -> None:
    """Raises ClipError if a frame, the last of that many, lacks a bone that others have."""
    missing = [name for name, own in rows.items() if len(own) < count]
    if opening is not None and missing:
        raise opening.error(
            f"the frame that begins here has no {', '.join(missing)}", "complete it or cut the file off"
        )
