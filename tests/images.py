"""Mirror images of whole clips and of their contacts."""

from dataclasses import replace

import numpy as np

from usdfoot.analysis.mirror import MirrorMap, mirrored_rotations
from usdfoot.maths import quaternion
from usdfoot.model.clip import Clip
from usdfoot.model.contacts import Contacts, FootContacts

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


def mirrored_contacts(contacts: Contacts) -> Contacts:
    """Mirror image of contacts in the plane x = 0."""
    return Contacts(left=_mirrored_foot(contacts.right), right=_mirrored_foot(contacts.left))


def _mirrored_foot(foot: FootContacts) -> FootContacts:
    return replace(foot, positions=foot.positions * REFLECTION, yaws=-foot.yaws)
