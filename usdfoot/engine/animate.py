"""The engine's recipe: footstep plans and a clip library in, finished motions out."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise
from typing import Protocol, TypeVar

import numpy as np

from usdfoot.analysis.examples import build_examples
from usdfoot.analysis.hip_spacing import hip_width
from usdfoot.analysis.standing import find_standing_pose
from usdfoot.engine.blend_shapes import ExampleShapes, blend_shapes, sample_shapes
from usdfoot.engine.given_roots import guide_headings
from usdfoot.engine.kernels import LibraryArrays
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.planting import Planted, Planting, cut_motions, plant_samples, prepare_planting
from usdfoot.engine.poses import ClipPoses, Setup, StepBlend, device_library, device_segments, place_segments
from usdfoot.engine.reach import steps_off_terrain, unreached_steps
from usdfoot.engine.results import measure_contacts, measure_steps, unmeasured_steps
from usdfoot.engine.rig import Rig, build_rig
from usdfoot.engine.root import lay_root
from usdfoot.engine.root_goals import root_goals
from usdfoot.engine.seams import measure_seams
from usdfoot.engine.segments import cut_segments
from usdfoot.engine.slopes import ankle_sinks
from usdfoot.engine.stand import with_stand
from usdfoot.engine.styles import contact_styles
from usdfoot.engine.time_warps import extreme_warps, longest_step
from usdfoot.engine.weights import Landings, weigh_steps
from usdfoot.errors import ClipError, UsdfootError
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.clip import ClipLibrary, ShapeTrack
from usdfoot.model.contact_table import ContactTable, lay_contacts, lay_on_ground
from usdfoot.model.device import start_warp
from usdfoot.model.examples import Examples
from usdfoot.model.ground import Ground
from usdfoot.model.motion import Motion
from usdfoot.model.report import Problem
from usdfoot.spaces.library import FootstepSpaces, spaces_of

__all__ = [
    "ExamplesBuilder",
    "PreparedLibraries",
    "PreparedLibrary",
    "PreparedSteps",
    "animate_agents",
    "animate_apart",
    "animate_crowd",
    "blend_steps",
    "fault_of",
    "prepare_library",
    "prepare_steps",
]

Result = TypeVar("Result")


class ExamplesBuilder(Protocol):
    """What cuts the steps of a library: `build_examples`, or who has kept what that made."""

    def __call__(self, library: ClipLibrary, *, samples: int) -> tuple[Examples, list[Problem]]:
        """Examples, and which clips give none."""
        ...


_logger = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class PreparedLibrary:
    """A clip library analysed once for all agents that use it."""

    source: ClipLibrary
    examples: Examples
    """Steps, and a stand as the last."""
    spaces: FootstepSpaces
    rig: Rig
    device: LibraryArrays
    style: str
    """Style of plans that name none."""
    shapes: ExampleShapes | None
    """Blend shapes of the clips."""
    problems: tuple[Problem, ...]

    @cached_property
    def hip_width(self) -> float:
        """Between the hip joints of the character [m]."""
        return hip_width(self.source.skeleton, self.source.biped)


@dataclass(frozen=True, kw_only=True)
class PreparedSteps:
    """All steps of all agents of a library: any frame can be computed from them on its own."""

    setup: Setup
    blend: StepBlend
    landings: Landings
    source: ClipPoses
    planting: Planting


def prepare_library(
    library: ClipLibrary, options: EngineOptions, *, build: ExamplesBuilder = build_examples
) -> PreparedLibrary:
    """Cuts the steps, builds the spaces and loads both onto the device.

    Args:
        library: Skeleton, biped and clips.
        options: Of the engine.
        build: Cuts the steps.

    Raises:
        ClipError: If no clip has a usable step.
    """
    start_warp()
    examples, problems = build(library, samples=options.samples)
    if not len(examples):
        reasons = [problem.message for problem in problems]
        where = "clip library"  # not its Skeleton, of which several are alike: agents say whose it is
        raise ClipError(where, "has no clip with a usable step", names=reasons)
    rig = build_rig(library.skeleton, library.biped, examples)
    whole = with_stand(examples, find_standing_pose(library, examples))
    return PreparedLibrary(
        source=library,
        examples=whole,
        spaces=spaces_of(library, examples, polar=options.band == "polar", frame=options.frame),
        rig=rig,
        device=device_library(
            whole, rig, pelvis=library.biped.pelvis, slerps=options.blend == "slerp", frame=options.frame
        ),
        style=examples.default_style,
        shapes=sample_shapes(library, whole),
        problems=tuple(problems),
    )


class PreparedLibraries:
    """The clip libraries of a crowd, each prepared when it is first asked for.

    Args:
        options: Of the engine.
        build: Cuts their steps.
    """

    def __init__(self, options: EngineOptions, *, build: ExamplesBuilder = build_examples) -> None:
        self._options = options
        self._build = build
        self._prepared: dict[int, PreparedLibrary] = {}

    def prepared(self, crowd: Crowd, index: int) -> PreparedLibrary:
        """The crowd's library at an index, which must mean the same library in every crowd asked about.

        Raises:
            UsdfootError: If it cannot be used.
        """
        if index not in self._prepared:
            self._prepared[index] = prepare_library(crowd.libraries[index], self._options, build=self._build)
        return self._prepared[index]


def animate_crowd(
    crowd: Crowd, *, options: EngineOptions | None = None, libraries: PreparedLibraries | None = None
) -> tuple[list[Motion], list[Problem]]:
    """Motions of all agents that could be animated, in the crowd's order, and what was wrong with the others.

    Args:
        crowd: Agents and what they need.
        options: Of the engine.
        libraries: Those of an earlier call on other agents of the same scene.
    """
    options = options or EngineOptions()
    libraries = libraries or PreparedLibraries(options)
    motions: dict[str, Motion] = {}
    problems: list[Problem] = []
    for index in range(len(crowd.libraries)):
        agents = [agent for agent in crowd.agents if agent.library == index]
        if not agents:
            continue
        try:
            prepared = libraries.prepared(crowd, index)
        except UsdfootError as error:
            problems += [fault_of(agent, error) for agent in agents]
            continue
        found, faults = animate_apart(partial(animate_agents, prepared, crowd=crowd, options=options), agents)
        problems += [*prepared.problems, *faults, *extreme_warps(agents, found, options)]
        problems += [*unreached_steps(agents, found), *steps_off_terrain(agents, found)]
        problems += unmeasured_steps(agents, found)
        motions.update({motion.name: motion for motion in found})
    return [motions[agent.name] for agent in crowd.agents if agent.name in motions], problems


def animate_apart(
    animate: Callable[[Sequence[Agent]], list[Result]], agents: Sequence[Agent]
) -> tuple[list[Result], list[Problem]]:
    """What comes of agents animated together; if they fail together, of those that can be animated alone.

    Errors nobody foresaw count too: a fault of usdfoot's own that one agent runs into must not cost the others their
    motion. The agent's problem says which error it was, the log where it came from.
    """
    try:
        return animate(agents), []
    except Exception as error:
        if len(agents) == 1:
            return [], [fault_of(agents[0], error)]
    half = len(agents) // 2
    parts = [animate_apart(animate, part) for part in (agents[:half], agents[half:])]
    return parts[0][0] + parts[1][0], parts[0][1] + parts[1][1]


def fault_of(agent: Agent, error: Exception) -> Problem:
    """Why an agent could not be animated."""
    reason = str(error)
    if not isinstance(error, UsdfootError):
        _logger.error("%s cannot be animated", agent.source, exc_info=error)
        reason = f"usdfoot itself failed, please report it ({type(error).__name__}: {error})"
    return Problem(severity="error", where=agent.source, message=f"{agent.source}: {reason}")


def animate_agents(
    library: PreparedLibrary, agents: Sequence[Agent], crowd: Crowd, *, options: EngineOptions
) -> list[Motion]:
    """Motions of agents that share one library, all steps and frames at once."""
    steps = prepare_steps(library, agents, crowd, options=options)
    planted = plant_samples(steps.planting, crowd, agents)
    figures = measure_contacts(steps.setup, steps.planting.feet, planted.frames, measured=planted.feet, agents=agents)
    results = measure_steps(steps.setup, steps.blend, steps.landings, figures=figures, agents=agents)
    motions = cut_motions(steps.planting, planted, results, agents=agents)
    return motions if library.shapes is None else _with_shapes(library.shapes, steps, planted, motions)


def _with_shapes(
    shapes: ExampleShapes, steps: PreparedSteps, planted: Planted, motions: Sequence[Motion]
) -> list[Motion]:
    """The motions with the blend shapes of their clips."""
    frames = planted.frames
    weights = blend_shapes(
        shapes, steps.setup, steps.blend, arrays=steps.source.arrays, rows=frames.segments, times=frames.times
    )
    own = [weights[first:stop][planted.kept[first:stop]] for first, stop in pairwise(frames.first)]
    return [
        replace(motion, shapes=ShapeTrack(names=shapes.names, weights=rows))
        for motion, rows in zip(motions, own, strict=True)
    ]


def prepare_steps(
    library: PreparedLibrary, agents: Sequence[Agent], crowd: Crowd, *, options: EngineOptions
) -> PreparedSteps:
    """Weights, seams, prints and swings of all steps of agents that share one library."""
    ground = Ground(crowd.terrain)
    planned = guide_headings(lay_contacts([agent.plan for agent in agents]), agents)
    setup, blend, landings = blend_steps(library, agents, planned, options=options)
    contacts = lay_on_ground(setup.contacts, ground, planned=planned.positions, foot_lengths=library.rig.foot_lengths)
    share, sinks = options.step_height_share, ankle_sinks(library.rig, contacts, ground)
    path = lay_root(contacts, setup.segments, step_height_share=share, sinks=sinks)
    setup = replace(setup, contacts=contacts, path=path)
    arrays = device_segments(setup, blend)
    seams = measure_seams(setup, arrays) if options.seam != "none" else None
    source = ClipPoses(setup=setup, arrays=place_segments(setup, arrays, seams))
    planting = prepare_planting(setup, source, ground)
    return PreparedSteps(setup=setup, blend=blend, landings=landings, source=source, planting=planting)


def blend_steps(
    library: PreparedLibrary, agents: Sequence[Agent], contacts: ContactTable, *, options: EngineOptions
) -> tuple[Setup, StepBlend, Landings]:
    """Which examples the steps of agents that share one library are blended from.

    Args:
        library: Prepared.
        agents: In the order of the contacts.
        contacts: As planned.
        options: Of the engine.

    Returns:
        The setup with contacts as executed, not yet on the ground, the blend of each segment, and how landings meet.
    """
    segments = cut_segments(contacts, options, longest_step=longest_step(library.examples, options))
    setup = Setup(
        skeleton=library.source.skeleton,
        pelvis=library.source.biped.pelvis,
        examples=library.examples,
        rig=library.rig,
        library=library.device,
        contacts=contacts,
        segments=segments,
        path=lay_root(contacts, segments, step_height_share=options.step_height_share),
        origins=np.array([agent.plan.positions[0] for agent in agents]),
        leg_length=library.source.biped.maximal_leg_length,
        hip_width=library.hip_width,
        styles=contact_styles(contacts, agents, known=library.examples.styles[:-1], default=library.style),
        options=options,
    )
    reach = np.array([agent.ik_reach for agent in agents])
    goals, stand = root_goals(setup, agents), len(library.examples) - 1
    return weigh_steps(setup, library.spaces, goals, stand=stand, reach=reach)
