"""Mirror images of whole clips."""

from dataclasses import replace

import numpy as np

from usdfoot.analysis.mirror import MirrorMap, mirrored_rotations
from usdfoot.maths import quaternion
from usdfoot.model.clip import Clip

REFLECTION = np.array([-1.0, 1.0, 1.0])


def mirrored_clip(clip: Clip, mirror: MirrorMap) -> Clip:
    """Mirror image of a clip in the plane x = 0 of its world, with its own proportions mirrored too."""
    images = clip.translations[:, mirror.partners] * REFLECTION
    return replace(
        clip,
        translations=quaternion.rotate(mirror.parent_inverses, images),
        rotations=quaternion.continuous(mirrored_rotations(clip.rotations, mirror)),
        events=(clip.events[1], clip.events[0]),
    )
