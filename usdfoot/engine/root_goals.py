"""What each step is asked of its root: lambda4, and the velocity the footsteps give it ([B] 4.2, 5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.engine.given_roots import given_roots
from usdfoot.engine.options import ROOTED_FRAME
from usdfoot.engine.poses import Setup
from usdfoot.errors import PlanError
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.agent import Agent

__all__ = ["RootGoals", "root_goals"]


@dataclass(frozen=True, kw_only=True)
class RootGoals:
    """Wishes for the M segments; none for stands."""

    weights: FloatArray
    """Wanted lambda4, or the most it may be where a tolerance limits it, shape (M,)."""
    replace_distances: FloatArray
    """[B]'s epsilon [m], shape (M,)."""
    velocities: FloatArray
    """Root velocity, (x, z) in the heading at the step's end [m/s], shape (M, 2)."""
    rooted: BoolArray
    """Steps of agents with a root weight or a replacement distance, shape (M,)."""


def root_goals(setup: Setup, agents: Sequence[Agent]) -> RootGoals:
    """Goals of all segments from what agents, plans and options say; options go first, then plans."""
    segments, options = setup.segments, setup.options
    count = len(segments)
    steps = np.flatnonzero(~segments.stands)
    weights = np.zeros(count)
    weights[steps] = _wanted(setup, agents, steps)
    distances = np.array([agent.replace_distance for agent in agents])[segments.agents]
    asked = (weights > 0.0) | (distances > 0.0)
    if options.root_weight_within is not None:
        weights[steps] = 1.0 if options.root_weight is None else options.root_weight
        asked[steps] = True
    if asked.any() and options.frame == "root":
        agent = agents[segments.agents[asked][0]]
        raise PlanError(agent.source, "has a root weight or a replaceDistance, with the frame root", ROOTED_FRAME)
    rooted = np.isin(segments.agents, segments.agents[asked]) & ~segments.stands
    velocities = np.zeros((count, 2))
    velocities[steps] = _given_velocities(setup, agents, steps, _planned_velocities(setup, steps))
    return RootGoals(weights=weights, replace_distances=distances, velocities=velocities, rooted=rooted)


def _wanted(setup: Setup, agents: Sequence[Agent], steps: IntArray) -> FloatArray:
    """lambda4 of the `steps`, shape (N,); those to contacts after the last footstep go on with its weight."""
    if setup.options.root_weight is not None:
        return np.full(len(steps), setup.options.root_weight)
    contacts, targets = setup.contacts, setup.segments.supports[steps] + 1
    firsts = np.concatenate([[0], np.cumsum([len(agent.plan) for agent in agents])])
    owners = contacts.agents[targets]
    lengths = np.diff(firsts)[owners]
    footsteps = np.where(contacts.steps[targets] >= 0, contacts.steps[targets], lengths - 1)
    return np.concatenate([agent.step_root_weights for agent in agents])[firsts[owners] + footsteps]


def _planned_velocities(setup: Setup, steps: IntArray) -> FloatArray:
    """Velocity of the middle of consecutive footsteps over each step, (x, z) in the heading at its end [m/s], (N, 2).

    Before the first footstep of a plan that starts in mid gait there is no other: its first step takes the velocity
    of the second.
    """
    contacts, segments = setup.contacts, setup.segments
    supports = segments.supports[steps]
    moves = 0.5 * (contacts.positions[supports + 1] - contacts.positions[supports - 1])[:, 0::2]
    durations = segments.ends[steps] - segments.knot_times[steps, 0]
    velocities = planar.rotate(-contacts.headings[supports + 1], moves) / durations[:, None]
    unknown = np.flatnonzero(contacts.steps[supports - 1] < 0)
    unknown = unknown[unknown + 1 < len(steps)]
    same = contacts.agents[supports[unknown]] == contacts.agents[supports[np.minimum(unknown + 1, len(steps) - 1)]]
    velocities[unknown[same]] = velocities[unknown[same] + 1]
    return velocities


def _given_velocities(setup: Setup, agents: Sequence[Agent], steps: IntArray, planned: FloatArray) -> FloatArray:
    """The `planned` velocities (N, 2), where a root trajectory is given over the step the trajectory's."""
    contacts, segments, roots = setup.contacts, setup.segments, given_roots(agents)
    owners, ends, begins = segments.agents[steps], segments.ends[steps], segments.knot_times[steps, 0]
    given, after = roots.positions(owners, ends)
    _, before = roots.positions(owners, begins)
    headings = contacts.headings[segments.supports[steps] + 1][given]
    moved = (after - before)[:, [0, 2]] / (ends - begins)[given, None]
    velocities = planned.copy()
    within = ends[given] <= contacts.ends[owners[given]]
    velocities[np.flatnonzero(given)[within]] = planar.rotate(-headings, moved)[within]
    return velocities
