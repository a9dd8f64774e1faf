"""The HIERARCHY section of a BVH file: joints with their offsets and channels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from usdfoot.importers.text_lines import TextLine, number_in
from usdfoot.maths.types import FloatArray
from usdfoot.model.limits import Limits, check_limit

__all__ = ["Channel", "Hierarchy", "read_hierarchy"]

Channel = tuple[str, int]
"""position | rotation | scale, and the axis, 0 = x."""
CHANNELS: dict[str, Channel] = {
    f"{axis}{kind}": (kind, index) for kind in ("position", "rotation", "scale") for index, axis in enumerate("xyz")
}
"""By their names in small letters."""
END_SITE = -1


@dataclass(frozen=True, kw_only=True)
class Hierarchy:
    """J joints, parents before children."""

    names: list[str] = field(default_factory=list)
    parents: list[int] = field(default_factory=list)
    lines: list[TextLine] = field(default_factory=list)
    """Where each begins."""
    offsets: dict[int, FloatArray] = field(default_factory=dict)
    """From the parent in the file's unit, by joint."""
    channels: dict[int, tuple[Channel, ...]] = field(default_factory=dict)
    """In the order of the motion's numbers, by joint."""
    ends: dict[int, FloatArray] = field(default_factory=dict)
    """End Sites, from their joint in the file's unit, by joint."""


def read_hierarchy(lines: Sequence[TextLine], limits: Limits) -> Hierarchy:
    """The joints between HIERARCHY and MOTION.

    Raises:
        ClipError: If a line is wrong; it is named.
        SceneError: If there are more joints than the limits allow.
    """
    tree = Hierarchy()
    opened: list[int] = []
    for line in _separated(lines):
        keyword = line.words[0].upper()
        if keyword in ("ROOT", "JOINT", "END"):
            opened.append(_begun(tree, line, opened))
            check_limit(line.file, "joints", len(tree.names), limit=limits.joints)
        elif not opened:
            expected = "MOTION comes next" if tree.names else "ROOT and its name come first"
            raise line.error(f"{line.words[0]!r} belongs to no joint", expected)
        elif keyword == "}":
            _check_complete(tree, line, opened)
            opened.pop()
        elif keyword == "OFFSET":
            _set_offset(tree, line, opened)
        elif keyword == "CHANNELS":
            _set_channels(tree, line, opened)
        elif keyword != "{":
            raise line.error(f"{line.words[0]!r} is unknown", "OFFSET, CHANNELS, JOINT, End Site, { and } are known")
    if opened:
        joint = next(joint for joint in reversed(opened) if joint != END_SITE)
        raise tree.lines[joint].error(f"joint {tree.names[joint]} is never closed", "every { needs a }")
    return tree


def _separated(lines: Sequence[TextLine]) -> Iterator[TextLine]:
    """Lines with each bracket and each keyword after one on a line of its own."""
    for line in lines:
        words: list[str] = []
        for word in " ".join(line.words).replace("{", " { ").replace("}", " } ").split():
            if word not in ("{", "}"):
                words.append(word)
                continue
            if words:
                yield line.with_words(words)
            yield line.with_words([word])
            words = []
        if words:
            yield line.with_words(words)


def _begun(tree: Hierarchy, line: TextLine, opened: Sequence[int]) -> int:
    """Index of the joint that begins in a line, `END_SITE` for one."""
    keyword, name = line.words[0].upper(), " ".join(line.words[1:])
    if opened and opened[-1] == END_SITE:
        raise line.error("is inside of an End Site", "nothing hangs on an End Site; close it with }")
    if keyword == "END":
        if not opened:
            raise line.error("is no part of a joint", "an End Site is inside of one")
        return END_SITE
    if keyword == "ROOT" and tree.names:
        raise line.error("is a second ROOT", "one skeleton a file; split it into two files")
    if keyword == "JOINT" and not opened:
        raise line.error("is outside of the ROOT", "all other joints are inside of it")
    if not name:
        raise line.error(f"{keyword} has no name", f"give it one, like {keyword} Hips")
    tree.names.append(name)
    tree.parents.append(opened[-1] if opened else -1)
    tree.lines.append(line)
    return len(tree.names) - 1


def _set_offset(tree: Hierarchy, line: TextLine, opened: Sequence[int]) -> None:
    if len(line.words) != 4:
        raise line.error(f"OFFSET has {len(line.words) - 1} numbers", "it has three")
    offset = np.array([number_in(line, word) for word in line.words[1:]])
    if opened[-1] == END_SITE:
        tree.ends[opened[-2]] = offset
    elif opened[-1] in tree.offsets:
        raise line.error(f"joint {tree.names[opened[-1]]} has an OFFSET already", "remove one")
    else:
        tree.offsets[opened[-1]] = offset


def _set_channels(tree: Hierarchy, line: TextLine, opened: Sequence[int]) -> None:
    names = [word.lower() for word in line.words[2:]]
    unknown = [word for word in line.words[2:] if word.lower() not in CHANNELS]
    if opened[-1] == END_SITE:
        raise line.error("gives an End Site channels", "an End Site has none; make it a JOINT")
    if opened[-1] in tree.channels:
        raise line.error(f"joint {tree.names[opened[-1]]} has CHANNELS already", "remove one of the lines")
    if unknown:
        raise line.error(
            f"channel {unknown[0]!r} is unknown", "Xposition to Zposition, Xrotation to Zrotation are known"
        )
    if len(line.words) < 2 or line.words[1] != str(len(names)):
        raise line.error(f"lists {len(names)} channels, not {' '.join(line.words[1:2]) or 'a number'}", "correct it")
    if len(set(names)) != len(names):
        raise line.error("lists a channel twice", "every channel is there once")
    tree.channels[opened[-1]] = tuple(CHANNELS[name] for name in names)


def _check_complete(tree: Hierarchy, line: TextLine, opened: Sequence[int]) -> None:
    """Raises ClipError if what a bracket closes has no offset."""
    if opened[-1] == END_SITE:
        if opened[-2] not in tree.ends:
            raise line.error("closes an End Site without OFFSET", "give it one, like OFFSET 0 0 0")
    elif opened[-1] not in tree.offsets:
        raise line.error(f"closes joint {tree.names[opened[-1]]} without OFFSET", "give it one, like OFFSET 0 0 0")
