"""Marks on footsteps: prints by status, columns of errors, feet that stand, timing daggers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.bridge.tokens import Status
from usdfoot.maths import quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.overlay import Marks, Shape, ShownAgent
from usdfoot.pipeline.overlay_shapes import bar, column, footprint
from usdfoot.writers.prints import PRINT_COLORS

__all__ = ["StepRows", "mark_contacts", "mark_errors", "mark_footsteps", "mark_timing", "tabulate_steps"]

STATUS_COLORS = {
    Status.OUTSIDE_HULL: (0.85, 0.75, 0.05),
    Status.ROOT_WEIGHTED: (0.45, 0.15, 0.7),
    Status.IK_LIMITED: (0.95, 0.2, 0.02),
    Status.UNREACHABLE: (0.6, 0.0, 0.02),
    Status.OFF_TERRAIN: (0.05, 0.05, 0.06),
}
"""Of footsteps that are not simply ok, linear RGB; those have the colours of plans."""
CONTACT_COLORS = ((0.1, 0.9, 0.95), (1.0, 0.85, 0.1))
BLEND_COLOR, PLACEMENT_COLOR = (0.85, 0.02, 0.02), (0.95, 0.45, 0.02)
BEYOND_COLOR = (0.02, 0.02, 0.02)
STANCE_COLOR, STEP_COLOR = (0.7, 0.03, 0.03), (0.12, 0.01, 0.01)
PRINT_LIFT, CONTACT_LIFT, DAGGER_LIFT = 0.008, 0.014, 0.02
"""Heights over the ground, one over the other, the first over the plan's own prints [m]."""
GLOW = 1.2
"""Size of a contact's print over that of the foot, so that it is seen around it."""
DISC = 0.003
"""Height of an error's column where there is next to none [m]."""
TALLEST = 2.5
"""Height at which columns end [m]."""
SIDES = ("Left", "Right")


@dataclass(frozen=True, kw_only=True)
class StepRows:
    """The N footsteps of all agents, each agent's in order of strike."""

    agents: IntArray
    footsteps: IntArray
    """Number within the agent's plan, shape (N,)."""
    sides: IntArray
    positions: FloatArray
    orientations: FloatArray
    strike_times: FloatArray
    liftoff_times: FloatArray
    step_times: FloatArray
    """Until the next foot comes down [s], NaN for the last footstep, shape (N,)."""
    sizes: FloatArray
    """From ankle to ball [m], shape (N,)."""
    status: tuple[str, ...]
    blend_error: FloatArray
    placement_error: FloatArray

    def over(self, lift: float) -> FloatArray:
        """Places `lift` [m] over the ground, along its normal, shape (N, 3)."""
        return self.positions + quaternion.rotate(self.orientations, np.array([0.0, lift, 0.0]))


def tabulate_steps(agents: Sequence[ShownAgent]) -> StepRows:
    """The footsteps of all agents, one a row."""
    plans = [agent.plan for agent in agents]
    counts = [len(plan) for plan in plans]
    return StepRows(
        agents=np.repeat(np.arange(len(agents)), counts),
        footsteps=np.concatenate([np.arange(count) for count in counts]),
        sides=np.concatenate([plan.sides for plan in plans]),
        positions=np.concatenate([plan.positions for plan in plans]),
        orientations=np.concatenate([plan.orientations for plan in plans]),
        strike_times=np.concatenate([plan.strike_times for plan in plans]),
        liftoff_times=np.concatenate([plan.liftoff_times for plan in plans]),
        step_times=np.concatenate([np.append(np.diff(plan.strike_times), np.nan) for plan in plans]),
        sizes=np.repeat([agent.foot_length for agent in agents], counts),
        status=tuple(status for agent in agents for status in agent.results.status),
        blend_error=np.concatenate([agent.results.blend_error for agent in agents]),
        placement_error=np.concatenate([agent.results.placement_error for agent in agents]),
    )


def mark_footsteps(steps: StepRows) -> Marks:
    """Prints in the colours of the plan; footsteps that are not simply ok in the colour of their status."""
    shapes = [footprint(name, side, PRINT_COLORS[side]) for side, name in enumerate(SIDES)]
    shapes += [
        footprint(f"{status[0].upper()}{status[1:]}{name}", side, color)
        for status, color in STATUS_COLORS.items()
        for side, name in enumerate(SIDES)
    ]
    numbers = {status: number for number, status in enumerate((Status.OK, *STATUS_COLORS))}
    return _still_marks(
        "Footsteps",
        shapes,
        agents=steps.agents,
        footsteps=steps.footsteps,
        kinds=2 * np.array([numbers.get(status, 0) for status in steps.status], dtype=int) + steps.sides,
        positions=steps.over(PRINT_LIFT),
        orientations=steps.orientations,
        scales=np.repeat(steps.sizes[:, None], 3, axis=1),
    )


def mark_errors(steps: StepRows, *, scale: float) -> tuple[Marks, Marks]:
    """Columns as high as `scale` times the blend error at the ball ([B] Fig. 8), and the placement error behind it.

    Those that would rise above TALLEST end there, in black.
    """
    behind = steps.positions + quaternion.rotate(steps.orientations, np.array([0.0, 0.0, -1.0]) * steps.sizes[:, None])
    upright = np.tile([0.0, 0.0, 0.0, 1.0], (len(steps.agents), 1))

    def columns(path: str, errors: FloatArray, places: FloatArray, color: tuple[float, float, float]) -> Marks:
        heights = np.maximum(scale * np.nan_to_num(errors), DISC)
        radii = 0.16 * steps.sizes
        return _still_marks(
            path,
            [column("Column", color), column("Beyond", BEYOND_COLOR)],
            agents=steps.agents,
            footsteps=steps.footsteps,
            kinds=(heights > TALLEST).astype(int),
            positions=places,
            orientations=upright,
            scales=np.stack([radii, np.minimum(heights, TALLEST), radii], axis=1),
            hidden=~np.isfinite(errors),
        )

    return (
        columns("Errors/Blend", steps.blend_error, steps.positions, BLEND_COLOR),
        columns("Errors/Placement", steps.placement_error, behind, PLACEMENT_COLOR),
    )


def mark_contacts(steps: StepRows, times: FloatArray) -> Marks:
    """The feet that stand, at times [s] (T,): a print for each foot of each agent, hidden while the foot is in the air.

    The print goes to its next place while it is hidden, at the first time after the strike.
    """
    tracks = 2 * steps.agents + steps.sides
    order = np.lexsort((steps.strike_times, tracks))
    span = float(max(steps.liftoff_times.max(), times.max()) - min(steps.strike_times.min(), times.min())) + 1.0
    keys = tracks[order] * span + steps.strike_times[order]
    wanted = np.arange(2 * (int(steps.agents.max()) + 1))
    last = np.searchsorted(keys, wanted * span + times[:, None] + 1e-6, side="right") - 1  # (T, 2 A)
    first = np.searchsorted(tracks[order], wanted)
    rows = order[np.maximum(last, first)]
    standing = (last >= first) & (times[:, None] <= steps.liftoff_times[rows] + 1e-6)
    jumps = np.zeros_like(standing)
    jumps[:-1] = (rows[1:] != rows[:-1]) & standing[1:]  # a swing between two times: do not slide over
    sizes = np.repeat(GLOW * steps.sizes[rows][..., None], 3, axis=-1)
    return Marks(
        path="Contacts",
        shapes=tuple(footprint(name, side, CONTACT_COLORS[side]) for side, name in enumerate(SIDES)),
        times=times,
        kinds=np.tile(wanted % 2, (len(times), 1)),
        positions=steps.over(CONTACT_LIFT)[rows],
        orientations=steps.orientations[rows],
        scales=sizes,
        hidden=~standing | jumps,
        agents=wanted // 2,
        footsteps=np.full(len(wanted), -1),
    )


def mark_timing(steps: StepRows, *, scale: float) -> Marks:
    """Daggers beside the prints: a bar as long as the foot stands, a crossbar when the next one strikes ([P] Fig. 3).

    Args:
        steps: Of all agents.
        scale: Length that stands for a second [m/s].
    """
    count = len(steps.agents)
    outward = np.where(steps.sides == 0, 0.0, np.pi)  # left is +X
    turned = quaternion.compose(steps.orientations, quaternion.yaw_quaternion(outward))
    begins = steps.over(DAGGER_LIFT) + quaternion.rotate(turned, np.array([0.45, 0.0, 0.0]) * steps.sizes[:, None])
    ahead = np.zeros((count, 3))
    ahead[:, 0] = scale * np.nan_to_num(steps.step_times)
    thick = 0.12 * steps.sizes
    stances = np.stack([scale * (steps.liftoff_times - steps.strike_times), thick, thick], axis=1)
    crossbars = np.stack([thick, thick, 0.9 * steps.sizes], axis=1)
    return _still_marks(
        "Timing",
        [bar("Stance", STANCE_COLOR), bar("Step", STEP_COLOR)],
        agents=np.tile(steps.agents, 2),
        footsteps=np.tile(steps.footsteps, 2),
        kinds=np.repeat([0, 1], count),
        positions=np.concatenate([begins, begins + quaternion.rotate(turned, ahead)]),
        orientations=np.concatenate([turned, turned]),
        scales=np.concatenate([stances, crossbars]),
        hidden=np.concatenate([np.zeros(count, dtype=bool), np.isnan(steps.step_times)]),
    )


def _still_marks(
    path: str,
    shapes: Sequence[Shape],
    *,
    agents: IntArray,
    footsteps: IntArray,
    kinds: IntArray,
    positions: FloatArray,
    orientations: FloatArray,
    scales: FloatArray,
    hidden: BoolArray | None = None,
) -> Marks:
    """Marks (N) that do not move, with the shapes they need."""
    shown = np.ones(len(kinds), dtype=bool) if hidden is None else ~hidden
    used, kinds = np.unique(kinds[shown], return_inverse=True)
    return Marks(
        path=path,
        shapes=tuple(shapes[kind] for kind in used),
        times=np.zeros(1),
        kinds=kinds[None],
        positions=positions[None, shown],
        orientations=orientations[None, shown],
        scales=scales[None, shown],
        hidden=np.zeros((1, int(shown.sum())), dtype=bool),
        agents=agents[shown],
        footsteps=footsteps[shown],
    )
