"""Cadences: how many steps a second people take along their curves, and when they stand."""

from __future__ import annotations

from typing import Any

import numpy as np
import warp as wp
from scipy.ndimage import maximum_filter1d

from usdfoot.analysis.timing import TimingRule
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.device import start_warp
from usdfoot.planning.creep_kernel import step_after_creeping
from usdfoot.planning.gait import longest_time, natural_lengths
from usdfoot.planning.root_curves import SPACING, RootCurves

__all__ = ["step_rates"]

STILL = 0.15
"""Slower people stand until they have crept away from their feet [m/s]."""
CREPT = 0.15
"""Who stands steps when the root is this far from where it stood, over the leg length."""
TURNED = np.radians(30.0)
"""Who stands steps when it has turned by this [rad]."""
TURN = np.radians(35.0)
"""Turn that takes a step of its own [rad]."""
QUICKEST = 1.4
"""Most steps a second of turning on the spot, and of side steps, over those of short steps."""
SIDE_STEP = 0.35
"""How far the root goes to the side in a step, over the leg length; the foot ahead goes twice as far."""
CLOSING = 1.0
"""Steps they go on for after they stop, so that the feet stand side by side."""
SHUFFLE = 2.0
"""Steps that bring both feet to where somebody crept to."""


def step_rates(curves: RootCurves, rule: TimingRule) -> tuple[FloatArray, FloatArray]:
    """Speeds [m/s] and steps a second at every frame, shape (A, F) each; 0 steps where they stand.

    Who moves so slowly that there is no telling it from swaying stands, until the root is so far from where it stood,
    or turned so far, that the feet have to follow.
    """
    velocities: FloatArray = np.gradient(curves.positions[..., [0, 2]], SPACING, axis=1)
    frames = np.clip(((curves.ends - curves.starts) / SPACING).astype(int) - 1, 0, velocities.shape[1] - 1)
    held = np.minimum(np.arange(velocities.shape[1]), frames[:, None])
    speeds = np.linalg.norm(velocities, axis=2)
    speeds = np.take_along_axis(speeds, held, axis=1)
    slowest = 1.0 / longest_time(rule)
    lengths = np.maximum(natural_lengths(speeds.ravel(), rule).reshape(speeds.shape), 1e-6)
    crept = CREPT * rule.leg_length
    goes = (speeds > STILL) & (_travels(curves.positions[..., [0, 2]], frames=round(1.0 / slowest / SPACING)) > crept)
    walking = np.where(goes, np.maximum(speeds / lengths, slowest), 0.0)
    turns = np.minimum(np.abs(np.gradient(curves.yaws, SPACING, axis=1)) / TURN, QUICKEST * slowest)
    aside = np.take_along_axis(np.abs(planar.rotate(-curves.yaws, velocities)[..., 0]), held, axis=1)
    side_steps = np.minimum(aside / (SIDE_STEP * rule.leg_length), QUICKEST * slowest)
    walking = np.where(goes, np.maximum(walking, side_steps), 0.0)
    rates = np.maximum(walking, np.where(turns > 0.1, np.maximum(turns, slowest), 0.0))
    reach = 2 * round(CLOSING / slowest / SPACING) + 1
    before = maximum_filter1d(rates, reach, axis=1, origin=reach // 2, mode="constant")
    rates = np.where(rates > 0.0, rates, np.where(before > 0.0, slowest, 0.0))
    return speeds, _with_shuffles(curves, rates, slowest=slowest, farthest=crept)


def _travels(points: FloatArray, *, frames: int) -> FloatArray:
    """How far it is from where roots (A, F, 2) were some frames before to where they are as many later [m], (A, F)."""
    every = np.arange(points.shape[1])
    ahead, behind = np.minimum(every + frames, every[-1]), np.maximum(every - frames, 0)
    return np.asarray(np.linalg.norm(points[:, ahead] - points[:, behind], axis=-1))


def _with_shuffles(curves: RootCurves, rates: FloatArray, *, slowest: float, farthest: float) -> FloatArray:
    """Steps a second (A, F) with those of people who creep up to `farthest` [m] from where they stood."""
    start_warp()
    stepped: Any = wp.array(rates, dtype=wp.float64)
    wp.launch(
        step_after_creeping,
        dim=len(rates),
        inputs=[
            wp.array(np.ascontiguousarray(curves.positions[..., [0, 2]]), dtype=wp.vec2d),
            wp.array(curves.yaws, dtype=wp.float64),
            slowest,
            round(SHUFFLE / slowest / SPACING),
            farthest,
            TURNED,
        ],
        outputs=[stepped],
        device="cpu",
    )
    return np.asarray(stepped.numpy())
