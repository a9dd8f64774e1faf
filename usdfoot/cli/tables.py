"""Tables of results."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text

    from usdfoot.analysis.summary import ClipSummary
    from usdfoot.model.coverage import EmptyCircle, SpaceCoverage
    from usdfoot.model.motion import StepResults
    from usdfoot.model.plan import FootstepPlan
    from usdfoot.model.totals import StepTotals
    from usdfoot.pipeline.doctor import Symptom
    from usdfoot.pipeline.validate import AgentFigures, Figure
    from usdfoot.planning.faults import Fault
    from usdfoot.retarget.clips import RetargetedClip

__all__ = [
    "clip_table",
    "coverage_table",
    "empty_lines",
    "fault_table",
    "figure_table",
    "plan_table",
    "retarget_table",
    "step_table",
    "symptom_table",
    "target_table",
    "unpromised_table",
]

MOST_ROWS = 40
"""Agents listed at most; the total covers all."""
LEAST_SPEED = 0.005
"""A slower clip goes nowhere: the direction of its travel is chance [m/s]."""
MOST_CIRCLES = 10
"""Places where no step lands at most."""
MOST_NOTES = 3
"""Notes on a clip at most."""


def clip_table(summaries: Sequence[ClipSummary]) -> Table:
    """What every clip contains."""
    figures = ("steps", "speed m/s", "direction deg", "turn deg/s", "step length m", "on the ground")
    table = _table("clips", "clip", "style", figures=figures)
    table.add_column("notes")
    for summary in summaries:
        lengths = summary.step_lengths
        notes = [*(["in place"] if summary.in_place else []), *(["loop"] if summary.period else []), *summary.warnings]
        if len(notes) > MOST_NOTES:
            notes = [*notes[:MOST_NOTES], f"and {len(notes) - MOST_NOTES} more"]
        table.add_row(
            summary.name.rsplit("/", 1)[-1],
            summary.style,
            str(summary.steps),
            _number(summary.speed, 2),
            _number(math.degrees(summary.direction) if summary.speed >= LEAST_SPEED else math.nan, 0),
            _number(math.degrees(summary.turn_rate), 0),
            f"{lengths.min():.2f} to {lengths.max():.2f}" if lengths.size else "-",
            _number(100.0 * summary.duty_factor, 0) + (" %" if math.isfinite(summary.duty_factor) else ""),
            "\n".join(notes),
        )
    return table


def coverage_table(spaces: Sequence[SpaceCoverage]) -> Table:
    """Where steps land, and the error to expect."""
    import numpy as np

    from usdfoot.model.biped import SIDES

    figures = ("steps", "to the left m", "ahead m", "expected error cm", "worst cm")
    table = _table("coverage", "skeleton", "style", "gait", "foot", figures=figures)
    for space in spaces[:MOST_ROWS]:
        low, high = space.landings.min(axis=0), space.landings.max(axis=0)
        known = space.errors[np.isfinite(space.errors)]
        table.add_row(
            space.skeleton,
            space.style,
            "flight" if space.flight else "ground",
            SIDES[space.side],
            str(space.steps),
            f"{low[0]:.2f} to {high[0]:.2f}",
            f"{low[1]:.2f} to {high[1]:.2f}",
            _number(100.0 * float(known.mean()) if known.size else math.nan, 1),
            _number(100.0 * float(known.max()) if known.size else math.nan, 1),
        )
    return _counted(table, len(spaces))


def empty_lines(spaces: Sequence[SpaceCoverage]) -> list[str]:
    """The largest places where no step lands, largest first; mirror images are one."""
    from usdfoot.model.biped import SIDES

    circles = sorted(
        ((circle, space) for space in spaces for circle in space.empty_circles), key=lambda pair: -pair[0].radius
    )
    images: dict[object, list[tuple[EmptyCircle, SpaceCoverage]]] = {}
    for circle, space in circles:
        x, z = (round(value, 6) + 0.0 for value in circle.place.tolist())
        outward = x if space.side == 0 else -x
        images.setdefault((space.skeleton, space.style, space.flight, outward, z), []).append((circle, space))
    lines = []
    for (circle, space), *others in list(images.values())[:MOST_CIRCLES]:
        feet = f"{SIDES[space.side]} foot" + (f", mirrored the {SIDES[others[0][1].side]} one" if others else "")
        gait = f"{space.style}, with flight" if space.flight else space.style
        error = f"expected error {100.0 * circle.expected_error:.0f} cm"
        lines.append(
            f"no step lands near x={circle.place[0]:.2f}, z={circle.place[1]:.2f} ({feet}; {gait}): "
            f"nearest example {circle.radius:.2f} m, {error if circle.inside else 'outside what can be blended'}"
        )
    return lines


def fault_table(faults: Sequence[Fault]) -> Table:
    """What is wrong with plans."""
    table = _table("faults", "plan", figures=("footstep",))
    for heading in ("fault", "severity", "what"):
        table.add_column(heading)
    for fault in faults[:MOST_ROWS]:
        number = "" if fault.footstep < 0 else str(fault.footstep)
        table.add_row(fault.plan, number, fault.kind, fault.severity, fault.message)
    return _counted(table, len(faults))


def symptom_table(symptoms: Sequence[Symptom]) -> Table:
    """What usdfoot runs on, and what to do about what is missing."""
    table = _table("usdfoot doctor", figures=())
    for heading in ("what", "state", "found", "what to do"):
        table.add_column(heading, overflow="fold")
    for symptom in symptoms:
        texts = (symptom.name, symptom.state, symptom.told, symptom.remedy)
        table.add_row(*texts)
    return table


def plan_table(plans: Mapping[str, FootstepPlan]) -> Table:
    """How many footsteps the plans have, how long they take and how far they go."""
    import numpy as np

    table = _table("plans", "plan", figures=("footsteps", "from s", "to s", "length m", "mean step m", "climb m"))
    for name, plan in list(plans.items())[:MOST_ROWS]:
        lengths = np.linalg.norm(np.diff(plan.positions[:, [0, 2]], axis=0), axis=1)
        rises = np.diff(plan.positions[:, 1])
        table.add_row(
            name,
            str(len(plan)),
            f"{plan.strike_times[0]:.2f}",
            f"{plan.liftoff_times.max():.2f}",
            f"{lengths.sum():.2f}",
            f"{lengths.mean():.2f}",
            f"{rises[rises > 0.0].sum():.2f}",
        )
    return _counted(table, len(plans))


def retarget_table(clips: Mapping[str, RetargetedClip]) -> Table:
    """How clips fare on another character."""
    table = _table("retargeted clips", "clip", figures=("samples", "contacts", "slide mm", "pelvis lowered mm"))
    for name, result in clips.items():
        contacts = sum(len(result.contacts[side].strike_times) for side in (0, 1))
        samples = str(len(result.clip.rotations))
        table.add_row(name, samples, str(contacts), _number(1e3 * result.slide, 2), _number(1e3 * result.lowered, 0))
    return table


def step_table(results: Mapping[str, StepResults], totals: StepTotals) -> Table:
    """Errors of the steps of every agent, and of all."""
    from usdfoot.model.totals import sum_results

    figures = (
        "steps",
        "ok",
        "blend mean mm",
        "placement mean mm",
        "worst mm",
        "slide mm",
        "yaw deg",
        "outside hull mm",
        "root velocity m/s",
    )
    table = _table("steps", "agent", figures=figures)
    for name in list(results)[:MOST_ROWS]:
        table.add_row(name, *_step_figures(sum_results(results[name])))
    _counted(table, len(results))
    if len(results) > 1:
        table.add_section()
        table.add_row("all", *_step_figures(totals))
    return table


def _step_figures(totals: StepTotals) -> list[str]:
    """How many steps there are and are kept, and the errors of those that are."""

    def shown(name: str, scale: float, *, worst: bool = False) -> str:
        figure = totals.figures[name]
        return f"{scale * (figure.most if worst else figure.mean):.3f}" if figure.steps else "-"

    return [
        str(totals.steps),
        str(totals.promised),
        shown("blend_error", 1e3),
        shown("placement_error", 1e3),
        shown("placement_error", 1e3, worst=True),
        shown("slide", 1e3, worst=True),
        shown("yaw_error", 1.0, worst=True),
        shown("hull_distance", 1e3, worst=True),
        shown("root_velocity_error", 1.0),
    ]


def figure_table(agents: Sequence[AgentFigures]) -> Table:
    """Every figure of every agent; those over their target are marked."""
    figures = agents[0].figures if agents else ()
    table = _table(
        "agents", "agent", figures=["steps", *(f"{figure.name} {figure.unit}".strip() for figure in figures)]
    )
    ordered = sorted(agents, key=lambda agent: all(figure.passed for figure in agent.figures))
    for agent in ordered[:MOST_ROWS]:
        table.add_row(agent.name, str(agent.steps), *(_value(figure) for figure in agent.figures))
    return _counted(table, len(agents))


def target_table(total: AgentFigures) -> Table:
    """Figures of the whole crowd beside their targets."""
    table = _table("total", "figure", figures=("measured", "target"))
    table.add_column("")
    for figure in total.figures:
        sign = ">=" if figure.at_least else "<="
        target = f"{sign} {figure.target:g} {figure.unit}".strip()
        table.add_row(figure.name, _value(figure), target, "ok" if figure.passed else "OVER")
    return table


def unpromised_table(agents: Sequence[AgentFigures]) -> Table:
    """Footsteps whose placement is not promised, with their distance."""
    table = _table("footsteps without a promise", "agent", figures=("footstep",))
    table.add_column("status")
    table.add_column("placement error mm", justify="right")
    rows = [(agent.name, *step) for agent in agents for step in agent.unpromised]
    for name, step, status, error in rows[:MOST_ROWS]:
        table.add_row(name, str(step), status, f"{1e3 * error:.2f}")
    return _counted(table, len(rows))


def _table(title: str, *headings: str, figures: Sequence[str]) -> Table:
    """A table with columns of words, then of figures."""
    from rich.table import Table

    table = Table(title=title)
    for heading in headings:
        table.add_column(heading)
    for heading in figures:
        table.add_column(heading, justify="right")
    return table


def _counted(table: Table, count: int) -> Table:
    """The table with a row that says how many of `count` are not listed."""
    if count > MOST_ROWS:
        table.add_row(f"and {count - MOST_ROWS} more")
    return table


def _value(figure: Figure) -> Text:
    from rich.text import Text

    if not math.isfinite(figure.value):
        return Text("-")
    text = f"{figure.value:.3g}"
    return Text(text) if figure.passed else Text(f"{text} !", style="bold red")


def _number(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:.{digits}f}" if math.isfinite(value) else "-"
