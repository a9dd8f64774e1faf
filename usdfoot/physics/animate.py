"""The recipe of [P]: footstep plans and a character in, finished motions out; agents of clips go to the engine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from usdfoot.engine.animate import (
    PreparedLibraries,
    PreparedLibrary,
    animate_apart,
    animate_crowd,
    fault_of,
    prepare_steps,
)
from usdfoot.engine.planting import Planting, cut_motions, plant_samples, prepare_planting
from usdfoot.engine.pose_source import Layout
from usdfoot.engine.poses import ClipPoses
from usdfoot.engine.reach import PLACED, steps_off_terrain, unreached_steps
from usdfoot.engine.results import (
    FootstepFigures,
    measure_contacts,
    measure_steps,
    step_ranges,
    unmeasured_steps,
)
from usdfoot.engine.rig import Rig, build_rest_rig
from usdfoot.engine.root import lay_root
from usdfoot.engine.segments import cut_segments
from usdfoot.errors import UsdfootError
from usdfoot.maths import quaternion
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.contact_table import lay_contacts, lay_on_ground
from usdfoot.model.device import start_warp
from usdfoot.model.ground import Ground
from usdfoot.model.motion import ForceResults, Motion, StepResults
from usdfoot.model.report import Problem
from usdfoot.model.tuning import BodyTuning
from usdfoot.physics.biped import PhysicsBiped, measure_biped, standing_skeleton, tune_biped
from usdfoot.physics.body import BodyPoses, device_gait
from usdfoot.physics.carriage import Carriage, lay_carriage, measure_carriage
from usdfoot.physics.heading import OrientationScript
from usdfoot.physics.hybrid import carry_pelvis
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.physics.optimise import ComMotion, optimise_contacts
from usdfoot.physics.upper_body import UpperBody, build_upper_body

__all__ = [
    "PreparedBodies",
    "PreparedBody",
    "animate_all",
    "animate_bodies",
    "animate_hybrids",
    "plan_bodies",
    "prepare_body",
]

STRETCH_TOLERANCE = 0.02
"""A footstep whose virtual leg is longer than it can be by more than this part is out of reach."""


@dataclass(frozen=True, kw_only=True)
class PreparedBody:
    """A character measured once for all agents that are it."""

    source: ClipLibrary
    """Skeleton and biped; of clips only the carriage is taken."""
    rig: Rig
    physics: PhysicsBiped
    upper: UpperBody
    carriage: Carriage | None
    """None = as average people."""


def prepare_body(library: ClipLibrary, options: MotionOptions, tuning: BodyTuning) -> PreparedBody:
    """Measures a character on the pose it stands in, and on how it walks in its clips.

    Raises:
        BipedError: If its legs are none that can carry it.
    """
    start_warp()
    library = replace(library, skeleton=standing_skeleton(library))
    measured = measure_biped(library.skeleton, library.biped)
    physics = tune_biped(measured, tuning)
    return PreparedBody(
        source=library,
        rig=build_rest_rig(library.skeleton, library.biped),
        physics=physics,
        upper=build_upper_body(library.skeleton, library.biped, physics, style=options.body),
        carriage=measure_carriage(library, measured) if options.body.carriage else None,
    )


class PreparedBodies:
    """The characters of a crowd that physics moves, each prepared when it is first asked for.

    Args:
        options: How they move.
    """

    def __init__(self, options: MotionOptions) -> None:
        self._options = options
        self._prepared: dict[tuple[int, BodyTuning], PreparedBody] = {}

    def prepared(self, crowd: Crowd, index: int, tuning: BodyTuning) -> PreparedBody:
        """The character of a library of the crowd, which must mean the same one in every crowd asked about.

        Raises:
            UsdfootError: If it cannot be used.
        """
        key = index, tuning
        if key not in self._prepared:
            self._prepared[key] = prepare_body(crowd.libraries[index], self._options.tuned(tuning), tuning)
        return self._prepared[key]


def animate_all(
    crowd: Crowd,
    *,
    options: MotionOptions | None = None,
    libraries: PreparedLibraries | None = None,
    bodies: PreparedBodies | None = None,
) -> tuple[list[Motion], list[Problem]]:
    """Motions of all agents that could be animated, each from its own source, in the crowd's order, and problems.

    Args:
        crowd: Agents and what they need.
        options: Of all sources.
        libraries: Those of an earlier call on other agents of the same scene.
        bodies: The same, of characters that physics moves.
    """
    options = options or MotionOptions()
    libraries = libraries or PreparedLibraries(options)
    bodies = bodies or PreparedBodies(options)
    agents = list(crowd.agents)
    blended = tuple(agent for agent in agents if agent.motion == "clips")
    motions, problems = animate_crowd(replace(crowd, agents=blended), options=options, libraries=libraries)
    alike: dict[tuple[int, bool, BodyTuning], list[Agent]] = {}
    for agent in agents:
        if agent.motion != "clips":
            alike.setdefault((agent.library, agent.motion == "hybrid", agent.tuning), []).append(agent)
    for own in alike.values():
        found, faults = _animate_alike(libraries, bodies, own, crowd, options.tuned(own[0].tuning))
        motions = [*motions, *found]
        problems = [*problems, *faults, *unreached_steps(own, found), *steps_off_terrain(own, found)]
    by_name = {motion.name: motion for motion in motions}
    return [by_name[agent.name] for agent in agents if agent.name in by_name], problems


def _animate_alike(
    libraries: PreparedLibraries, bodies: PreparedBodies, agents: list[Agent], crowd: Crowd, options: MotionOptions
) -> tuple[list[Motion], list[Problem]]:
    """Motions of agents of one library, one source and one tuning that physics moves, and problems."""
    index = agents[0].library
    try:
        if agents[0].motion == "hybrid":
            prepared = libraries.prepared(crowd, index)
            found, faults = animate_apart(partial(animate_hybrids, prepared, crowd=crowd, options=options), agents)
            return found, [*prepared.problems, *faults, *unmeasured_steps(agents, found)]
        body = bodies.prepared(crowd, index, agents[0].tuning)
    except UsdfootError as error:
        return [], [fault_of(agent, error) for agent in agents]
    found, faults = animate_apart(partial(animate_bodies, body, crowd=crowd, options=options), agents)
    return found, [*faults, *unmeasured_steps(agents, found)]


def animate_bodies(
    body: PreparedBody, agents: Sequence[Agent], crowd: Crowd, *, options: MotionOptions
) -> list[Motion]:
    """Motions without clips of agents that are one character, all steps and frames at once."""
    planting, com = plan_bodies(body, agents, crowd, options=options)
    planted = plant_samples(planting, crowd, agents)
    figures = measure_contacts(planting.layout, planting.feet, planted.frames, measured=planted.feet, agents=agents)
    return cut_motions(planting, planted, _results(figures, com, agents), agents=agents)


def plan_bodies(
    body: PreparedBody, agents: Sequence[Agent], crowd: Crowd, *, options: MotionOptions
) -> tuple[Planting, ComMotion]:
    """What any frame of the agents is computed from, and the optimised centres of mass."""
    ground = _ground(agents, crowd)
    contacts = lay_contacts([agent.plan for agent in agents])
    contacts = lay_on_ground(contacts, ground, planned=contacts.positions, foot_lengths=body.rig.foot_lengths)
    segments = cut_segments(contacts, options)
    layout = Layout(
        skeleton=body.source.skeleton,
        pelvis=body.source.biped.pelvis,
        rig=body.rig,
        contacts=contacts,
        segments=segments,
        path=lay_root(contacts, segments, step_height_share=options.step_height_share),
        origins=np.array([agent.plan.positions[0] for agent in agents]),
        options=options,
    )
    com = optimise_contacts(contacts, body.physics, options.physics, scripts=_scripts(agents))
    source = BodyPoses(
        layout=layout,
        com=com,
        upper=body.upper,
        gait=device_gait(layout, body.source.biped, options.body),
        style=options.body,
        carriage=None if body.carriage is None else lay_carriage(com, body.carriage),
    )
    return prepare_planting(layout, source, ground, sinks_for_flights=False), com


def animate_hybrids(
    library: PreparedLibrary, agents: Sequence[Agent], crowd: Crowd, *, options: MotionOptions
) -> list[Motion]:
    """Motions in the style of clips whose pelvis the optimised centre of mass carries; agents share one tuning."""
    steps = prepare_steps(library, agents, crowd, options=options)
    measured = measure_biped(standing_skeleton(library.source), library.source.biped)
    biped = tune_biped(measured, agents[0].tuning)
    com = optimise_contacts(steps.setup.contacts, biped, options.physics, scripts=_scripts(agents))
    clips = ClipPoses(setup=steps.setup, arrays=steps.source.arrays)
    planting = prepare_planting(steps.setup, carry_pelvis(clips, com), _ground(agents, crowd), sinks_for_flights=False)
    planted = plant_samples(planting, crowd, agents)
    figures = measure_contacts(steps.setup, planting.feet, planted.frames, measured=planted.feet, agents=agents)
    results = measure_steps(steps.setup, steps.blend, steps.landings, figures=figures, agents=agents)
    forces = _forces(figures, com, agents)
    results = [replace(result, forces=force) for result, force in zip(results, forces, strict=True)]
    return cut_motions(planting, planted, results, agents=agents)


def _scripts(agents: Sequence[Agent]) -> list[OrientationScript | None]:
    """Body orientation of agents whose root trajectory says which way it faces ([P] 2.6)."""
    return [
        OrientationScript(times=given.times, rotations=quaternion.yaw_quaternion(given.yaws))
        if (given := agent.root_trajectory) is not None and given.yaws is not None
        else None
        for agent in agents
    ]


def _ground(agents: Sequence[Agent], crowd: Crowd) -> Ground:
    lowest = min(float(agent.plan.positions[:, 1].min()) for agent in agents)
    return Ground(crowd.terrain, fallback_height=lowest)


def _results(figures: FootstepFigures, com: ComMotion, agents: Sequence[Agent]) -> list[StepResults]:
    """Results of each agent's footsteps without clips."""
    zeros = np.zeros(len(figures.rows))
    stretched = com.steps.overstretch[figures.rows] > STRETCH_TOLERANCE * com.biped.maximal_length
    statuses = np.full(len(zeros), "ok", dtype=object)
    missed = np.fmax(figures.placement_error, figures.slide) > PLACED
    statuses[missed] = "ikLimited"
    statuses[stretched & missed] = "unreachable"
    statuses[~figures.on_ground] = "offTerrain"
    forces = _forces(figures, com, agents)
    return [
        StepResults(
            blend_error=zeros[a:b],
            placement_error=figures.placement_error[a:b],
            slide=figures.slide[a:b],
            yaw_error=figures.yaw_error[a:b],
            hull_distance=zeros[a:b],
            time_warp=zeros[a:b] + 1.0,
            root_weight=zeros[a:b],
            beta=zeros[a:b],
            root_velocity_error=zeros[a:b],
            status=tuple(statuses[a:b]),
            clip_counts=np.zeros(b - a, dtype=int),
            clips=(),
            clip_weights=np.zeros(0),
            forces=force,
        )
        for (a, b), force in zip(pairwise(step_ranges(agents)), forces, strict=True)
    ]


def _forces(figures: FootstepFigures, com: ComMotion, agents: Sequence[Agent]) -> list[ForceResults]:
    """What each agent's footsteps ask of physics."""
    steps, rows = com.steps, figures.rows
    return [
        ForceResults(
            force_imbalance=steps.force_imbalance[rows[a:b]],
            clamp_time=steps.clamp_time[rows[a:b]],
            jump_height=steps.jump_height[rows[a:b]],
        )
        for a, b in pairwise(step_ranges(agents))
    ]
