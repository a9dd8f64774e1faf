"""The steps of a written crowd, weighed again as they were when it was made: in which space, of which examples."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, fields
from functools import partial
from typing import Any

import numpy as np

from usdfoot.engine.animate import PreparedLibraries, PreparedLibrary, PreparedSteps, animate_apart, prepare_steps
from usdfoot.engine.queries import asked_landings, step_queries
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.motion import StepResults
from usdfoot.model.overlay import Shape
from usdfoot.model.report import Problem
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.overlay_shapes import web
from usdfoot.pipeline.provenance import options_of
from usdfoot.planning.followers import plan_followers
from usdfoot.readers.scene import SceneReader
from usdfoot.readers.written import WrittenCrowd
from usdfoot.spaces.landings import left_landings
from usdfoot.spaces.side_space import SideSpace

__all__ = ["SpaceRows", "WeighedBatch", "is_as_recorded", "join_rows", "space_rows", "undrawn", "weigh_again"]

WEB_COLOR = (0.02, 0.03, 0.05)
WEB_WIDTH, DOT = 0.006, 0.018
LIFT = 0.012
"""Height over the higher of the two footprints [m]."""
AGREEMENT = 1e-3
"""Weights found again that differ by more from those recorded are of another scene, or other clips."""


@dataclass(frozen=True, kw_only=True)
class SpaceRows:
    """The M steps of all agents, in order of agent and time."""

    agents: IntArray
    begins: FloatArray
    ends: FloatArray
    """[s], shape (M,)."""
    places: FloatArray
    """Origin of the space: the support ball, raised [m], shape (M, 3)."""
    headings: FloatArray
    """At the end of the step [rad], shape (M,)."""
    shapes: IntArray
    """Which space, shape (M,)."""
    landings: FloatArray
    """Of the examples, heaviest first, (x, z) in the space [m], shape (M, K, 2)."""
    weights: FloatArray
    """Shape (M, K)."""


@dataclass(frozen=True, kw_only=True)
class WeighedBatch:
    """Steps weighed again, of agents that share a library."""

    library: PreparedLibrary
    agents: Sequence[Agent]
    steps: PreparedSteps


def weigh_again(crowd: WrittenCrowd, names: Collection[str]) -> tuple[list[WeighedBatch], list[Problem]]:
    """The steps of agents with these names, as the crowd's scene and options give them."""
    options = options_of(crowd.provenance)
    frames = (int(crowd.stage.GetStartTimeCode()), int(crowd.stage.GetEndTimeCode()))
    reader = SceneReader(crowd.scene, frames=frames, motion=options.motion, tuning=options.tuning, crowd=crowd.folder)
    libraries = PreparedLibraries(options)
    read, _, lost = plan_followers(reader.read(names=names).crowd, options=options, libraries=libraries)
    batches, problems = [], [undrawn(problem.where, problem.message) for problem in lost]
    for index in range(len(read.libraries)):
        own = [agent for agent in read.agents if agent.library == index and agent.motion != "physics"]
        if own:
            found, faults = animate_apart(partial(_batches, read, libraries, options, index), own)
            batches += found
            problems += [undrawn(fault.where, fault.message) for fault in faults]
    return batches, problems


def _batches(
    crowd: Crowd, libraries: PreparedLibraries, options: MotionOptions, index: int, agents: Sequence[Agent]
) -> list[WeighedBatch]:
    prepared = libraries.prepared(crowd, index)
    steps = prepare_steps(prepared, agents, crowd, options=options)
    return [WeighedBatch(library=prepared, agents=agents, steps=steps)]


def is_as_recorded(batch: WeighedBatch, row: int, recorded: StepResults) -> bool:
    """Whether all steps of the agent `row` of a batch blend the clips recorded, with their weights."""
    setup, blend = batch.steps.setup, batch.steps.blend
    segments, examples = setup.segments, setup.examples
    own = np.flatnonzero((segments.agents == row) & ~segments.stands)
    footsteps = setup.contacts.steps[segments.supports[own] + 1]
    wanted = _recorded_weights(recorded)
    for segment, footstep in zip(own.tolist(), footsteps.tolist(), strict=True):
        if not 0 <= footstep < len(wanted):
            continue
        clips = [examples.clip_names[clip] for clip in examples.clip_indices[blend.examples[segment]].tolist()]
        found = _sums(clips, blend.weights[segment].tolist())
        names = {*found, *wanted[footstep]}
        if any(abs(found.get(name, 0.0) - wanted[footstep].get(name, 0.0)) > AGREEMENT for name in names):
            return False
    return True


def _recorded_weights(results: StepResults) -> list[dict[str, float]]:
    """Weight of each clip blended in each step, by name."""
    ends = np.cumsum(results.clip_counts).tolist()
    begins = [0, *ends[:-1]]
    weights = results.clip_weights.tolist()
    return [_sums(results.clips[a:b], weights[a:b]) for a, b in zip(begins, ends, strict=True)]


def _sums(names: Sequence[str], weights: Sequence[float]) -> dict[str, float]:
    """Sum of the weights of each name."""
    totals: dict[str, float] = {}
    for name, weight in zip(names, weights, strict=True):
        totals[name] = totals.get(name, 0.0) + weight
    return totals


def space_rows(
    batch: WeighedBatch, shapes: dict[tuple[int, int], Shape], *, owners: IntArray, drawn: BoolArray
) -> SpaceRows:
    """Rows of a batch's steps; what they are shown in is added to `shapes`."""
    setup, blend, spaces = batch.steps.setup, batch.steps.blend, batch.library.spaces
    segments, contacts = setup.segments, setup.contacts
    steps = np.flatnonzero(~segments.stands & drawn[segments.agents])
    steps = steps[np.lexsort((segments.begins[steps], owners[segments.agents[steps]]))]
    supports = segments.supports[steps]
    queries = step_queries(setup, steps)
    sides = queries.swing_sides
    kinds = np.zeros(len(steps), dtype=int)
    asked = asked_landings(queries, frame=setup.options.frame)
    groups = spaces.group(asked, swing_sides=sides, flights=queries.flights, styles=queries.styles)
    for space, members in groups:
        side = int(sides[members[0]])
        key = (id(space.footsteps), side)
        if key not in shapes:
            shapes[key] = _web(f"Space{len(shapes)}", space, side)
        kinds[members] = list(shapes).index(key)
    order = np.argsort(-blend.weights[steps], axis=1, kind="stable")
    examples = np.take_along_axis(blend.examples[steps], order, axis=1)
    places = contacts.positions[supports].copy()
    if setup.options.frame == "root":
        places = 0.5 * (places + contacts.positions[supports - 1])
    places[:, 1] = np.maximum(places[:, 1], contacts.positions[supports + 1, 1]) + LIFT
    width = examples.shape[1]
    landings = left_landings(spaces.landings[examples].reshape(-1, 2), np.repeat(sides, width))
    return SpaceRows(
        agents=owners[segments.agents[steps]],
        begins=segments.begins[steps],
        ends=segments.ends[steps],
        places=places,
        headings=contacts.headings[supports + 1],
        shapes=kinds,
        landings=landings.reshape(len(steps), width, 2),
        weights=np.take_along_axis(blend.weights[steps], order, axis=1),
    )


def _web(name: str, space: SideSpace, side: int) -> Shape:
    """The triangulation of landings of one foot."""
    footsteps = space.footsteps
    corners = footsteps.triangles
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]], footsteps.edges])
    vertices = left_landings(footsteps.vertices, np.full(len(footsteps.vertices), side))
    unique = np.unique(np.sort(edges, axis=1), axis=0)
    return web(name, vertices, unique, color=WEB_COLOR, width=WEB_WIDTH, dot=DOT)


def join_rows(parts: Sequence[SpaceRows]) -> SpaceRows:
    """All rows in order of agent and time; fewer examples are padded with weight 0."""
    most = max((part.weights.shape[1] for part in parts), default=0)
    columns: dict[str, list[Any]] = {field.name: [] for field in fields(SpaceRows)}
    for part in parts:
        missing = most - part.weights.shape[1]
        for name, column_parts in columns.items():
            values = getattr(part, name)
            if name in ("landings", "weights"):
                values = np.pad(values, [(0, 0), (0, missing)] + [(0, 0)] * (values.ndim - 2))
            column_parts.append(values)
    joined: dict[str, Any] = {
        name: np.concatenate(values) if values else np.zeros(0) for name, values in columns.items()
    }
    order = np.lexsort((joined["begins"], joined["agents"]))
    return SpaceRows(**{name: values[order] for name, values in joined.items()})


def undrawn(where: str, reason: str) -> Problem:
    """A warning that the spaces of an agent, or of all, are not drawn."""
    return Problem(severity="warning", where=where, message=f"{where}: footstep spaces are not drawn: {reason}")
