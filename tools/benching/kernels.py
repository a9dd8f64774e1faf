"""Microseconds per agent-frame of the kernels, and per step of the set-up, on one core."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import warp as wp

from benching.rigs import walking_crowd, with_joints
from benching.stopwatch import best_time, function_times
from usdfoot.engine.animate import PreparedLibrary, PreparedSteps, prepare_library, prepare_steps
from usdfoot.engine.contact_feet import device_feet
from usdfoot.engine.frames import Frames, lay_frames
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.plant import plant_feet
from usdfoot.engine.planting import plant_frames
from usdfoot.engine.poses import ClipPoses, device_segments, place_segments
from usdfoot.maths.types import IntArray
from usdfoot.model.clip import ClipLibrary

__all__ = ["frame_times", "step_times"]

WEIGHTS = (0.4, 0.3, 0.2, 0.1)


def frame_times(library: ClipLibrary, joints: int, *, agents: int = 40, frames: int = 300) -> dict[str, float]:
    """Microseconds per agent-frame with four clips blended.

    Returns:
        By part: "warp, blend, place" (times to phases and headings, all joints and the pelvis), "plant" (both legs by
        IK), and "frame" for all of it.
    """
    options = EngineOptions()
    resized = with_joints(library, joints)
    prepared = prepare_library(resized, options)
    crowd = walking_crowd(resized, agents=agents, frames=frames)
    steps = _four_clips(prepared, prepare_steps(prepared, crowd.agents, crowd, options=options))
    laid = lay_frames(steps.setup.contacts, steps.setup.segments, crowd.frame_times)
    count = len(laid.times) / 1e6
    whole = best_time(lambda: plant_frames(steps.planting, laid)) / count
    moving = np.delete(np.arange(joints), steps.setup.library.pelvis)
    posing = best_time(lambda: _pose(steps, laid, moving)) / count
    plant = _plant_time(steps, laid, moving) / count
    return {
        "warp, blend, place": posing,
        "plant": plant,
        "frame": whole,
    }


def _pose(steps: PreparedSteps, frames: Frames, joints: IntArray) -> object:
    return steps.planting.source.pose(frames.segments, frames.times, joints=joints)


def _four_clips(library: PreparedLibrary, steps: PreparedSteps) -> PreparedSteps:
    """The steps blended of four examples each, whatever their landings asked for."""
    chosen = steps.blend.examples.copy()
    sides = library.examples.swing_sides[:-1]
    for row, first in enumerate(chosen[:, 0]):
        same = np.flatnonzero(sides == library.examples.swing_sides[first])
        chosen[row] = same[(int(np.searchsorted(same, first)) + np.arange(4)) % len(same)]
    blend = replace(steps.blend, examples=chosen, weights=np.tile(WEIGHTS, (len(chosen), 1)))
    source = ClipPoses(setup=steps.setup, arrays=place_segments(steps.setup, device_segments(steps.setup, blend)))
    return replace(steps, blend=blend, planting=replace(steps.planting, source=source))


def _plant_time(steps: PreparedSteps, frames: Frames, joints: IntArray) -> float:
    """Time of the kernel that plants all frames [s]."""
    poses = steps.planting.source.pose(frames.segments, frames.times, joints=joints)
    setup = steps.setup
    clock = frames.times - setup.contacts.starts[frames.agents]
    inputs = [
        setup.rig.arrays,
        device_feet(setup, steps.planting.feet, steps.planting.detours),
        wp.array(frames.contacts.astype(np.int32), dtype=wp.int32),
        wp.array(clock.astype(np.float32), dtype=wp.float32),
        wp.empty((0, 2), dtype=wp.vec3f),
        wp.empty((0, 2), dtype=wp.vec3f),
        poses.pelvis_positions,
        poses.pelvis_rotations,
        poses.rotations,
    ]
    return best_time(lambda: wp.launch(plant_feet, dim=len(frames.times), inputs=inputs))


def step_times(library: ClipLibrary, *, agents: int = 100, frames: int = 240) -> dict[str, float]:
    """Microseconds per step of what is prepared once.

    Returns:
        By part: "contacts, segments", "locate, weights, correction", of which "on the device", then "seams", "feet",
        "detours", and "set-up" for all of it.
    """
    options = EngineOptions()
    prepared = prepare_library(library, options)
    crowd = walking_crowd(library, agents=agents, frames=frames)

    def run() -> PreparedSteps:
        return prepare_steps(prepared, crowd.agents, crowd, options=options)

    count = sum(len(agent.plan) for agent in crowd.agents) / 1e6
    parts = {
        "contacts": "lay_contacts",
        "locate, weights, correction": "weigh_steps",
        "  of which on the device": "correct_steps",
        "seams": "measure_seams",
        "feet": "prepare_feet",
        "detours": "plan_detours",
    }
    spent = function_times(run, tuple(parts.values()))
    return {**{part: spent[name] / count for part, name in parts.items()}, "set-up": best_time(run) / count}
