"""Sources: how smooth the clips were that a motion was blended from, at the motion's own rate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.analysis.smoothness import angular_jerks, angular_jumps, angular_speeds, body_joints, clip_rotations
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Crowd
from usdfoot.model.clip import Clip, ClipLibrary
from usdfoot.model.motion import Motion

__all__ = ["source_figures"]


def source_figures(crowd: Crowd, motions: Sequence[Motion]) -> dict[str, dict[str, float]]:
    """99th percentiles over the clips each agent blends, in radians and seconds.

    Returns:
        By agent name: "kneeSpeedP99", "jointJerkP99", and of the jump of the joints' velocities "seamJumpP99"; an agent
        without clips has none.
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
    parts: dict[str, list[FloatArray]] = {"kneeSpeedP99": [], "jointJerkP99": [], "seamJumpP99": []}
    for clip in clips:
        rotations = clip_rotations(clip, library.skeleton, library.biped, rate=rate)
        parts["kneeSpeedP99"].append(angular_speeds(rotations[:, list(library.biped.knees)], rate).ravel())
        parts["jointJerkP99"].append(angular_jerks(rotations[:, joints], rate).ravel())
        parts["seamJumpP99"].append(angular_jumps(rotations[:, joints], rate))
    joined = {name: np.concatenate(values) for name, values in parts.items() if values}
    return {name: float(np.quantile(values, 0.99)) for name, values in joined.items() if values.size}
