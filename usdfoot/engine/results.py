"""Figures of every step, measured on the finished frames (design.md section 10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from usdfoot.analysis.figures import FRAME_TOLERANCE, FrameRanges, contact_figures
from usdfoot.engine.contact_feet import ContactFeet
from usdfoot.engine.frames import Frames
from usdfoot.engine.pose_source import Feet, Layout
from usdfoot.engine.poses import Setup, StepBlend
from usdfoot.engine.reach import PLACED
from usdfoot.engine.weights import Landings
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.agent import Agent
from usdfoot.model.contacts import Contacts, FootContacts
from usdfoot.model.motion import Motion, StepResults
from usdfoot.model.report import Problem

__all__ = [
    "FootstepFigures",
    "achieved_contacts",
    "measure_contacts",
    "measure_steps",
    "planted_frames",
    "step_ranges",
    "unmeasured_steps",
]


@dataclass(frozen=True, kw_only=True)
class FootstepFigures:
    """What the feet really do on all N footsteps of all agents, in the order of their plans; shape (N,) each."""

    rows: IntArray
    """Contact of each footstep."""
    placement_error: FloatArray
    slide: FloatArray
    """[m]"""
    yaw_error: FloatArray
    """[rad]"""
    on_ground: BoolArray
    """Whether there is walkable ground under the ball."""


def measure_contacts(
    layout: Layout, feet: ContactFeet, frames: Frames, *, measured: Feet, agents: Sequence[Agent]
) -> FootstepFigures:
    """Figures of the planted feet over the whole frames of each contact."""
    contacts = layout.contacts
    real = np.flatnonzero(contacts.steps >= 0)
    targets = np.concatenate([agent.plan.positions for agent in agents])
    orientations = np.concatenate([agent.plan.orientations for agent in agents])
    placement, slide, yaw = (np.zeros(len(real)) for _ in range(3))
    origins = layout.origins[frames.agents]
    for side in (0, 1):
        own = contacts.sides[real] == side
        rows = real[own]
        figures = contact_figures(
            measured.balls[:, side] + origins,
            measured.balls[:, side] - measured.ankles[:, side],
            planted_frames(layout, feet, frames, rows=rows),
            targets=targets[own],
            orientations=orientations[own],
        )
        placement[own], slide[own], yaw[own] = figures.placement_error, figures.slide, figures.yaw_error
    return FootstepFigures(
        rows=real, placement_error=placement, slide=slide, yaw_error=yaw, on_ground=feet.on_ground[real]
    )


def measure_steps(
    setup: Setup, blend: StepBlend, landings: Landings, *, figures: FootstepFigures, agents: Sequence[Agent]
) -> list[StepResults]:
    """Results of each agent's footsteps blended from clips, in the order of its plan."""
    values = _by_landing(setup, landings, figures.rows)
    statuses = _statuses(figures, values)
    counts, clips, clip_weights = _clips(setup, blend, values["segment"].astype(int))
    ranges, listed = step_ranges(agents), np.concatenate([[0], np.cumsum(counts)])
    return [
        StepResults(
            blend_error=values["blend_error"][a:b],
            placement_error=figures.placement_error[a:b],
            slide=figures.slide[a:b],
            yaw_error=figures.yaw_error[a:b],
            hull_distance=values["hull_distance"][a:b],
            time_warp=values["time_warp"][a:b],
            root_weight=values["root_weights"][a:b],
            beta=values["betas"][a:b],
            root_velocity_error=values["velocity_error"][a:b],
            status=tuple(statuses[a:b]),
            clip_counts=counts[a:b],
            clips=tuple(clips[c:d]),
            clip_weights=clip_weights[c:d],
        )
        for (a, b), (c, d) in zip(pairwise(ranges), pairwise(listed[ranges].tolist()), strict=True)
    ]


def step_ranges(agents: Sequence[Agent]) -> IntArray:
    """First footstep of each agent among those of all, and their number as the last entry, shape (A + 1,)."""
    return np.concatenate([[0], np.cumsum([len(agent.plan) for agent in agents])])


def planted_frames(layout: Layout, feet: ContactFeet, frames: Frames, *, rows: IntArray) -> FrameRanges:
    """Whole frames from flat to liftoff of contacts `rows`."""
    contacts = layout.contacts
    agents, stamps = contacts.agents[rows], frames.stamps
    begins = feet.flats[rows] - FRAME_TOLERANCE
    ends = np.minimum(contacts.liftoffs[rows], contacts.ends[agents]) + FRAME_TOLERANCE
    first, last = (
        locate(frames.agents, stamps, contacts.starts, agents=agents, times=times) for times in (begins, ends)
    )
    first = first + (stamps[first] < begins)
    return FrameRanges(first=first, counts=np.maximum(last + (stamps[last] <= ends) - first, 0))


def _by_landing(setup: Setup, landings: Landings, real: IntArray) -> dict[str, FloatArray]:
    """What is known of each footstep from the segment that leads to it; the first ones have none (segment -1)."""
    segments = setup.segments
    steps = np.flatnonzero(~segments.stands)
    leading = np.full(len(setup.contacts.sides), -1)
    leading[segments.supports[steps] + 1] = steps
    segment = leading[real]
    known = segment >= 0
    values: dict[str, FloatArray] = {"segment": segment}
    neutral = {"time_warp": 1.0}
    for name in ("blend_error", "hull_distance", "time_warp", "limited", "beyond_legs", "velocity_error"):
        values[name] = np.where(known, getattr(landings, name)[segment].astype(float), neutral.get(name, 0.0))
    for name in ("root_weights", "betas", "given_up"):
        values[name] = np.where(known, getattr(landings.rooted, name)[segment].astype(float), 0.0)
    return values


def _statuses(figures: FootstepFigures, values: dict[str, FloatArray]) -> list[str]:
    """Status of each step; the gravest that applies."""
    statuses = np.full(len(figures.rows), "ok", dtype=object)
    statuses[values["hull_distance"] > 1e-4] = "outsideHull"
    statuses[np.fmax(figures.placement_error, figures.slide) > PLACED] = "ikLimited"
    statuses[values["given_up"] > 0.0] = "rootWeighted"
    statuses[values["limited"] > 0.0] = "ikLimited"
    statuses[values["beyond_legs"] > 0.0] = "unreachable"
    statuses[~figures.on_ground] = "offTerrain"
    return [str(status) for status in statuses]


def _clips(setup: Setup, blend: StepBlend, rows: IntArray) -> tuple[IntArray, list[str], FloatArray]:
    """Number of clips of each step (N,), then their names and weights (sum of the numbers,), each clip once a step.

    A footstep that no segment leads to (row -1) has none.
    """
    weights = np.where(rows[:, None] >= 0, blend.weights[rows], 0.0)  # (N, E)
    clips = np.where(weights > 0.0, setup.examples.clip_indices[blend.examples[rows]], -1)
    steps, places = np.indices(clips.shape)
    earliest = np.argmax(clips[:, :, None] == clips[:, None, :], axis=2)  # where the same clip comes first
    totals = np.zeros(clips.shape)
    np.add.at(totals, (steps, earliest), weights)
    listed = (clips >= 0) & (earliest == places)
    names = [setup.examples.clip_names[clip] for clip in clips[listed].tolist()]
    return listed.sum(axis=1), names, totals[listed]


def achieved_contacts(layout: Layout, feet: ContactFeet, agent: int, *, times: FloatArray) -> Contacts:
    """When and where an agent's feet stand, as executed; the ends of its interval and of its frames cut the contacts.

    A contact whose foot is not yet flat when the frames end is none: its ball stands nowhere.

    Args:
        layout: Contacts of all agents.
        feet: How they roll.
        agent: Index of the agent.
        times: Its frames, which may be only some of its interval [s], shape (F,).
    """
    contacts = layout.contacts
    start = max(float(contacts.starts[agent]), float(times[0]))
    end = min(float(contacts.ends[agent]), float(times[-1]))
    rows = np.arange(contacts.first[agent], contacts.first[agent + 1])
    rows = rows[(contacts.liftoffs[rows] > start) & (feet.flats[rows] < end)]

    def foot(side: int) -> FootContacts:
        own = rows[contacts.sides[rows] == side]
        return FootContacts(
            strike_times=np.maximum(contacts.strikes[own], start),
            flat_times=np.clip(feet.flats[own], start, end),
            liftoff_times=np.minimum(contacts.liftoffs[own], end),
            positions=contacts.positions[own],
            yaws=contacts.yaws[own],
            ball_first=feet.flats[own] <= contacts.strikes[own],
        )

    return Contacts(left=foot(0), right=foot(1))


def unmeasured_steps(agents: Sequence[Agent], motions: Sequence[Motion]) -> list[Problem]:
    """Warnings of agents with footsteps whose foot is planted in none of the frames while these go on.

    Nobody sees them planted, so their figures are not numbers, and their status speaks of the blend alone.
    """
    plans = {agent.name: agent for agent in agents}
    problems = []
    for motion in motions:
        agent = plans[motion.name]
        plan, results = agent.plan, motion.results
        during = (plan.strike_times >= motion.times[0]) & (plan.liftoff_times <= motion.times[-1])
        unseen = np.flatnonzero(during & ~np.isfinite(results.placement_error))
        if not unseen.size:
            continue
        lasts = plan.liftoff_times[unseen[0]] - plan.strike_times[unseen[0]]
        message = (
            f"{plan.name}: {unseen.size} footstep(s) are planted in no frame and have no figures, first footstep "
            f"{unseen[0]}, which lasts {lasts:.3g} s. let them last longer, or animate more frames a second"
        )
        problems.append(Problem(severity="warning", where=agent.source, message=message))
    return problems
