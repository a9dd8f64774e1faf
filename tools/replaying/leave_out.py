"""Libraries with clips left out, and how far what they make of a take's footsteps is from the take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

import numpy as np

from replaying.takes import Take, motion_positions
from usdfoot.analysis.gaits import has_flight
from usdfoot.analysis.smoothness import body_joints
from usdfoot.engine.animate import PreparedLibrary, animate_agents
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.poses import device_library
from usdfoot.maths import planar
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.examples import Examples
from usdfoot.model.motion import Motion
from usdfoot.model.terrain import Terrain
from usdfoot.physics.animate import animate_hybrids
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.spaces.landings import end_landings
from usdfoot.spaces.library import build_spaces

__all__ = ["ReplayErrors", "nearest_clips", "replay_takes", "with_clips", "with_examples"]

TIME_SCALE = 0.5
"""A difference in duration of a second counts as much as this distance between landings [m]."""


@dataclass(frozen=True, kw_only=True)
class ReplayErrors:
    """Mean distance between the joints of a motion and of the take, first strike to last strike [m]."""

    world: float
    """All joints from the pelvis down."""
    world_legs: float
    """Both legs, hip to ball."""
    pelvis: float
    """All joints, each from its own pelvis; the heading stays."""
    pelvis_legs: float
    pelvis_alone: float
    """The pelvis in the world, root mean square."""
    outside: int = 0
    """Footsteps outside the hull of the space, or out of reach."""


def with_clips(library: PreparedLibrary, clips: IntArray, *, style: str) -> PreparedLibrary:
    """The prepared library with the examples of some of its clips only, their mirror images and the stand.

    Args:
        library: All clips, analysed once.
        clips: Indices of the clips to keep.
        style: Style of the steps; the library's own where the clips kept have none of it.
    """
    steps = np.isin(library.examples.clip_indices[:-1], clips)
    kept = _selected(library.examples, np.append(np.flatnonzero(steps), len(library.examples) - 1))
    styles = kept.styles[:-1]
    known = style if style in styles else max(sorted(set(styles)), key=styles.count)
    return replace(with_examples(library, kept), style=known)


def with_examples(
    library: PreparedLibrary, examples: Examples, *, synthetic: BoolArray | None = None
) -> PreparedLibrary:
    """The prepared library with other examples, a stand as the last; synthetic are those made from the others, (E,)."""
    return replace(
        library,
        examples=examples,
        spaces=build_spaces(
            _selected(examples, np.arange(len(examples) - 1)),
            leg_length=library.source.biped.maximal_leg_length,
            synthetic=None if synthetic is None else synthetic[:-1],
        ),
        device=device_library(examples, library.rig, pelvis=library.source.biped.pelvis),
    )


def _selected(examples: Examples, rows: IntArray) -> Examples:
    """The examples `rows`, still with all clip names."""
    values: dict[str, Any] = {}
    for field in fields(examples):
        value = getattr(examples, field.name)
        if isinstance(value, np.ndarray):
            values[field.name] = value[rows]
    return replace(examples, styles=tuple(examples.styles[row] for row in rows), **values)


def replay_takes(
    library: PreparedLibrary, takes: Sequence[Take], options: EngineOptions, *, hybrid: bool = False
) -> list[ReplayErrors]:
    """Errors of the takes (all of one rate) as synthesised from a library on their footsteps.

    Args:
        library: What is left of the clips.
        takes: The truth.
        options: The engine's.
        hybrid: Put the blended clips' pelvis on the optimised centre of mass.
    """
    frames = max(len(take.positions) for take in takes)
    nothing = np.zeros((0, 3))
    none = np.zeros(0, dtype=int)
    terrain = Terrain(
        meshes=(), points=nothing, triangles=nothing.astype(int), mesh_indices=none, walkable=none.astype(bool)
    )
    agents = tuple(
        Agent(name=f"take{i}", source=take.name, plan=take.plan, library=0, character=0) for i, take in enumerate(takes)
    )
    crowd = Crowd(
        agents=agents,
        libraries=(library.source,),
        terrain=terrain,
        frame_times=np.arange(frames) / takes[0].rate,
        frame_rate=takes[0].rate,
    )
    if hybrid:
        motions = animate_hybrids(library, agents, crowd, options=MotionOptions(**asdict(options)))
    else:
        motions = animate_agents(library, agents, crowd, options=options)
    return [_errors(library.source, take, motion) for take, motion in zip(takes, motions, strict=True)]


def _errors(library: ClipLibrary, take: Take, motion: Motion) -> ReplayErrors:
    strikes = take.plan.strike_times
    inside = (motion.times >= strikes[0] - 1e-9) & (motion.times <= strikes[-1] + 1e-9)
    made = motion_positions(library, motion)[inside]
    true = take.positions[np.round(motion.times[inside] * take.rate).astype(int)]
    body = list(body_joints(library.skeleton, library.biped))
    legs = [body.index(joint) for joint in _leg_joints(library)]
    pelvis = body.index(library.biped.pelvis)
    apart = made - true
    relative = apart - apart[:, [pelvis]]
    others = np.delete(relative, pelvis, axis=1)
    return ReplayErrors(
        world=_mean(apart),
        world_legs=_mean(apart[:, legs]),
        pelvis=_mean(others),
        pelvis_legs=_mean(relative[:, legs]),
        pelvis_alone=float(np.sqrt(np.mean(np.sum(apart[:, pelvis] ** 2, axis=-1)))),
        outside=sum(status in ("outsideHull", "unreachable", "ikLimited") for status in motion.results.status),
    )


def _leg_joints(library: ClipLibrary) -> list[int]:
    biped = library.biped
    return [*biped.hips, *biped.knees, *biped.ankles, *biped.balls]


def _mean(differences: FloatArray) -> float:
    return float(np.linalg.norm(differences, axis=-1).mean())


def step_distances(examples: Examples, takes: Sequence[Take], clips: int) -> FloatArray:
    """How far each take's steps are from the nearest steps of each clip [m], shape (takes, clips); inf without any.

    The distance is that of the landings, with the difference in duration and in flight added.
    """
    landings, clip_of = end_landings(examples)[:-1], examples.clip_indices[:-1]
    flights = has_flight(examples.durations, examples.support_liftoffs, examples.landings)[:-1]
    own = _coordinates(landings, examples.durations[:-1], flights)
    distances = np.full((len(takes), clips), np.inf)
    for row, take in enumerate(takes):
        wanted, sides = _take_coordinates(take)
        apart = np.linalg.norm(wanted[:, None] - own, axis=-1)
        apart[sides[:, None] != examples.swing_sides[:-1]] = np.inf
        for clip in np.unique(clip_of):
            distances[row, clip] = apart[:, clip_of == clip].min(axis=1).mean()
    return distances


def _coordinates(landings: FloatArray, durations: FloatArray, flights: BoolArray) -> FloatArray:
    return np.column_stack([landings, TIME_SCALE * durations, np.where(flights, 0.5, 0.0)])


def _take_coordinates(take: Take) -> tuple[FloatArray, IntArray]:
    """The take's steps as points among the examples (N - 1, 4), and their swing sides (N - 1,)."""
    plan = take.plan
    middle = planar.circular_mean(np.stack([plan.yaws[1:], plan.yaws[:-1]]), axis=0)
    displacements = np.diff(plan.positions[:, [0, 2]], axis=0)
    durations = np.diff(plan.strike_times)
    flights = has_flight(durations, plan.liftoff_times[:-1] - plan.strike_times[:-1], displacements)
    return _coordinates(planar.rotate(-middle, displacements), durations, flights), plan.sides[1:]


def nearest_clips(examples: Examples, takes: Sequence[Take], clips: int) -> IntArray:
    """The other clip whose steps are nearest to each take's, shape (takes,)."""
    distances = step_distances(examples, takes, clips)
    distances[np.arange(len(takes)), [take.index for take in takes]] = np.inf
    return np.argmin(distances, axis=1)
