"""BVH: Biovision's motion capture files.

A joint's rotation is the product of its rotation channels in their order, the first outermost. Position channels
replace the OFFSET, as MotionBuilder, Blender and the data of Bandai Namco mean them; axes without a channel keep it.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Sequence
from decimal import Decimal, InvalidOperation
from pathlib import Path

import numpy as np

from usdfoot.errors import ClipError
from usdfoot.importers.bones import Bones, bone_clip, bone_skeleton, euler_rotations, with_ball_ends
from usdfoot.importers.bvh_hierarchy import Hierarchy, read_hierarchy
from usdfoot.importers.text_lines import TextLine, number_rows, read_text_lines
from usdfoot.importers.units import metres_in
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.capture import Capture
from usdfoot.model.clip import Clip
from usdfoot.model.limits import DEFAULT_LIMITS, Limits, check_limit

__all__ = ["import_bvh"]

_logger = logging.getLogger(__name__)

NTSC = 1.001
"""Television's rates are whole numbers over this."""
COARSE = Decimal("0.01")
"""A frame time with so few digits that the last is a larger part of it is taken as it stands."""
SINGLE_PRECISION = Decimal("1e-6")
"""Relative rounding of programs that compute in single precision."""


def import_bvh(file: str | os.PathLike[str], *, unit: str = "", limits: Limits = DEFAULT_LIMITS) -> Capture:
    """Skeleton and clip of a file, in its own axes.

    Args:
        file: BVH file.
        unit: Of its lengths, which it does not say: m, cm, mm, ft, in, or metres a unit.
        limits: How many joints and frames it may have.

    Raises:
        ClipError: If the unit is missing or the file malformed; the line is named.
        SceneError: If it has more joints or frames than the limits allow.
    """
    path = Path(file)
    lines = read_text_lines(path, comments=("#", "//"))
    if not lines or lines[0].words[0].upper() != "HIERARCHY":
        raise ClipError(path, "does not begin with HIERARCHY", "a BVH file does")
    if not unit:
        raise ClipError(path, "does not say in which unit its lengths are", "give --unit: cm, m, in, or metres a unit")
    metres = metres_in(unit, "unit", error=ClipError)
    start = next((i for i, line in enumerate(lines) if line.words[0].upper() == "MOTION"), len(lines))
    tree = read_hierarchy(lines[1:start], limits)
    if not tree.names:
        raise lines[0].error("is not followed by a ROOT", "ROOT and its name come next")
    values, rate = _read_motion(lines[start:] or lines[-1:], tree, limits)
    translations, rotations = _local_samples(tree, values)
    moving = np.ptp(translations, axis=0).max(axis=1) > 0.0
    offsets = np.array([tree.offsets[joint] for joint in range(len(tree.names))])
    bones = Bones(
        names=tuple(tree.names),
        parents=tuple(tree.parents),
        offsets=metres * np.where(moving[:, None], offsets, translations[0]),
        ends={joint: metres * end for joint, end in tree.ends.items()},
    )
    skeleton = bone_skeleton(str(path), with_ball_ends(str(path), bones))
    clip = Clip(
        name=path.stem,
        rate=rate,
        start_time=0.0,
        translations=metres * translations,
        rotations=quaternion.continuous(rotations),
    )
    return Capture(skeleton=skeleton, clips=(bone_clip(skeleton, clip),))


def _read_motion(lines: Sequence[TextLine], tree: Hierarchy, limits: Limits) -> tuple[FloatArray, float]:
    """Numbers of all frames (T, C) and the rate [Hz]; the lines begin with MOTION."""
    if lines[0].words[0].upper() != "MOTION":
        raise lines[0].error("is the end; there is no MOTION", "the file is cut off")
    frames = _value_after(lines, 1, "Frames:")
    if not frames.isdecimal() or int(frames) < 1:
        raise lines[1].error(f"{frames!r} is no number of frames", "a whole number above 0 is")
    check_limit(lines[0].file, "frames", int(frames), limit=limits.frames)
    rate = _written_rate(lines[min(2, len(lines) - 1)], _value_after(lines, 2, "Frame Time:"))
    rows = lines[3:]
    if len(rows) < int(frames):
        what = f"is the last: there are {len(rows)} lines of frames, and line {lines[1].number} says {frames}"
        raise lines[-1].error(what, f"say Frames: {len(rows)}, or complete the file")
    if len(rows) > int(frames):
        _logger.warning(
            "%s: has %d lines after its %s frames, left out", lines[0].file, len(rows) - int(frames), frames
        )
    count = sum(len(channels) for channels in tree.channels.values())
    return number_rows(rows[: int(frames)], count, "channels"), rate


def _value_after(lines: Sequence[TextLine], index: int, label: str) -> str:
    """The word after a label that has to begin a line; the line may be missing."""
    line = lines[min(index, len(lines) - 1)]
    text = " ".join(line.words)
    if index >= len(lines) or not text.lower().startswith(label.lower()):
        raise line.error(f"stands where {label!r} was expected", "MOTION is followed by Frames: and Frame Time:")
    return text[len(label) :].strip()


def _local_samples(tree: Hierarchy, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Joint-local translations in the file's unit (T, J, 3) and rotations (T, J, 4) of the numbers (T, C)."""
    joints = range(len(tree.names))
    translations = np.tile([tree.offsets[joint] for joint in joints], (len(values), 1, 1))
    rotations = np.tile([0.0, 0.0, 0.0, 1.0], (len(values), len(tree.names), 1))
    first = 0
    for joint in joints:
        channels = tree.channels.get(joint, ())
        kinds = [kind for kind, _ in channels]
        turned = [column for column, kind in enumerate(kinds) if kind == "rotation"]
        for column, (kind, axis) in enumerate(channels):
            if kind == "position":
                translations[:, joint, axis] = values[:, first + column]
        angles = np.radians(values[:, [first + column for column in turned]])
        rotations[:, joint] = euler_rotations(angles, [channels[column][1] for column in turned])
        first += len(channels)
    return translations, rotations


def _written_rate(line: TextLine, word: str) -> float:
    """Frames a second [Hz] for a frame time [s] as written: the whole (or television's) rate it may be the rounding of.

    0.0333333 is 30 frames a second, not 30.00003.

    Raises:
        UsdfootError: If it is no positive number.
    """
    try:
        time = Decimal(word)
    except InvalidOperation:
        time = Decimal(0)
    if not (time.is_finite() and 0 < time < 1_000_000):
        raise line.error(f"{word!r} is no frame time", "seconds above 0, like 0.0333333, are")
    exact = float(1 / time)
    digit = Decimal(1).scaleb(int(time.as_tuple().exponent))
    if digit > COARSE * time:
        return exact
    for rate in (float(round(exact)), round(exact * NTSC) / NTSC):
        if rate > 0.0 and abs(Decimal(1.0 / rate) - time) <= max(digit, SINGLE_PRECISION * time):
            return rate
    return exact
