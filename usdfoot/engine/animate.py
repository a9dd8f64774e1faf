"""The engine's recipe: footstep plans and a clip library in, finished motions out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import warp as wp

from usdfoot.analysis.examples import build_examples
from usdfoot.analysis.standing import find_standing_pose
from usdfoot.engine.detours import plan_detours
from usdfoot.engine.feet import ContactFeet, device_feet, lead_swings, roll_contacts
from usdfoot.engine.frames import Frames, lay_frames
from usdfoot.engine.kernels import LibraryArrays, SegmentArrays
from usdfoot.engine.options import EngineOptions
from usdfoot.engine.plant import plant_feet
from usdfoot.engine.poses import Feet, Poses, Setup, StepBlend, device_library, device_segments, pose_feet, pose_frames
from usdfoot.engine.results import achieved_contacts, measure_steps
from usdfoot.engine.rig import Rig, build_rig
from usdfoot.engine.root import lay_root, root_at
from usdfoot.engine.root_goals import root_goals
from usdfoot.engine.seams import measure_seams
from usdfoot.engine.segments import cut_segments
from usdfoot.engine.stand import with_stand
from usdfoot.engine.subframes import drifting_frames, insert_frames, merge_poses
from usdfoot.engine.weights import Landings, weigh_steps
from usdfoot.errors import ClipError, UsdfootError
from usdfoot.maths import quaternion
from usdfoot.maths.timeline import locate
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.contact_table import lay_contacts, lay_on_ground
from usdfoot.model.device import start_warp
from usdfoot.model.examples import Examples
from usdfoot.model.ground import Ground
from usdfoot.model.motion import Motion
from usdfoot.model.report import Problem
from usdfoot.spaces.library import FootstepSpaces, build_spaces

__all__ = [
    "PreparedLibrary",
    "PreparedSteps",
    "animate_agents",
    "animate_crowd",
    "plant_frames",
    "prepare_library",
    "prepare_steps",
]


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
    problems: tuple[Problem, ...]


@dataclass(frozen=True, kw_only=True)
class PreparedSteps:
    """All steps of all agents of a library: any frame can be computed from them on its own."""

    setup: Setup
    blend: StepBlend
    landings: Landings
    arrays: SegmentArrays
    """Segments and their seams on the device."""
    feet: ContactFeet
    detours: FloatArray
    """Offsets of each contact's swing [m], shape (C, K, 3)."""


def prepare_library(library: ClipLibrary, options: EngineOptions) -> PreparedLibrary:
    """Cuts the steps, builds the spaces and loads both onto the device.

    Raises:
        ClipError: If no clip has a usable step.
    """
    start_warp()
    examples, problems = build_examples(library, samples=options.samples)
    if not len(examples):
        reasons = [problem.message for problem in problems]
        raise ClipError(library.skeleton.name, "has no clip with a usable step", names=reasons)
    rig = build_rig(library.skeleton, library.biped, examples)
    whole = with_stand(examples, find_standing_pose(library, examples))
    styles = list(examples.styles)
    style = "default" if "default" in styles else max(sorted(set(styles)), key=styles.count)
    return PreparedLibrary(
        source=library,
        examples=whole,
        spaces=build_spaces(examples),
        rig=rig,
        device=device_library(library.skeleton, whole, rig, pelvis=library.biped.pelvis),
        style=style,
        problems=tuple(problems),
    )


def animate_crowd(crowd: Crowd, *, options: EngineOptions | None = None) -> tuple[list[Motion], list[Problem]]:
    """Motions of all agents that could be animated, in the crowd's order, and what was wrong with the others."""
    options = options or EngineOptions()
    motions: dict[str, Motion] = {}
    problems = [problem for agent in crowd.agents for problem in _not_from_clips(agent)]
    for index, library in enumerate(crowd.libraries):
        agents = [agent for agent in crowd.agents if agent.library == index and agent.motion != "physics"]
        if not agents:
            continue
        try:
            prepared = prepare_library(library, options)
        except UsdfootError as error:
            problems += [Problem(severity="error", where=agent.source, message=str(error)) for agent in agents]
            continue
        found, faults = _animate_each(prepared, agents, crowd, options)
        problems += [*prepared.problems, *faults]
        motions.update({motion.name: motion for motion in found})
    return [motions[agent.name] for agent in crowd.agents if agent.name in motions], problems


def _not_from_clips(agent: Agent) -> list[Problem]:
    """What an agent asks for beyond clips, which is all there is so far."""
    if agent.motion == "clips":
        return []
    severity, done = ("error", "it was skipped") if agent.motion == "physics" else ("warning", "clips alone were used")
    message = f"{agent.source}: usdfoot:agent:motion is {agent.motion}, which cannot be made yet; {done}. Author clips"
    return [Problem(severity=severity, where=agent.source, message=message)]


def _animate_each(
    prepared: PreparedLibrary, agents: list[Agent], crowd: Crowd, options: EngineOptions
) -> tuple[list[Motion], list[Problem]]:
    """Motions of agents of one library; if they fail together, of those that can be animated alone."""
    try:
        return animate_agents(prepared, agents, crowd, options=options), []
    except UsdfootError as error:
        if len(agents) == 1:
            return [], [Problem(severity="error", where=agents[0].source, message=f"{agents[0].source}: {error}")]
    half = len(agents) // 2
    parts = [_animate_each(prepared, part, crowd, options) for part in (agents[:half], agents[half:])]
    return parts[0][0] + parts[1][0], parts[0][1] + parts[1][1]


def animate_agents(
    library: PreparedLibrary, agents: Sequence[Agent], crowd: Crowd, *, options: EngineOptions
) -> list[Motion]:
    """Motions of agents that share one library, all steps and frames at once."""
    steps = prepare_steps(library, agents, crowd, options=options)
    frames = lay_frames(steps.setup.contacts, steps.setup.segments, crowd.frame_times)
    poses = plant_frames(steps, frames)
    feet = pose_feet(library.rig, poses)
    drifting = drifting_frames(steps.setup, steps.feet, frames, poses, feet, tolerance=options.subframe_slide)
    if drifting.any():
        added, frames, order = insert_frames(steps.setup, frames, drifting)
        poses = merge_poses(poses, plant_frames(steps, added), order)
        feet = pose_feet(library.rig, poses)
    results = measure_steps(steps.setup, steps.blend, steps.landings, steps.feet, frames, feet, list(agents))
    return _motions(steps.setup, steps.feet, frames, poses, results, agents)


def prepare_steps(
    library: PreparedLibrary, agents: Sequence[Agent], crowd: Crowd, *, options: EngineOptions
) -> PreparedSteps:
    """Weights, seams, prints and swings of all steps of agents that share one library."""
    lowest = min(float(agent.plan.positions[:, 1].min()) for agent in agents)
    ground = Ground(crowd.terrain, fallback_height=lowest)
    contacts = lay_contacts([agent.plan for agent in agents])
    segments = cut_segments(contacts, options)
    setup = Setup(
        skeleton=library.source.skeleton,
        examples=library.examples,
        rig=library.rig,
        library=library.device,
        contacts=contacts,
        segments=segments,
        path=lay_root(contacts, segments, step_height_share=options.step_height_share),
        origins=np.array([agent.plan.positions[0] for agent in agents]),
        leg_length=library.source.biped.maximal_leg_length,
        style=library.style,
        options=options,
    )
    reach = np.array([agent.ik_reach for agent in agents])
    goals, stand = root_goals(setup, agents), len(library.examples) - 1
    setup, blend, landings = weigh_steps(setup, library.spaces, goals, stand=stand, reach=reach)
    contacts = lay_on_ground(setup.contacts, ground, planned=contacts.positions)
    setup = replace(
        setup, contacts=contacts, path=lay_root(contacts, setup.segments, step_height_share=options.step_height_share)
    )
    arrays = device_segments(setup, blend, measure_seams(setup, blend) if options.seam != "none" else None)
    feet = _prepare_feet(setup, blend, arrays, ground)
    detours = plan_detours(setup, blend, arrays, feet, ground)
    return PreparedSteps(setup=setup, blend=blend, landings=landings, arrays=arrays, feet=feet, detours=detours)


def _prepare_feet(setup: Setup, blend: StepBlend, arrays: SegmentArrays, ground: Ground) -> ContactFeet:
    """Prints, rolls and leads of all contacts, from the blended feet at their strikes and liftoffs."""
    strikes = _feet_at(setup, blend, arrays, setup.contacts.strikes)
    liftoffs = _feet_at(setup, blend, arrays, setup.contacts.liftoffs)
    sides = setup.contacts.sides
    own = np.arange(len(sides)), sides
    feet = roll_contacts(setup, strikes.raises[own], ground)
    feet = replace(feet, flat_pitches=_feet_at(setup, blend, arrays, feet.flats).raises[own])
    return lead_swings(setup, feet, strikes, liftoffs)


def _feet_at(setup: Setup, blend: StepBlend, arrays: SegmentArrays, times: FloatArray) -> Feet:
    """Blended feet at one time for each contact [s], not before its agent's first strike."""
    contacts, segments = setup.contacts, setup.segments
    times = np.maximum(times, contacts.starts[contacts.agents])
    rows = locate(segments.agents, segments.begins, contacts.starts, contacts.agents, times)
    return pose_feet(setup.rig, pose_frames(setup, blend, arrays, rows, times, joints=setup.rig.leg_joints))


def plant_frames(steps: PreparedSteps, frames: Frames) -> Poses:
    """Frames blended, placed and planted."""
    setup = steps.setup
    joints = np.setdiff1d(np.arange(len(setup.skeleton.joints)), [setup.library.pelvis])
    poses = pose_frames(setup, steps.blend, steps.arrays, frames.segments, frames.times, joints=joints)
    clock = frames.times - setup.contacts.starts[frames.agents]
    wp.launch(
        plant_feet,
        dim=len(frames.times),
        inputs=[
            setup.rig.arrays,
            device_feet(setup, steps.feet, steps.detours),
            wp.array(frames.contacts.astype(np.int32), dtype=wp.int32),
            wp.array(clock.astype(np.float32), dtype=wp.float32),
            poses.pelvis_positions,
            poses.pelvis_rotations,
            poses.rotations,
        ],
    )
    return poses


def _motions(
    setup: Setup, feet: ContactFeet, frames: Frames, poses: Poses, results: list, agents: Sequence[Agent]
) -> list[Motion]:
    """Frames cut into one motion an agent, the pelvis relative to its root."""
    root = root_at(setup.path, frames.segments, frames.times)
    origins = setup.origins[frames.agents]
    turn = quaternion.yaw_quaternion(-root[:, 3])
    pelvis = quaternion.rotate(turn, poses.pelvis_positions.numpy() + (origins - root[:, :3]))
    turned = quaternion.compose(turn, poses.pelvis_rotations.numpy())
    rotations = poses.rotations.numpy()
    rotations[:, setup.library.pelvis] = turned
    motions = []
    for index, agent in enumerate(agents):
        own = slice(frames.first[index], frames.first[index + 1])
        motions.append(
            Motion(
                name=agent.name,
                times=frames.stamps[own],
                root_positions=root[own, :3],
                root_yaws=root[own, 3],
                pelvis_positions=pelvis[own].astype(np.float32),
                pelvis_rotations=turned[own].astype(np.float32),
                rotations=rotations[own],
                contacts=achieved_contacts(setup, feet, index),
                results=results[index],
            )
        )
    return motions
