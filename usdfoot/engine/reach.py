"""Reach: which footsteps no step lands on, where the foot is planted instead, and what is said of it ([B] 5)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.engine.poses import Setup
from usdfoot.engine.segments import SHORTEST_STAND
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.agent import Agent
from usdfoot.model.motion import Motion
from usdfoot.model.report import Problem

__all__ = [
    "PLACED",
    "beyond_reach",
    "find_high_steps",
    "find_long_steps",
    "give_way",
    "steps_off_terrain",
    "unreached_steps",
]

PLACED = 0.003
"""A step placed worse than this, or whose ball slides farther, did not keep its promise [m]."""
TURNED_AWAY = 0.5
"""A root trajectory that faces farther off the feet than this at a missed footstep is why it is missed [rad]."""
LEVEL = 0.02
"""Footsteps that rise or fall by less are level, as messages have it [m]."""

LEAST_GAIN = 0.5
"""A foot gives way to the next footstep only where each metre of it brings that nearer by so much."""


def beyond_reach(setup: Setup, steps: IntArray, offsets: FloatArray, *, reach: FloatArray) -> FloatArray:
    """How far landings of the segments `steps` (N,) have to fall short of their footsteps, (x, z) [m], shape (N, 2).

    What is left of `offsets` (N, 2) beyond the agents' `reach` (A,), or of the step beyond the longest. Feet that come
    to stand are drawn however far, as the body comes to the pose it stands in: many have one walk and no stop.
    """
    segments, positions = setup.segments, setup.contacts.positions
    distance = np.linalg.norm(offsets, axis=1)
    reaches = np.where(_come_to_stand(setup, steps), np.inf, reach[segments.agents[steps]])
    beyond_ik = offsets * np.maximum(1.0 - reaches / np.maximum(distance, 1e-12), 0.0)[:, None]
    supports = segments.supports[steps]
    displacements = (positions[supports + 1] - positions[supports])[:, [0, 2]]
    longest = _longest(setup, steps)
    lengths = np.linalg.norm(displacements, axis=1)
    beyond_leg = displacements * np.maximum(1.0 - longest / np.maximum(lengths, 1e-12), 0.0)[:, None]
    farther = np.linalg.norm(beyond_leg, axis=1) > np.linalg.norm(beyond_ik, axis=1)
    return np.where(farther[:, None], beyond_leg, beyond_ik)


def find_high_steps(setup: Setup, steps: IntArray) -> BoolArray:
    """Which of the segments `steps` (N,) rise or fall by more than `highest_step` legs without a flight, shape (N,).

    Nothing nearer would be on the ground, so their feet are put where they are planned all the same.
    """
    heights, supports = setup.contacts.positions[:, 1], setup.segments.supports[steps]
    rises = np.abs(heights[supports + 1] - heights[supports])
    return np.asarray(_grounded(setup, steps) & (rises > setup.options.highest_step * setup.leg_length))


def find_long_steps(setup: Setup, steps: IntArray, planned: FloatArray) -> BoolArray:
    """Which of the segments `steps` (N,) no leg could take from where the support foot stands, shape (N,).

    Args:
        setup: Contacts as executed.
        steps: Segments.
        planned: Positions of the contacts as planned [m], shape (C, 3).
    """
    supports = setup.segments.supports[steps]
    displacements = (planned[supports + 1] - setup.contacts.positions[supports])[:, [0, 2]]
    return np.asarray(np.linalg.norm(displacements, axis=1) > _longest(setup, steps))


def _longest(setup: Setup, steps: IntArray) -> FloatArray:
    """Longest step of segments `steps` (N,) that legs take; there is none with a flight [m], shape (N,)."""
    return np.where(_grounded(setup, steps), setup.longest_step, np.inf)


def _grounded(setup: Setup, steps: IntArray) -> BoolArray:
    """Whether segments (N,) have no flight."""
    supports = setup.segments.supports[steps]
    return np.asarray(setup.contacts.liftoffs[supports] >= setup.contacts.strikes[supports + 1])


def _come_to_stand(setup: Setup, steps: IntArray) -> BoolArray:
    """Whether the segments `steps` (N,) end in a stand on both feet, shape (N,)."""
    segments, contacts = setup.segments, setup.contacts
    supports = segments.supports[steps]
    together = np.minimum(contacts.liftoffs[supports], contacts.liftoffs[supports + 1]) - contacts.strikes[supports + 1]
    stands = np.append(segments.stands[1:] & segments.joined[1:-1], False)
    return np.asarray(stands[steps] & (together > SHORTEST_STAND))


def give_way(setup: Setup, asking: IntArray, asked: IntArray, *, moved: FloatArray, excess: FloatArray) -> FloatArray:
    """How much farther feet come back that were moved, so that the next footstep can be kept, (x, z) [m], (N, 2).

    A foot comes back the way it was moved, where it is sure to be in reach, if that is towards the next footstep.

    Args:
        setup: Contacts as they are, and segments.
        asking: Segments whose footsteps are out of reach, shape (N,).
        asked: Segments that lead to the feet these step from, -1 = nothing does, shape (N,).
        moved: How far back those feet were moved, (x, z) [m], shape (N, 2).
        excess: How far the landings of `asking` fall short of their footsteps, shape (N, 2) [m].
    """
    planned = setup.contacts.steps[setup.segments.supports[asking] + 1] >= 0
    back = moved / np.maximum(np.linalg.norm(moved, axis=1, keepdims=True), 1e-12)
    missing = np.linalg.norm(excess, axis=1, keepdims=True)
    gain = -np.sum(back * excess, axis=1, keepdims=True) / missing
    gives = (planned & (asked >= 0))[:, None] & (gain > LEAST_GAIN)
    return np.where(gives, back * missing / np.maximum(gain, LEAST_GAIN), 0.0)


def unreached_steps(agents: Sequence[Agent], motions: Sequence[Motion]) -> list[Problem]:
    """Warnings of agents whose feet miss footsteps in their frames: no leg reaches them, or IK may not pull so far."""
    by_name = {agent.name: agent for agent in agents}
    problems = []
    for motion in motions:
        agent, statuses = by_name[motion.name], np.array(motion.results.status)
        shown, limited = np.isfinite(motion.results.placement_error), statuses == "ikLimited"
        far = np.flatnonzero(shown & (statuses == "unreachable"))
        is_pulled = motion.results.blend_error > agent.ik_reach
        pulled = np.flatnonzero(shown & limited & is_pulled)
        short = np.flatnonzero(limited & ~is_pulled & (motion.results.placement_error > PLACED))
        if far.size:
            remedy = "put them nearer, or a footstep between (`usdfoot plan lint` names each)"
            problems.append(_missed(agent, motion, far, "out of reach", remedy))
        if pulled.size:
            remedy = "raise usdfoot:agent:ikReach, or add clips that step there"
            problems.append(_missed(agent, motion, pulled, "farther from what the clips step than IK may pull", remedy))
        if short.size:
            remedy = "put them nearer to where the other foot stands then"
            problems.append(_missed(agent, motion, short, "missed, as the legs are too short for both", remedy))
    return problems


def steps_off_terrain(agents: Sequence[Agent], motions: Sequence[Motion]) -> list[Problem]:
    """Warnings of agents with footsteps under or over which there is no ground that carries them."""
    by_name = {agent.name: agent for agent in agents}
    problems = []
    for motion in motions:
        agent = by_name[motion.name]
        shown = np.isfinite(motion.results.placement_error)
        off = np.flatnonzero(shown & (np.array(motion.results.status) == "offTerrain"))
        if off.size:
            x, y, z = agent.plan.positions[off[0]]
            message = (
                f"{agent.plan.name}: {off.size} footstep(s) are off the terrain, first footstep {off[0]} at ({x:.2f}, "
                f"{y:.2f}, {z:.2f}) m, +Y up. put them on walkable terrain, by --conform where some is above or below "
                "them, or correct the terrain's transform"
            )
            problems.append(Problem(severity="warning", where=agent.source, message=message))
    return problems


def _missed(agent: Agent, motion: Motion, out: IntArray, fault: str, remedy: str) -> Problem:
    """A warning that footsteps `out` of an agent are missed: which, by how much, and what would be right."""
    plan = agent.plan
    rises = np.diff(plan.positions[:, 1], prepend=plan.positions[0, 1])[out]
    missed = motion.results.placement_error[out]
    worst = int(np.argmax(np.fmax(missed, np.abs(rises))))
    turned = _turned_away(agent, int(out[worst]))
    if abs(turned) > TURNED_AWAY and agent.root_trajectory is not None:
        remedy = (
            f"the root trajectory {agent.root_trajectory.name} faces {np.degrees(abs(turned)):.0f} degrees off the "
            "feet there: turn it as they go, or leave out its rotations"
        )
    message = (
        f"{plan.name}: {out.size} footstep(s) are {fault}, first footstep {out[0]}; the foot comes down "
        f"{missed[worst]:.2f} m from footstep {out[worst]}{_risen(float(rises[worst]))}. {remedy}"
    )
    return Problem(severity="warning", where=agent.source, message=message)


def _risen(rise: float) -> str:
    """How much higher or lower a footstep is than the one before, where that is worth a word [m]."""
    if abs(rise) < LEVEL:
        return ""
    return f", which is {abs(rise):.2f} m {'above' if rise > 0.0 else 'below'} the one before"


def _turned_away(agent: Agent, footstep: int) -> float:
    """From the mean heading of the feet to that of the root trajectory at a footstep's strike [rad], 0 without one."""
    trajectory, plan = agent.root_trajectory, agent.plan
    if trajectory is None or trajectory.yaws is None:
        return 0.0
    facing = np.interp(plan.strike_times[footstep], trajectory.times, trajectory.yaws)
    before, own = plan.yaws[max(footstep - 1, 0)], plan.yaws[footstep]
    feet = planar.midway_yaw(before, own)
    return float(planar.wrap_angle(facing - feet))
