"""Measures: what one agent of a written crowd does, step by step, recomputed from its joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from usdfoot.analysis.figures import (
    FrameRanges,
    contact_figures,
    frames_between,
    largest_distances,
    smallest_in_ranges,
    timing_faults,
)
from usdfoot.analysis.smoothness import angular_jerks, angular_jumps, angular_speeds, body_joints
from usdfoot.bridge.tokens import Status
from usdfoot.bridge.units import StageUnits
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.ground import Ground
from usdfoot.pipeline.written_feet import floating_feet, heel_points, planted_times, sole_heights
from usdfoot.readers.joint_tracks import JointTracks, read_joint_positions, read_joint_tracks
from usdfoot.readers.written import WrittenAgent

__all__ = ["AgentMeasures", "measure_agent", "measure_placement"]

SUBFRAMES = (0.25, 0.5, 0.75)
"""Where between two frames the slide is measured too."""
SWING_MIDDLE = (0.2, 0.8)
"""Part of the swing's time over which the clearance counts."""


@dataclass(frozen=True, kw_only=True)
class AgentMeasures:
    """Figures of one agent with N footsteps; NaN where there is nothing to measure."""

    name: str
    promised: BoolArray
    """Whether the footstep's status promises its placement, shape (N,)."""
    status: tuple[str, ...]
    placement_error: FloatArray
    """[m], shape (N,)."""
    slide: FloatArray
    """Of the ball over the planted whole frames [m], shape (N,)."""
    subframe_slide: FloatArray
    """Of the ball between the first and last planted frame, subframes included [m], shape (N,)."""
    heel_slide: FloatArray
    """Of the heel from strike to flat [m], shape (N,)."""
    yaw_error: FloatArray
    """[rad], shape (N,)."""
    timing_faults: BoolArray
    """Planted late or in the air, planted early, lifted late, shape (N, 3)."""
    clearance: FloatArray
    """Lowest sole over the terrain in the middle of the swing to the footstep [m], shape (N,)."""
    blend_error: FloatArray
    """As recorded when written [m], shape (N,)."""
    inside_hull: BoolArray
    """Whether the footstep was inside the hull when written, shape (N,)."""
    sole_heights: FloatArray
    """Of ball and heel of each sole over the terrain at whole frames [m], NaN = not known, shape (F, 2 feet, 2)."""
    lowest_sole: float
    """Lowest height of ball or heel of a sole over the terrain at any frame [m]."""
    knee_speed: float
    """Largest angular speed of a knee from one sample to the next [rad/s]."""
    seam_jump: float
    """Largest jump of the joints' angular velocities at a strike, root mean square over the joints [rad/s].

    Only where three frames in a row have samples: over longer times velocities change more, without any seam.
    """
    joint_jerk: float
    """99th percentile of the joints' angular jerk over any four samples that are evenly apart [rad/s3]."""


def measure_agent(agent: WrittenAgent, units: StageUnits, ground: Ground | None) -> AgentMeasures:
    """Recompute all figures of one agent.

    Args:
        agent: As read from the written crowd.
        units: Of its stage.
        ground: What the crowd walks on; None leaves penetration and clearance unmeasured.
    """
    codes = agent.frame_codes
    whole = read_joint_tracks(agent, units, codes)
    fine = _with_subframes(agent, whole, codes)
    ground = None if ground is None else ground.falling_back(float(agent.plan.positions[:, 1].min()))
    heels = heel_points(agent, whole, ground)
    columns = _steps(agent, whole, fine, heels, ground)
    heights = np.full((len(whole.times), 2, 2), np.nan)
    if ground is not None:
        heights = sole_heights(agent, whole, heels, ground=ground)
    rate = units.time_codes_per_second / float(np.min(np.diff(codes), initial=np.inf)) if len(codes) > 1 else 1.0
    smoothness = _smoothness(agent, whole, rate)
    recorded = len(agent.blend_error) == len(agent.plan)
    return AgentMeasures(
        name=agent.name,
        status=agent.status or (Status.OK,) * len(agent.plan),
        promised=np.array([status in Status.PLACED for status in agent.status or (Status.OK,) * len(agent.plan)]),
        blend_error=agent.blend_error if recorded else np.full(len(agent.plan), np.nan),
        inside_hull=agent.hull_distance <= 0.0 if recorded else np.zeros(len(agent.plan), dtype=bool),
        clearance=_clearances(agent, whole, heights),
        sole_heights=heights,
        lowest_sole=float(np.nanmin(heights)) if np.isfinite(heights).any() else np.nan,
        **smoothness,
        **columns,
    )


def measure_placement(agent: WrittenAgent, units: StageUnits, codes: FloatArray) -> FloatArray:
    """Horizontal distance of the ball to each footstep, mean over its planted samples [m], NaN without any, shape (N,).

    Args:
        agent: As read from the written crowd.
        units: Of its stage.
        codes: Time codes of the samples to look at, increasing, shape (F,).
    """
    plan, flats = agent.plan, planted_times(agent)
    errors = np.full(len(plan), np.nan)
    if not len(codes):
        return errors
    tracks = read_joint_tracks(agent, units, codes)
    for side in (0, 1):
        own = np.flatnonzero(plan.sides == side)
        balls = tracks.positions[:, agent.biped.balls[side]]
        planted = frames_between(tracks.times, flats[own], plan.liftoff_times[own])
        figures = contact_figures(
            balls, balls, planted, targets=plan.positions[own], orientations=plan.orientations[own]
        )
        errors[own] = figures.placement_error
    return errors


def _smoothness(agent: WrittenAgent, tracks: JointTracks, rate: float) -> dict[str, Any]:
    """Figures of `AgentMeasures` that are measured on the agent's own samples, as between them lie straight lines."""
    turning = tracks.rotations()
    turning[:, [agent.biped.pelvis]] = tracks.turns([agent.biped.pelvis])
    own = np.flatnonzero(agent.sampled)
    gaps = np.diff(own)[:, None]  # (S - 1, 1), in frames
    speeds = angular_speeds(turning[own][:, list(agent.biped.knees)], rate) / gaps
    body = turning[:, body_joints(agent.skeleton, agent.biped)]
    even = np.flatnonzero((gaps[:-2] == gaps[1:-1]) & (gaps[1:-1] == gaps[2:]))
    jerks = (angular_jerks(body[own], rate) / gaps[: max(len(gaps) - 2, 0)] ** 3)[even]
    return {
        "knee_speed": float(speeds.max(initial=0.0)),
        "joint_jerk": float(np.quantile(jerks, 0.99)) if jerks.size else np.nan,
        "seam_jump": _seam_jump(agent, tracks, angular_jumps(body, rate)),
    }


def _seam_jump(agent: WrittenAgent, tracks: JointTracks, jumps: FloatArray) -> float:
    """Largest of the jumps (F - 2,) at the frames on either side of a strike within the motion."""
    after = np.searchsorted(tracks.times, agent.plan.strike_times)
    frames = np.concatenate([after - 1, after]) - 1
    frames = frames[(frames >= 0) & (frames < len(jumps))]
    frames = frames[agent.sampled[frames] & agent.sampled[frames + 1] & agent.sampled[frames + 2]]
    return float(jumps[frames].max()) if frames.size else np.nan


def _with_subframes(agent: WrittenAgent, whole: JointTracks, codes: FloatArray) -> FloatArray:
    """Balls of both feet at the whole frames and the subframes between them [m], in order, (F', 2, 3)."""
    balls = list(agent.biped.balls)
    between = (codes[:-1, None] + np.diff(codes)[:, None] * np.array(SUBFRAMES)).ravel()
    inner = read_joint_positions(agent, whole.units, between, joints=balls).reshape(-1, len(SUBFRAMES), 2, 3)
    first = whole.positions[:, None, balls]
    return np.concatenate([np.concatenate([first[:-1], inner], axis=1).reshape(-1, 2, 3), first[-1]])


def _steps(
    agent: WrittenAgent, whole: JointTracks, fine: FloatArray, heels: FloatArray, ground: Ground | None
) -> dict[str, Any]:
    """Columns of `AgentMeasures` that belong to contacts."""
    plan, flats = agent.plan, planted_times(agent)
    names = ("placement_error", "slide", "subframe_slide", "heel_slide", "yaw_error")
    columns: dict[str, Any] = {name: np.full(len(plan), np.nan) for name in names}
    columns["timing_faults"] = np.zeros((len(plan), 3), dtype=bool)
    end = int(np.searchsorted(whole.times, plan.liftoff_times.max())) + 1  # the last pose is held from there
    for side in (0, 1):
        own = np.flatnonzero(plan.sides == side)
        balls = whole.positions[:, agent.biped.balls[side]]
        forwards = balls - whole.positions[:, agent.biped.ankles[side]]
        strikes, flat, liftoffs = plan.strike_times[own], flats[own], plan.liftoff_times[own]
        planted = frames_between(whole.times, flat, liftoffs)
        figures = contact_figures(
            balls, forwards, planted, targets=plan.positions[own], orientations=plan.orientations[own]
        )
        columns["placement_error"][own] = figures.placement_error
        columns["slide"][own] = figures.slide
        columns["yaw_error"][own] = figures.yaw_error
        every = len(SUBFRAMES) + 1
        inner = FrameRanges(first=planted.first * every, counts=np.maximum((planted.counts - 1) * every + 1, 0))
        columns["subframe_slide"][own] = largest_distances(fine[:, side], inner)
        columns["heel_slide"][own] = largest_distances(heels[:, side], frames_between(whole.times, strikes, flat))
        columns["timing_faults"][own] = timing_faults(
            whole.times[:end], balls[:end], strike_times=strikes, flat_times=flat, liftoff_times=liftoffs
        )
        columns["timing_faults"][own, 0] |= floating_feet(agent, balls, planted, steps=own, ground=ground)
    return columns


def _clearances(agent: WrittenAgent, tracks: JointTracks, heights: FloatArray) -> FloatArray:
    """Lowest sole in the middle of the swing that leads to each footstep [m], NaN for each foot's first, shape (N,)."""
    plan = agent.plan
    clearance = np.full(len(plan), np.nan)
    for side in (0, 1):
        own = np.flatnonzero(plan.sides == side)
        liftoffs, strikes = plan.liftoff_times[own[:-1]], plan.strike_times[own[1:]]
        begins, ends = (liftoffs + share * (strikes - liftoffs) for share in SWING_MIDDLE)
        lowest = np.min(np.where(np.isnan(heights[:, side]), np.inf, heights[:, side]), axis=1)
        smallest = smallest_in_ranges(lowest, frames_between(tracks.times, begins, ends))
        clearance[own[1:]] = np.where(np.isfinite(smallest), smallest, np.nan)
    return clearance
