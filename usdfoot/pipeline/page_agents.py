"""The agents of the page: each read, measured and pictured on its own, by this process or by several."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.figures import frames_between
from usdfoot.errors import UsdfootError
from usdfoot.maths.types import FloatArray
from usdfoot.model.ground import Ground
from usdfoot.model.report import Problem
from usdfoot.pipeline import shares
from usdfoot.pipeline.measures import AgentMeasures, measure_agent
from usdfoot.pipeline.page_figures import frame_values, step_values
from usdfoot.pipeline.written_feet import planted_times
from usdfoot.readers.executed import read_root_positions, read_step_results
from usdfoot.readers.joint_tracks import JointTracks, read_joint_tracks
from usdfoot.readers.written import WrittenAgent, WrittenCrowd, read_agent, read_written_crowd
from usdfoot.writers.page.pictures import AgentPicture
from usdfoot.writers.page.stick import stick_figure

__all__ = ["SeenAgent", "see_agents"]


@dataclass(frozen=True, kw_only=True)
class SeenAgent:
    """One agent, measured."""

    picture: AgentPicture
    """With every frame, and without what only the report knows: its source and the figures against the clips."""
    measures: AgentMeasures


def see_agents(
    crowd: WrittenCrowd,
    names: Sequence[str],
    *,
    crowd_file: str | os.PathLike[str],
    executor: Executor | None,
    progress: Callable[[str, int, int], None],
) -> Iterator[SeenAgent | Problem]:
    """Every agent in the order of the names, or why it cannot be shown.

    Args:
        crowd: As opened here.
        names: Of the agents.
        crowd_file: Where the executor's workers find the crowd.
        executor: None = this process alone; it also does what is too little to share.
        progress: Told "measure", how many are done, and of how many.

    Raises:
        UsdfootError: If a worker vanished.
    """
    if executor is None or len(names) <= shares.SHARE:
        ground = _ground(crowd)
        for number, name in enumerate(names):
            progress("measure", number, len(names))
            yield _see_agent(crowd, name, ground)
        return
    yield from shares.in_shares(_see_share, crowd_file, names, executor=executor, progress=progress)


def _see_share(crowd_file: str, names: Sequence[str]) -> list[SeenAgent | Problem]:
    """What a worker does."""
    crowd = read_written_crowd(crowd_file)
    ground = _ground(crowd)
    return [_see_agent(crowd, name, ground) for name in names]


def _ground(crowd: WrittenCrowd) -> Ground | None:
    """What the agents walk on, None if the scene is not known."""
    return None if crowd.terrain is None else Ground(crowd.terrain)


def _see_agent(crowd: WrittenCrowd, name: str, ground: Ground | None) -> SeenAgent | Problem:
    try:
        agent = read_agent(crowd, name)
        measures = measure_agent(agent, crowd.units, ground)
    except UsdfootError as error:
        return Problem(severity="error", where=error.where, message=str(error))
    return SeenAgent(picture=_picture_agent(agent, crowd, measures), measures=measures)


def _picture_agent(agent: WrittenAgent, crowd: WrittenCrowd, measures: AgentMeasures) -> AgentPicture:
    tracks = read_joint_tracks(agent, crowd.units, agent.frame_codes)
    results = read_step_results(agent, crowd.units)
    stick = stick_figure(agent.skeleton, agent.biped)
    roots = read_root_positions(agent, crowd.units, agent.frame_codes)
    soles = measures.sole_heights.min(axis=2)
    pelvis = tracks.positions[:, agent.biped.pelvis, 1] - roots[:, 1]
    steps = step_values(measures, results) | frame_values(
        agent.plan, tracks.times, pelvis_heights=pelvis, sole_heights=soles
    )
    return AgentPicture(
        name=agent.name,
        source="",
        plan=agent.plan,
        flat_times=planted_times(agent),
        stick_figure=stick,
        times=tracks.times,
        roots=roots,
        joints=tracks.positions[:, list(stick.joints)],
        sole_heights=soles,
        stood=_stood(agent, tracks),
        promised=measures.promised,
        results=results,
        steps=steps,
        whole={},
    )


def _stood(agent: WrittenAgent, tracks: JointTracks) -> FloatArray:
    """Sole under the ball of each footstep's foot, mean over its planted frames [m], NaN without any, shape (N, 3)."""
    plan = agent.plan
    planted = frames_between(tracks.times, planted_times(agent), plan.liftoff_times)
    frames, steps = planted.flattened()
    sums = np.zeros((len(plan), 3))
    np.add.at(sums, steps, tracks.positions[frames, np.array(agent.biped.balls)[plan.sides[steps]]])
    means = sums / np.where(planted.counts > 0, planted.counts, np.nan)[:, None]
    means[:, 1] -= agent.biped.ball_heights[plan.sides]
    return means
