"""ASF: Acclaim's skeleton files, what bones there are and how AMC files move them.

A bone turns about its beginning, where its joint is. With C = `axis` and M = the rotations of its degrees of freedom,
both applied in the order in which they are listed, the joint's rotation is C M C^-1, and the bone ends at `direction`
times `length` from its joint. In the file's own pose all joint axes are parallel to the world's.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from usdfoot.errors import ClipError
from usdfoot.importers.bones import Bones, euler_rotations
from usdfoot.importers.text_lines import TextLine, number_in, number_rows, read_text_lines
from usdfoot.importers.units import metres_in
from usdfoot.maths.types import FloatArray
from usdfoot.model.limits import DEFAULT_LIMITS, Limits, check_limit

__all__ = ["ANGLES", "ROOT", "AcclaimSkeleton", "import_asf"]

ROOT = "root"
FREEDOMS = {f"{kind}{axis}": (kind, index) for kind in "tr" for index, axis in enumerate("xyz")}
"""t = translation, r = rotation, and the axis, by the names of the degrees of freedom in small letters."""
ANGLES = {"deg": np.pi / 180.0, "degrees": np.pi / 180.0, "rad": 1.0, "radians": 1.0}
"""Radians in a unit of angle."""


@dataclass(frozen=True, kw_only=True)
class AcclaimSkeleton:
    """Bones and what AMC files say about each of them."""

    file: str
    bones: Bones
    """J of them, the root first."""
    axes: FloatArray
    """C of each bone, xyzw, shape (J, 4)."""
    freedoms: tuple[tuple[tuple[str, int], ...], ...]
    """Of each bone, in the order of an AMC line's numbers: t or r, and the axis."""
    metres: float
    """In a unit of length of this file and its AMC files."""
    radians: float
    """In a unit of angle, unless the AMC file says otherwise."""


@dataclass(frozen=True, kw_only=True)
class _Bone:
    """One bone's lines by their first word."""

    line: TextLine
    name: str
    entries: Mapping[str, TextLine]

    def numbers(self, key: str, count: int) -> FloatArray:
        """So many numbers of an entry; zeros if a root does not have it."""
        line = self.entries.get(key)
        if line is None and self.name == ROOT:
            return np.zeros(count)
        if line is None:
            raise self.line.error(f"bone {self.name} has no {key}", f"{key} and {count} number(s) are needed")
        return number_rows([line.with_words(line.words[1 : count + 1])], count, f"numbers of {key}")[0]


def import_asf(file: str | os.PathLike[str], *, unit: str = "", limits: Limits = DEFAULT_LIMITS) -> AcclaimSkeleton:
    """The skeleton of a file.

    Args:
        file: ASF file.
        unit: What the file's lengths would be in if its `:units length` were 1: lengths are divided by that scale.
            m, cm, mm, ft, in, or metres a unit; inches for the files of CMU.
        limits: How many joints it may have.

    Raises:
        ClipError: If the unit is missing or the file malformed; the line is named.
        SceneError: If it has more joints than the limits allow.
    """
    path = Path(file)
    sections = _sections(path)
    scales = {line.words[0].lower(): line for line in sections.get("units", ())}
    if not unit:
        said = " ".join(scales["length"].words) if "length" in scales else "no scale"
        what = f"says {said} under :units, but not of which unit"
        raise ClipError(path, what, "give --unit: in for files of CMU, or m, cm, metres a unit")
    length = _positive(scales["length"]) if "length" in scales else 1.0
    radians = _angle(scales["angle"]) if "angle" in scales else ANGLES["deg"]
    found = [_Bone(line=sections["root"][0], name=ROOT, entries=_entries(sections["root"]))]
    found += _bones(sections["bonedata"])
    check_limit(path, "joints", len(found), limit=limits.joints)
    order, parents = _hierarchy(path, sections["hierarchy"], [bone.name for bone in found])
    ordered = [found[index] for index in order]
    metres = metres_in(unit, "unit", error=ClipError) / length
    bones = _placed(ordered, parents, metres)
    return AcclaimSkeleton(
        file=str(path),
        bones=bones,
        axes=np.concatenate([_axis(bone, radians) for bone in ordered]),
        freedoms=tuple(_freedoms(bone) for bone in ordered),
        metres=metres,
        radians=radians,
    )


def _sections(path: Path) -> dict[str, list[TextLine]]:
    """Lines below each :keyword."""
    sections: dict[str, list[TextLine]] = {}
    current = ""
    for line in read_text_lines(path):
        if line.words[0].startswith(":"):
            current = line.words[0][1:].lower()
            sections.setdefault(current, [])
        elif current:
            sections[current].append(line)
        else:
            raise line.error(f"{line.words[0]!r} stands before any section", "an ASF file begins with :version")
    for needed in ("root", "bonedata", "hierarchy"):
        if not sections.get(needed):
            raise ClipError(path, f"has no :{needed}", "an ASF file has :root, :bonedata and :hierarchy")
    return sections


def _positive(line: TextLine) -> float:
    value = number_in(line, line.words[1]) if len(line.words) > 1 else 0.0
    if value <= 0.0:
        raise line.error("is no scale", "a number above 0 is")
    return value


def _angle(line: TextLine) -> float:
    word = line.words[1].lower() if len(line.words) > 1 else ""
    if word not in ANGLES:
        raise line.error(f"{word!r} is no unit of angle", "deg and rad are")
    return ANGLES[word]


def _entries(lines: Sequence[TextLine]) -> dict[str, TextLine]:
    return {line.words[0].lower(): line for line in lines}


def _bones(lines: Sequence[TextLine]) -> Iterator[_Bone]:
    """Bones between begin and end."""
    inside: list[TextLine] | None = None
    start = lines[0]
    names = {ROOT}
    for line in lines:
        word = line.words[0].lower()
        if word == "begin":
            inside, start = [], line
        elif inside is None:
            raise line.error(f"{line.words[0]!r} is outside of a bone", "a bone's lines are between begin and end")
        elif word == "end":
            entries = _entries(inside)
            if "name" not in entries or len(entries["name"].words) != 2:
                raise start.error("begins a bone without a name", "give it one, like name lfemur")
            name = entries["name"].words[1]
            if name in names:
                raise entries["name"].error(f"bone {name} is there already", "names are unique")
            names.add(name)
            yield _Bone(line=start, name=name, entries=entries)
            inside = None
        else:
            inside.append(line)
    if inside is not None:
        raise start.error("begins a bone that never ends", "close it with end")


def _hierarchy(path: Path, lines: Sequence[TextLine], names: Sequence[str]) -> tuple[list[int], list[int]]:
    """Bones (indices of `names`) with parents first, and the parent of each as an index into that order."""
    children: dict[str, list[str]] = {name: [] for name in names}
    placed = {ROOT}
    for line in lines:
        if line.words[0].lower() in ("begin", "end"):
            continue
        for name in line.words:
            if name not in children:
                raise line.error(f"{name!r} is no bone", "bones of :bonedata and root hang on each other")
        for name in line.words[1:]:
            if name in placed:
                raise line.error(f"bone {name} hangs on another bone already", "every bone hangs on one")
            placed.add(name)
            children[line.words[0]].append(name)
    order, parents = [ROOT], [-1]
    for index, name in enumerate(order):  # grows while it is walked
        order += children[name]
        parents += [index] * len(children[name])
    if len(order) < len(names):
        loose = sorted(set(names) - set(order))
        raise ClipError(path, "bones do not hang on the root", "name them in :hierarchy", loose)
    return [names.index(name) for name in order], parents


def _placed(bones: Sequence[_Bone], parents: Sequence[int], metres: float) -> Bones:
    """Joints at the beginnings of the bones."""
    ends = []
    for bone in bones:
        if bone.name == ROOT:
            ends.append(np.zeros(3))
            continue
        direction = bone.numbers("direction", 3)
        size = float(np.linalg.norm(direction))
        if not size > 0.0:
            raise bone.entries["direction"].error("is no direction", "a direction has a length")
        ends.append(direction / size * bone.numbers("length", 1)[0] * metres)
    offsets = np.array(
        [ends[parent] if parent >= 0 else bones[0].numbers("position", 3) * metres for parent in parents]
    )
    leaves = set(range(len(bones))) - set(parents)
    return Bones(
        names=tuple(bone.name for bone in bones),
        parents=tuple(parents),
        offsets=offsets,
        ends={leaf: ends[leaf] for leaf in sorted(leaves)},
    )


def _axis(bone: _Bone, radians: float) -> FloatArray:
    """C of a bone, shape (1, 4)."""
    is_root = bone.name == ROOT
    angles = bone.numbers("orientation" if is_root else "axis", 3)
    line = bone.entries.get("axis")
    word = line.words[1 if is_root else 4 :] if line else ()
    order = word[0].lower() if word else "xyz"
    if line and sorted(order) != ["x", "y", "z"]:
        raise line.error(f"{order!r} is no order of axes", "XYZ and its permutations are")
    axes = ["xyz".index(letter) for letter in reversed(order)]
    return euler_rotations(radians * angles[None, ::-1], axes)


def _freedoms(bone: _Bone) -> tuple[tuple[str, int], ...]:
    line = bone.entries.get("order" if bone.name == ROOT else "dof")
    words = [word.lower() for word in line.words[1:]] if line else []
    if line is None and bone.name == ROOT:
        words = ["tx", "ty", "tz", "rx", "ry", "rz"]
    for word in words:
        if line and word not in FREEDOMS:
            raise line.error(f"degree of freedom {word!r} is not read", "tx ty tz rx ry rz are")
    return tuple(FREEDOMS[word] for word in words)
