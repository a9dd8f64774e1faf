"""Standing as an example of its own: the same pose at every phase."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np

from usdfoot.analysis.standing import StandingPose
from usdfoot.model.examples import Examples

__all__ = ["with_stand"]


def with_stand(examples: Examples, pose: StandingPose) -> Examples:
    """The examples and, as the last, a stand: pelvis relative to the middle of both balls, heading +Z."""
    samples = examples.rotations.shape[1]
    longer: dict[str, Any] = {}
    for field in fields(examples):
        values = getattr(examples, field.name)
        if isinstance(values, np.ndarray):
            longer[field.name] = np.concatenate([values, np.zeros_like(values[:1])])
    rotations = np.array(pose.rotations, dtype=np.float32)
    rotations[pose.pelvis] = pose.pelvis_rotation
    longer["rotations"][-1] = np.broadcast_to(rotations, (samples, *rotations.shape))
    longer["pelvis_positions"][-1] = pose.pelvis_position
    longer["durations"][-1] = 1.0
    longer["clip_indices"][-1] = pose.clip
    return replace(examples, styles=(*examples.styles, ""), **longer)
