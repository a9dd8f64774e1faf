"""The footstep space each agent's current step is found in, with the blend weights ([B] Figure 4)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from usdfoot.errors import UsdfootError
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.overlay import Marks, Shape, ShownAgent
from usdfoot.model.report import Problem
from usdfoot.pipeline.overlay_shapes import bar, column
from usdfoot.pipeline.overlay_steps import SpaceRows, is_as_recorded, join_rows, space_rows, undrawn, weigh_again
from usdfoot.readers.written import WrittenCrowd

__all__ = ["draw_spaces", "mark_spaces"]

EDGE_COLOR, WEIGHT_COLOR = (0.05, 0.5, 0.15), (0.1, 0.7, 0.2)
EDGE_WIDTH, WEIGHT_RADIUS = 0.012, 0.015
CORNERS = 3
"""Of the triangle that is drawn: the heaviest examples."""


def draw_spaces(
    crowd: WrittenCrowd, shown: Sequence[ShownAgent], times: FloatArray, *, length: float
) -> tuple[tuple[Marks, ...], tuple[Problem, ...]]:
    """Triangulations under the agents, and why there is none for some.

    The steps are weighed again as they were when the crowd was made. Where that does not give the clips recorded, the
    scene has changed since, and nothing is drawn.

    Args:
        crowd: As read.
        shown: Agents to draw.
        times: Of the frames [s], shape (T,).
        length: Height of the column of an example that has all the weight [m].
    """
    recorded = {agent.name: agent.results for agent in shown if agent.results.clips}
    if not recorded:
        return (), ()
    if not crowd.scene:
        return (), (undrawn("the crowd", "does not name its scene"),)
    try:
        batches, problems = weigh_again(crowd, recorded)
    except UsdfootError as error:
        return (), (undrawn(crowd.scene, str(error)),)
    numbers = {agent.name: number for number, agent in enumerate(shown)}
    shapes: dict[tuple[int, int], Shape] = {}
    rows = []
    for batch in batches:
        fits = np.array([is_as_recorded(batch, row, recorded[agent.name]) for row, agent in enumerate(batch.agents)])
        for agent in (agent for agent, fit in zip(batch.agents, fits, strict=True) if not fit):
            problems.append(undrawn(agent.source, "has changed since the crowd was made"))
        owners = np.array([numbers[agent.name] for agent in batch.agents])
        rows.append(space_rows(batch, shapes, owners=owners, drawn=fits))
    whole = join_rows(rows)
    marks = mark_spaces(whole, tuple(shapes.values()), times, length=length) if len(whole.agents) else ()
    return marks, tuple(problems)


def mark_spaces(steps: SpaceRows, shapes: Sequence[Shape], times: FloatArray, *, length: float) -> tuple[Marks, ...]:
    """Each agent's space at times [s] (T,), a column on every blended example, and the edges between the heaviest.

    Args:
        steps: Of all agents.
        shapes: Triangulations that `steps.shapes` counts.
        times: Of the frames.
        length: Height of the column of an example that has all the weight [m].
    """
    agents = np.unique(steps.agents)
    rows, hidden = _current(steps, agents, times)
    places, turns = steps.places[rows], quaternion.yaw_quaternion(steps.headings[rows])
    ones = np.ones((*rows.shape, 3))
    spaces = _marks(
        "Space/Examples",
        shapes,
        times,
        kinds=steps.shapes[rows],
        positions=places,
        orientations=turns,
        scales=ones,
        hidden=hidden,
        agents=agents,
    )
    landings = planar.rotate(steps.headings[rows][..., None], steps.landings[rows])  # (T, A, K, 2)
    points = places[:, :, None] + np.insert(landings, 1, 0.0, axis=-1)
    weights = steps.weights[rows]
    radii = np.full_like(weights, WEIGHT_RADIUS)
    columns = _marks(
        "Space/Weights",
        [column("Weight", WEIGHT_COLOR)],
        times,
        kinds=np.zeros(weights.shape, dtype=int),
        positions=points,
        orientations=np.broadcast_to([0.0, 0.0, 0.0, 1.0], (*weights.shape, 4)),
        scales=np.stack([radii, np.maximum(length * weights, 1e-4), radii], axis=-1),
        hidden=hidden[..., None] | (weights <= 0.0),
        agents=agents,
    )
    return spaces, columns, _edges(points[:, :, :CORNERS], hidden, weights[..., :CORNERS], times, agents)


def _edges(corners: FloatArray, hidden: BoolArray, weights: FloatArray, times: FloatArray, agents: IntArray) -> Marks:
    """Bars between corners (T, A, C, 3) that have weight."""
    following = np.roll(corners, -1, axis=2) - corners
    lengths = np.linalg.norm(following, axis=-1)
    yaws = np.arctan2(-following[..., 2], following[..., 0])  # from +X, which bars lie along
    thick = np.full_like(lengths, EDGE_WIDTH)
    absent = (weights <= 0.0) | (np.roll(weights, -1, axis=2) <= 0.0) | (lengths < 1e-6)
    return _marks(
        "Space/Triangle",
        [bar("Edge", EDGE_COLOR)],
        times,
        kinds=np.zeros(lengths.shape, dtype=int),
        positions=corners,
        orientations=quaternion.yaw_quaternion(yaws),
        scales=np.stack([np.maximum(lengths, 1e-4), thick, thick], axis=-1),
        hidden=hidden[..., None] | absent,
        agents=agents,
    )


def _marks(
    path: str,
    shapes: Sequence[Shape],
    times: FloatArray,
    *,
    kinds: IntArray,
    positions: FloatArray,
    orientations: FloatArray,
    scales: FloatArray,
    hidden: BoolArray,
    agents: IntArray,
) -> Marks:
    """Marks of A agents, as many for each (T, A, ...), in one row (T, N)."""
    count = len(times)
    each = kinds[0].size // len(agents)
    return Marks(
        path=path,
        shapes=tuple(shapes),
        times=times,
        kinds=kinds.reshape(count, -1),
        positions=positions.reshape(count, -1, 3),
        orientations=orientations.reshape(count, -1, 4),
        scales=scales.reshape(count, -1, 3),
        hidden=hidden.reshape(count, -1),
        agents=np.repeat(agents, each),
        footsteps=np.full(len(agents) * each, -1),
    )


def _current(steps: SpaceRows, agents: IntArray, times: FloatArray) -> tuple[IntArray, BoolArray]:
    """The step that each of A agents is in, or was in last, and whether it is in none, shape (T, A) each."""
    span = float(max(steps.ends.max(), times.max()) - min(steps.begins.min(), times.min())) + 1.0
    keys = steps.agents * span + steps.begins
    first = np.searchsorted(steps.agents, agents)
    last = np.searchsorted(keys, agents * span + times[:, None] + 1e-6, side="right") - 1
    rows = np.maximum(last, first)
    return rows, (last < first) | (times[:, None] >= steps.ends[rows] - 1e-6)
