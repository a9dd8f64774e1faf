"""A crowd's picture as the arrays and the header of the page; assets/crowd.js reads them in the same order."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from usdfoot import __version__
from usdfoot.maths.types import FloatArray
from usdfoot.model.biped import LEFT
from usdfoot.model.motion import STATUSES
from usdfoot.writers.page.block import quantised
from usdfoot.writers.page.pictures import AgentPicture, CrowdPicture, PageFigure, StickFigure
from usdfoot.writers.prints import print_outline

__all__ = ["crowd_arrays", "crowd_header"]

LENGTH = 1e-3
"""Resolution of root and joint positions [m]."""
SOLE_HEIGHT = 1e-4
"""Resolution of heights over the terrain [m]."""
FARTHEST = 32_000
"""Joints are at most this many resolutions from their root."""

Arrays = dict[str, NDArray[Any]]


def crowd_header(crowd: CrowdPicture) -> dict[str, Any]:
    """What the page is told in words and single numbers."""
    first = crowd.agents[0] if crowd.agents else None
    return {
        "version": __version__,
        "title": crowd.title,
        "names": [agent.name for agent in crowd.agents],
        "sources": [agent.source for agent in crowd.agents],
        "figures": [_figure(figure) for figure in crowd.figures],
        "statuses": list(_statuses(crowd.agents)),
        "clips": list(_clips(crowd.agents)),
        "stickFigures": [
            {
                "parents": stick.parents,
                "sides": stick.sides,
                "head": stick.head,
                "legLength": stick.leg_length,
                "footLength": stick.foot_length,
            }
            for stick in _stick_figures(crowd.agents)
        ],
        "printOutline": print_outline(LEFT, 1.0)[:, [0, 2]].ravel().tolist(),
        "origin": _origin(crowd).tolist(),
        "start": _start(crowd) if first else 0.0,
        "frameTime": crowd.frame_time,
        "codeRate": crowd.code_rate,
        "resolution": _resolution(crowd.agents),
        "soleResolution": SOLE_HEIGHT,
        "groundLevel": crowd.ground.level - float(_origin(crowd)[1]),
        "total": [{key: _plain(value) for key, value in row.items()} for row in crowd.total],
        "problems": list(crowd.problems),
        "notes": list(crowd.notes),
        "facts": dict(crowd.facts),
    }


def crowd_arrays(crowd: CrowdPicture) -> Arrays:
    """Every array of the page by name: agents end to end, each one's frames or footsteps together."""
    agents, origin, start = crowd.agents, _origin(crowd), _start(crowd)
    sticks = {stick: index for index, stick in enumerate(_stick_figures(agents))}
    roots = [np.rint((agent.roots - origin) / LENGTH).astype(np.int32) for agent in agents]
    resolution = _resolution(agents)
    joints = [
        quantised(agent.joints - origin - LENGTH * root[:, None], resolution)
        for agent, root in zip(agents, roots, strict=True)
    ]
    return {
        "frameCounts": np.array([len(agent.times) for agent in agents], dtype=np.int32),
        "stepCounts": np.array([len(agent.plan) for agent in agents], dtype=np.int32),
        "stickIndices": np.array([sticks[agent.stick_figure] for agent in agents], dtype=np.uint16),
        "startTimes": np.array([agent.times[0] - start for agent in agents], dtype=np.float32),
        "roots": _joined([root.T.ravel() for root in roots], np.int32),
        "joints": _joined([part.transpose(1, 2, 0).ravel() for part in joints], np.int16),
        "soles": _joined([quantised(agent.sole_heights, SOLE_HEIGHT).T.ravel() for agent in agents], np.int16),
        **_step_arrays(agents, origin, start),
        **_figure_arrays(crowd),
        "groundPoints": (crowd.ground.points - origin).astype(np.float32).ravel(),
        "groundTriangles": crowd.ground.triangles.astype(np.uint32).ravel(),
        "groundWalkable": crowd.ground.walkable.astype(np.uint8),
    }


def _step_arrays(agents: Sequence[AgentPicture], origin: FloatArray, start: float) -> Arrays:
    """Footsteps: where and when they were planned, where the ball stood, what was blended."""
    statuses, clips = _statuses(agents), _clips(agents)

    def floats(parts: Sequence[FloatArray]) -> NDArray[Any]:
        return _joined([np.asarray(part).ravel() for part in parts], np.float32)

    return {
        "sides": _joined([agent.plan.sides for agent in agents], np.uint8),
        "positions": floats([agent.plan.positions - origin for agent in agents]),
        "orientations": floats([agent.plan.orientations for agent in agents]),
        "strikeTimes": floats([agent.plan.strike_times - start for agent in agents]),
        "flatTimes": floats([agent.flat_times - start for agent in agents]),
        "liftoffTimes": floats([agent.plan.liftoff_times - start for agent in agents]),
        "stood": floats([agent.stood - origin for agent in agents]),
        "promised": _joined([agent.promised for agent in agents], np.uint8),
        "stepStatuses": np.array([statuses[name] for agent in agents for name in agent.results.status], np.uint8),
        "rootWeights": floats([agent.results.root_weight for agent in agents]),
        "clipCounts": _joined([agent.results.clip_counts for agent in agents], np.uint16),
        "clipIndices": np.array([clips[name] for agent in agents for name in agent.results.clips], np.uint16),
        "clipWeights": floats([agent.results.clip_weights for agent in agents]),
    }


def _figure_arrays(crowd: CrowdPicture) -> Arrays:
    """Values of the figures: "step:<key>" one a footstep, "agent:<key>" one an agent."""
    arrays: Arrays = {}
    for figure in crowd.figures:
        if figure.per_agent:
            values = np.array([agent.whole[figure.key] for agent in crowd.agents], dtype=np.float32)
            arrays[f"agent:{figure.key}"] = values
        else:
            arrays[f"step:{figure.key}"] = _joined([agent.steps[figure.key] for agent in crowd.agents], np.float32)
    return arrays


def _figure(figure: PageFigure) -> dict[str, Any]:
    return {
        "key": figure.key,
        "title": figure.title,
        "unit": figure.unit,
        "digits": figure.digits,
        "meaning": figure.meaning,
        "target": figure.target,
        "atLeast": figure.at_least,
        "ofMean": figure.of_mean,
        "perAgent": figure.per_agent,
    }


def _origin(crowd: CrowdPicture) -> FloatArray:
    """Middle of the footsteps, in whole metres: what the page's positions are relative to [m], shape (3,)."""
    if not crowd.agents:
        return np.zeros(3)
    places = np.concatenate([agent.plan.positions for agent in crowd.agents])
    return np.rint(0.5 * (places.min(axis=0) + places.max(axis=0)))


def _start(crowd: CrowdPicture) -> float:
    """First frame of anybody [s]."""
    return min((float(agent.times[0]) for agent in crowd.agents), default=0.0)


def _resolution(agents: Sequence[AgentPicture]) -> float:
    """Of the joints: LENGTH, or coarser for figures too large for 16 bits [m]."""
    reaches = [np.abs(agent.joints - agent.roots[:, None]).max(initial=0.0) for agent in agents]
    return max(LENGTH, math.ceil(max(reaches, default=0.0) / FARTHEST / LENGTH) * LENGTH)


def _stick_figures(agents: Sequence[AgentPicture]) -> list[StickFigure]:
    """Different stick figures in order of appearance."""
    return list(dict.fromkeys(agent.stick_figure for agent in agents))


def _statuses(agents: Sequence[AgentPicture]) -> dict[str, int]:
    """Index of every status, the known ones first."""
    names = dict.fromkeys([*STATUSES, *sorted({name for agent in agents for name in agent.results.status})])
    return {name: index for index, name in enumerate(names)}


def _clips(agents: Sequence[AgentPicture]) -> dict[str, int]:
    """Index of every clip blended."""
    return {
        name: index for index, name in enumerate(sorted({clip for agent in agents for clip in agent.results.clips}))
    }


def _plain(value: Any) -> Any:
    """The value, None instead of a number that is not finite."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _joined(parts: Sequence[NDArray[Any]], kind: type) -> NDArray[Any]:
    return np.concatenate(parts).astype(kind) if parts else np.zeros(0, dtype=kind)
