"""The contacts of one clip."""

from __future__ import annotations

from usdfoot.analysis.world import listed_contacts, world_clip
from usdfoot.model.biped import Biped
from usdfoot.model.clip import Clip
from usdfoot.model.contacts import Contacts
from usdfoot.model.skeleton import Skeleton


def detect_contacts(clip: Clip, skeleton: Skeleton, biped: Biped) -> Contacts:
    """Contacts of a clip, listed as for users."""
    return listed_contacts(world_clip(clip, skeleton, biped))
