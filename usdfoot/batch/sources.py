"""Sources: how smooth the clips were that a motion was blended from, at the motion's own rate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.analysis.smoothness import angular_jerks, angular_jumps, angular_speeds, body_joints, clip_rotations
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Crowd
from usdfoot.model.clip import Clip, ClipLibrary
from usdfoot.model.motion import Motion

__all__ = ["SourceFigures"]


class SourceFigures:
    """Smoothness of the clips of one scene's crowds, each clip measured when a motion first blends it."""

    def __init__(self) -> None:
        self._clips: dict[tuple[int, str], dict[str, FloatArray]] = {}
        self._figures: dict[tuple[int, frozenset[str]], dict[str, float]] = {}

    def of(self, crowd: Crowd, motions: Sequence[Motion]) -> dict[str, dict[str, float]]:
        """99th percentiles over the clips each agent blends, in radians and seconds.

        Args:
            crowd: Whose libraries must be the same in every call, or more.
            motions: Of agents of the crowd.

        Returns:
            By agent name: "kneeSpeedP99", "jointJerkP99", and of the jump of the joints' velocities "seamJumpP99"; an
            agent without clips has none.
        """
        libraries = {agent.name: agent.library for agent in crowd.agents}
        known = self._figures
        for motion in motions:
            index, names = key = libraries[motion.name], frozenset(motion.results.clips)
            if key not in known:
                library = crowd.libraries[index]
                clips = [clip for clip in library.clips if clip.name in names]
                parts = [self._figures_of(library, index, clip, crowd.frame_rate) for clip in clips]
                known[key] = _percentiles(parts)
        return {motion.name: known[libraries[motion.name], frozenset(motion.results.clips)] for motion in motions}

    def _figures_of(self, library: ClipLibrary, index: int, clip: Clip, rate: float) -> dict[str, FloatArray]:
        """All values of one clip of the library at an index."""
        if (index, clip.name) not in self._clips:
            joints = body_joints(library.skeleton, library.biped)
            rotations = clip_rotations(clip, library.skeleton, library.biped, rate=rate)
            self._clips[index, clip.name] = {
                "kneeSpeedP99": angular_speeds(rotations[:, list(library.biped.knees)], rate).ravel(),
                "jointJerkP99": angular_jerks(rotations[:, joints], rate).ravel(),
                "seamJumpP99": angular_jumps(rotations[:, joints], rate),
            }
        return self._clips[index, clip.name]


def _percentiles(parts: Sequence[dict[str, FloatArray]]) -> dict[str, float]:
    """99th percentile of each figure over the values of all parts."""
    names = parts[0] if parts else ()
    joined = {name: np.concatenate([part[name] for part in parts]) for name in names}
    return {name: float(np.quantile(values, 0.99)) for name, values in joined.items() if values.size}
