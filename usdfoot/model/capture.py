"""Capture: a skeleton and the clips recorded on it, as a file of another program holds them."""

from __future__ import annotations

from dataclasses import dataclass

from usdfoot.errors import ClipError
from usdfoot.model.clip import Clip
from usdfoot.model.skeleton import Skeleton

__all__ = ["Capture"]


@dataclass(frozen=True, kw_only=True)
class Capture:
    """Clips with samples for every joint of their skeleton, in canonical space.

    Raises:
        ClipError: If a clip has another number of joints.
    """

    skeleton: Skeleton
    """Its name is that of the file; its rest pose is the file's own, which nobody may ever have stood in."""
    clips: tuple[Clip, ...]
    """Their names say where they come from and may be alike."""

    def __post_init__(self) -> None:
        joints = len(self.skeleton.joints)
        for clip in self.clips:
            if clip.rotations.shape[1] != joints:
                what = f"moves {clip.rotations.shape[1]} joints, its skeleton has {joints}"
                raise ClipError(clip.name, what, "clip and skeleton belong together")
