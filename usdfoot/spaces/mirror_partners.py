"""Which example is the mirror image of which."""

from __future__ import annotations

import numpy as np

from usdfoot.maths.types import IntArray
from usdfoot.model.examples import Examples

__all__ = ["mirror_partners"]


def mirror_partners(examples: Examples) -> IntArray:
    """Index of each example's mirror image, -1 if the library does not hold it, shape (E,).

    It is the step cut at the same time from the same clip, with the other foot swinging, one of the two mirrored.
    """
    clips, times = examples.clip_indices.tolist(), examples.start_times.tolist()
    sides, mirrored = examples.swing_sides.tolist(), examples.mirrored.tolist()
    index = {key: i for i, key in enumerate(zip(clips, times, sides, mirrored, strict=True))}
    partners = [
        index.get((clip, time, 1 - side, not flag), -1)
        for clip, time, side, flag in zip(clips, times, sides, mirrored, strict=True)
    ]
    return np.array(partners, dtype=np.intp)
