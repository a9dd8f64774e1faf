"""The figures of design.md section 10 as the page shows them: one value a footstep or an agent, beside its target."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from usdfoot.analysis.figures import frames_between, smallest_in_ranges
from usdfoot.maths.types import FloatArray
from usdfoot.model.motion import StepResults
from usdfoot.model.plan import FootstepPlan
from usdfoot.pipeline.measures import AgentMeasures
from usdfoot.pipeline.validate import AgentFigures
from usdfoot.writers.page.pictures import PageFigure

__all__ = ["ELSEWHERE", "frame_values", "page_figures", "step_values", "whole_values"]

TARGETS = {
    "placement": "placement worst",
    "slide": "slide",
    "subframeSlide": "slide in subframes",
    "heelSlide": "heel slide",
    "yaw": "yaw error",
    "timing": "timing faults",
    "clearance": "clearance",
    "blend": "blend error mean",
    "penetration": "lowest sole",
    "sole": "lowest sole",
    "knee": "knee speed / clips",
    "jerk": "joint jerk / clips",
    "seam": "seam jump / clips",
}
"""Figure of `validate` that has the target of each figure of the page."""

FIGURES = (
    PageFigure(
        key="placement",
        title="placement error",
        unit="mm",
        digits=3,
        meaning="Horizontal distance of the ball of the foot to its footstep, mean over the planted frames.",
    ),
    PageFigure(
        key="slide",
        title="slide",
        unit="mm",
        digits=3,
        meaning="Largest distance between two positions of the ball over the planted frames.",
    ),
    PageFigure(
        key="subframeSlide",
        title="slide between frames",
        unit="mm",
        digits=3,
        meaning="The same, with three subframes between each two planted frames.",
    ),
    PageFigure(
        key="heelSlide",
        title="heel slide",
        unit="mm",
        digits=3,
        meaning="Largest distance between two positions of the heel from strike to flat.",
    ),
    PageFigure(
        key="yaw",
        title="yaw error",
        unit="deg",
        digits=3,
        meaning="Angle between the foot's direction and the footstep's at mid contact.",
    ),
    PageFigure(
        key="clearance",
        title="clearance",
        unit="mm",
        digits=1,
        meaning="Lowest sole over the terrain in the middle 60 % of the swing to the footstep.",
    ),
    PageFigure(
        key="penetration",
        title="lowest sole in the contact",
        unit="mm",
        digits=3,
        meaning="Lowest height of the foot's ball or heel over the terrain from strike to liftoff.",
    ),
    PageFigure(
        key="timing",
        title="timing faults",
        unit="",
        digits=0,
        meaning="How many of three rules are broken: planted late, planted early, lifted late.",
    ),
    PageFigure(
        key="blend",
        title="blend error",
        unit="mm",
        digits=3,
        of_mean=True,
        meaning="Horizontal distance of the blended landing to the footstep before IK, as recorded; the target is the"
        " mean's, inside the hull.",
    ),
    PageFigure(
        key="hull",
        title="distance to the hull",
        unit="mm",
        digits=1,
        meaning="How far outside the clips' landings the footstep is, as recorded; 0 = inside.",
    ),
    PageFigure(
        key="velocity",
        title="root velocity error",
        unit="m/s",
        digits=3,
        meaning="Root velocity of the blended clips to the wanted one, as recorded; the target, 0.1 m/s, is for root"
        " weight 1.",
    ),
    PageFigure(
        key="warp",
        title="time warp",
        unit="x",
        digits=2,
        meaning="Planned duration of the step over that of the blended clips, as recorded.",
    ),
    PageFigure(
        key="excursion",
        title="pelvis excursion",
        unit="mm",
        digits=1,
        meaning="Range of the pelvis' height over the agent's ground from strike to strike; people's: 30 to 50 mm.",
    ),
    PageFigure(
        key="imbalance",
        title="force imbalance",
        unit="m/s2",
        digits=2,
        meaning="External force per unit mass that the motion needs, mean over the step, as recorded.",
    ),
    PageFigure(
        key="sole",
        title="lowest sole",
        unit="mm",
        digits=3,
        per_agent=True,
        meaning="Lowest height of a ball or heel of the agent over the terrain at any frame; below 0 it penetrates.",
    ),
    PageFigure(
        key="jerk",
        title="joint jerk / clips",
        unit="x",
        digits=2,
        per_agent=True,
        meaning="99th percentile of the joints' angular jerk over that of the source steps.",
    ),
    PageFigure(
        key="seam",
        title="seam jump / clips",
        unit="x",
        digits=2,
        per_agent=True,
        meaning="Largest jump of the joints' angular velocity at a strike over the clips' 99th percentile.",
    ),
    PageFigure(
        key="knee",
        title="knee speed / clips",
        unit="x",
        digits=2,
        per_agent=True,
        meaning="Largest angular speed of a knee over the clips' 99th percentile.",
    ),
)

ELSEWHERE = (
    "Replay, centre of mass against people, kernel, step set-up, end to end and centre-of-mass solve are figures of"
    " usdfoot, not of one crowd: BENCHMARKS.md has them."
)
"""What the page says of the other rows of section 10."""


def page_figures(total: AgentFigures) -> tuple[PageFigure, ...]:
    """All figures with the targets that `validate` compares with."""
    known = {figure.name: figure for figure in total.figures}
    chosen = []
    for figure in FIGURES:
        match = known.get(TARGETS.get(figure.key, ""))
        chosen.append(replace(figure, target=match.target, at_least=match.at_least) if match else figure)
    return tuple(chosen)


def step_values(measures: AgentMeasures, results: StepResults) -> dict[str, FloatArray]:
    """Values of the figures of footsteps in their units, by key, shape (N,) each."""
    missing = np.full(len(measures.promised), np.nan)
    return {
        "placement": 1e3 * measures.placement_error,
        "slide": 1e3 * measures.slide,
        "subframeSlide": 1e3 * measures.subframe_slide,
        "heelSlide": 1e3 * measures.heel_slide,
        "yaw": np.degrees(measures.yaw_error),
        "clearance": 1e3 * measures.clearance,
        "timing": measures.timing_faults.sum(axis=1).astype(float),
        "blend": 1e3 * results.blend_error,
        "hull": 1e3 * results.hull_distance,
        "velocity": results.root_velocity_error,
        "warp": results.time_warp,
        "imbalance": missing if results.forces is None else results.forces.force_imbalance,
    }


def frame_values(
    plan: FootstepPlan, times: FloatArray, *, pelvis_heights: FloatArray, sole_heights: FloatArray
) -> dict[str, FloatArray]:
    """Values of the figures of footsteps that are taken from the frames [mm], by key, shape (N,) each.

    Args:
        plan: As executed.
        times: Of the frames [s], shape (F,).
        pelvis_heights: Over the agent's ground [m], shape (F,).
        sole_heights: Of the lowest point of each sole over the terrain [m], NaN = not known, shape (F, 2).
    """
    contacts = frames_between(times, plan.strike_times, plan.liftoff_times)
    own = [smallest_in_ranges(sole_heights[:, side], contacts) for side in (0, 1)]
    steps = frames_between(times, plan.strike_times, np.append(plan.strike_times[1:], -np.inf)[: len(plan)])
    lowest, highest = smallest_in_ranges(pelvis_heights, steps), -smallest_in_ranges(-pelvis_heights, steps)
    return {"penetration": 1e3 * np.where(plan.sides == 0, *own), "excursion": 1e3 * (highest - lowest)}


def whole_values(figures: AgentFigures) -> dict[str, float]:
    """Values of the figures of agents in their units, by key."""
    known: Mapping[str, float] = {figure.name: figure.value for figure in figures.figures}
    return {figure.key: known[TARGETS[figure.key]] for figure in FIGURES if figure.per_agent}
