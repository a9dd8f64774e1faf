"""Whether clips of two files were recorded on one skeleton."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import BoolArray
from usdfoot.model.capture import Capture

__all__ = ["merged_captures", "same_bones"]

SAME = 1e-3
"""Bones whose ends differ by less are the same [m]: loops cut from a take differ by half a millimetre."""


def same_bones(first: Capture, second: Capture) -> bool:
    """Whether two skeletons have the same joints in the same order, and bones of the same lengths and directions.

    Where roots and joints that clips move rest does not count: files often hold any frame there.
    """
    if first.skeleton.joints != second.skeleton.joints:
        return False
    rests = first.skeleton.rest_translations, second.skeleton.rest_translations
    apart = np.abs(rests[0] - rests[1]).max(axis=1)
    return bool(np.all((apart < SAME) | (first.skeleton.parents < 0) | _moved(first) | _moved(second)))


def merged_captures(captures: list[Capture]) -> list[Capture]:
    """Captures with the clips of all that share a skeleton together, on the skeleton of the first."""
    merged: list[Capture] = []
    for capture in captures:
        place = next((i for i, other in enumerate(merged) if same_bones(other, capture)), None)
        if place is None:
            merged.append(capture)
        else:
            clips = (*merged[place].clips, *capture.clips)
            merged[place] = Capture(skeleton=merged[place].skeleton, clips=clips)
    return merged


def _moved(capture: Capture) -> BoolArray:
    """Joints that clips move against their parents, shape (J,)."""
    rest = capture.skeleton.rest_translations
    ways = [np.abs(clip.translations - rest).max(axis=(0, 2)) for clip in capture.clips]
    return np.max(ways, axis=0) > SAME if ways else np.zeros(len(rest), dtype=bool)
