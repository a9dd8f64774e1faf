"""Sources: how smooth the clips were that a motion was blended from, at the motion's own rate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.analysis.smoothness import angular_jerks, angular_speeds, body_joints, clip_rotations
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Crowd
from usdfoot.model.clip import Clip, ClipLibrary
from usdfoot.model.motion import Motion

__all__ = ["source_figures"]


def source_figures(crowd: Crowd, motions: Sequence[Motion]) -> dict[str, dict[str, float]]:
    """99th percentiles of knee speed [rad/s] and joint jerk [rad/s3] of the clips each agent blends.

    Returns:
        By agent name: "kneeSpeedP99" and "jointJerkP99"; an agent without clips has neither.
    """
    libraries = {agent.name: agent.library for agent in crowd.agents}
    known: dict[tuple[int, frozenset[str]], dict[str, float]] = {}
    figures = {}
    for motion in motions:
        key = (libraries[motion.name], frozenset(motion.results.clips))
        if key not in known:
            library = crowd.libraries[key[0]]
            clips = [clip for clip in library.clips if clip.name in key[1]]
            known[key] = _figures_of(library, clips, crowd.frame_rate)
        figures[motion.name] = known[key]
    return figures


def _figures_of(library: ClipLibrary, clips: Sequence[Clip], rate: float) -> dict[str, float]:
    joints = body_joints(library.skeleton, library.biped)
    speeds: list[FloatArray] = [np.zeros(0)]
    jerks: list[FloatArray] = [np.zeros(0)]
    for clip in clips:
        rotations = clip_rotations(clip, library.skeleton, library.biped, rate=rate)
        speeds.append(angular_speeds(rotations[:, list(library.biped.knees)], rate).ravel())
        jerks.append(angular_jerks(rotations[:, joints], rate).ravel())
    speed, jerk = np.concatenate(speeds), np.concatenate(jerks)
    if not speed.size or not jerk.size:
        return {}
    return {"kneeSpeedP99": float(np.quantile(speed, 0.99)), "jointJerkP99": float(np.quantile(jerk, 0.99))}
