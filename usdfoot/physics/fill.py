"""Fill: steps for the holes of a library's footstep spaces, of physics in the style of the nearest clips."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from usdfoot.engine.animate import PreparedLibrary, animate_apart
from usdfoot.maths import quaternion
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import Agent, Crowd
from usdfoot.model.clip import AuthoredEvents, Clip, ClipLibrary
from usdfoot.model.motion import Motion
from usdfoot.model.report import Problem
from usdfoot.model.terrain import no_terrain
from usdfoot.physics.animate import animate_hybrids
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.physics.stride_plans import LANDING, plan_stride
from usdfoot.spaces.holes import Hole, HoleOptions, find_holes

__all__ = ["FilledLibrary", "fill_library"]

FARTHEST = 10.0
"""IK may pull landings as far as legs reach [m]."""
MISPLACED = 0.005
"""A synthetic step that lands farther from its hole than this is not used [m]."""


@dataclass(frozen=True, kw_only=True)
class FilledLibrary:
    """A library, its holes and the steps made for them."""

    source: ClipLibrary
    """As given."""
    holes: tuple[Hole, ...]
    """That were found."""
    clips: tuple[Clip, ...]
    """Synthetic: a stride each, with its events; fewer than holes where legs do not reach."""
    problems: tuple[Problem, ...]
    """Holes that could not be filled."""
    styles_without_runs: tuple[str, ...] = ()
    """Styles of which no clip runs: none are made, since a run is no walk over other footsteps."""

    @property
    def filled(self) -> ClipLibrary:
        """The library with the synthetic clips after its own."""
        return replace(self.source, clips=(*self.source.clips, *self.clips))


def fill_library(
    library: PreparedLibrary,
    outline: FloatArray,
    *,
    name: str,
    first: int = 0,
    holes: HoleOptions | None = None,
    options: MotionOptions | None = None,
) -> FilledLibrary:
    """Synthetic clips for the holes of a library.

    Into each hole leads a stride plan, walked by clips of the library (of the nearest triangle or edge, led by IK the
    rest of the way) with the pelvis on the optimised centre of mass. The stride of it that lands there is a clip. Holes
    of walks are filled from walks, and holes of runs from runs.

    Args:
        library: Clips, analysed.
        outline: Landings that the legs reach, as `find_holes` takes it.
        name: What the clips are named, followed by their number.
        first: Number of the first.
        holes: What a hole is.
        options: How the strides are animated.
    """
    options = options or MotionOptions()
    found = find_holes(library.spaces, outline, holes)
    styles = {
        flight: {style for style, flies, _ in library.spaces.spaces if flies == flight} for flight in (False, True)
    }
    walked_only = tuple(sorted(styles[False] - styles[True]))
    if not found:
        return FilledLibrary(source=library.source, holes=(), clips=(), problems=(), styles_without_runs=walked_only)
    agents = [_walker(hole, library, f"{name}{number:03d}") for number, hole in enumerate(found, start=first)]
    crowd = _crowd(library.source, agents)
    motions, problems = animate_apart(partial(animate_hybrids, library, crowd=crowd, options=options), agents)
    clips = []
    by_name = {agent.name: (agent, hole) for agent, hole in zip(agents, found, strict=True)}
    for motion in motions:
        agent, hole = by_name[motion.name]
        worst = float(motion.results.placement_error[LANDING - 1 : LANDING + 2].max())
        if worst > MISPLACED:
            problems.append(_out_of_reach(agent, hole, worst))
        else:
            clips.append(_clip_of(library.source, motion, agent, hole, crowd))
    return FilledLibrary(
        source=library.source,
        holes=tuple(found),
        clips=tuple(clips),
        problems=tuple(problems),
        styles_without_runs=walked_only,
    )


def _walker(hole: Hole, library: PreparedLibrary, name: str) -> Agent:
    """Who steps into a hole."""
    return Agent(
        name=name,
        source=name,
        plan=plan_stride(hole, library.spaces, library.examples, name=name),
        library=0,
        character=0,
        ik_reach=FARTHEST,
        motion="hybrid",
    )


def _crowd(library: ClipLibrary, agents: Sequence[Agent]) -> Crowd:
    """The agents on level ground, at the rate most clips have."""
    rates = np.array([clip.rate for clip in library.clips if not clip.synthetic] or [library.clips[0].rate])
    values, counts = np.unique(rates.round(6), return_counts=True)
    rate = float(values[np.argmax(counts)])
    last = max(agent.plan.end for agent in agents)
    return Crowd(
        agents=tuple(agents),
        libraries=(library,),
        terrain=no_terrain(),
        frame_times=np.arange(np.ceil(last * rate) + 1) / rate,
        frame_rate=rate,
    )


def _clip_of(library: ClipLibrary, motion: Motion, agent: Agent, hole: Hole, crowd: Crowd) -> Clip:
    """The motion as a clip of one stride: from the strike before the hole to the one after it."""
    skeleton, pelvis = library.skeleton, library.biped.pelvis
    frames = np.isin(motion.times, crowd.frame_times)
    turn = quaternion.yaw_quaternion(motion.root_yaws[frames])
    place = motion.root_positions[frames] + quaternion.rotate(turn, motion.pelvis_positions[frames].astype(float))
    turned = quaternion.compose(turn, motion.pelvis_rotations[frames].astype(float))
    rotations = motion.rotations[frames].astype(float)
    translations = np.repeat(skeleton.rest_translations[None], len(rotations), axis=0)
    origin, axes = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])
    for joint in reversed(skeleton.ancestors(pelvis)):
        rotations[:, joint] = skeleton.rest_rotations[joint]
        origin = origin + quaternion.rotate(axes, skeleton.rest_translations[joint])
        axes = quaternion.compose(axes, skeleton.rest_rotations[joint])
    back = quaternion.inverse(axes)
    translations[:, pelvis] = quaternion.rotate(back, place - origin)
    rotations[:, pelvis] = quaternion.compose(back, turned)
    times = motion.times[frames]
    strikes = agent.plan.strike_times
    return Clip(
        name=agent.source,
        rate=crowd.frame_rate,
        start_time=float(times[0]),
        translations=translations,
        rotations=quaternion.continuous(quaternion.normalised(rotations)),
        style=hole.style,
        root_motion="travel",
        cyclic=False,
        range_start=float(strikes[LANDING - 1]),
        range_end=float(strikes[LANDING + 1]),
        mirror=hole.mirrored,
        events=(_events(motion, 0), _events(motion, 1)),
        synthetic=True,
    )


def _events(motion: Motion, side: int) -> AuthoredEvents:
    foot = motion.contacts[side]
    return AuthoredEvents(strike_times=foot.strike_times, flat_times=foot.flat_times, liftoff_times=foot.liftoff_times)


def _out_of_reach(agent: Agent, hole: Hole, worst: float) -> Problem:
    x, z = hole.landing
    message = f"style {hole.style!r}: a step {z:.2f} m ahead and {x:.2f} m aside misses by {100.0 * worst:.1f} cm"
    return Problem(severity="warning", where=agent.source, message=f"{message}: the hole stays open")
