"""Characters whose Skeleton hangs below a transform that moves: their motion undoes it at every sample."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from usdfoot.maths.types import FloatArray
from usdfoot.model.motion import Motion
from usdfoot.writers.poses import RestingCharacter

__all__ = ["follow_transforms"]


def follow_transforms(
    motion: Motion, resting: RestingCharacter, frame_times: FloatArray
) -> tuple[Motion, RestingCharacter]:
    """The motion with samples wherever a transform above the Skeleton may move, and the character at these samples.

    Such a transform goes on while the agent holds its first or last pose, so the pose is repeated at the crowd's frames
    there. Both are as given if nothing above the Skeleton moves.

    Args:
        motion: Of one agent.
        resting: Its character.
        frame_times: Of the crowd's frames, those the character's `skeleton_to_agent` was read at [s], shape (K,).
    """
    similarity = resting.character.skeleton_to_agent
    if len(similarity) == 1:
        return motion, resting
    held = _held(motion, frame_times)
    character = replace(resting.character, skeleton_to_agent=similarity.at(frame_times, held.times))
    return held, replace(resting, character=character)


def _held(motion: Motion, frame_times: FloatArray) -> Motion:
    """The motion with its first and last pose repeated at the frames outside its own interval."""
    before, after = frame_times[frame_times < motion.times[0]], frame_times[frame_times > motion.times[-1]]
    count = len(motion.times)
    rows = np.concatenate([np.zeros(len(before), int), np.arange(count), np.full(len(after), count - 1)])
    return replace(
        motion,
        times=np.concatenate([before, motion.times, after]),
        root_positions=motion.root_positions[rows],
        root_yaws=motion.root_yaws[rows],
        pelvis_positions=motion.pelvis_positions[rows],
        pelvis_rotations=motion.pelvis_rotations[rows],
        rotations=motion.rotations[rows],
    )
