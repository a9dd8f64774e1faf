"""Page: a written crowd as one self-contained web page to look at."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from usdfoot.bridge.tokens import File
from usdfoot.errors import SceneError
from usdfoot.model.report import Outcome, Problem
from usdfoot.pipeline.page_agents import SeenAgent, see_agents
from usdfoot.pipeline.page_figures import ELSEWHERE, page_figures, whole_values
from usdfoot.pipeline.validate import figures_of, read_sources
from usdfoot.readers.written import WrittenCrowd, agent_names, read_written_crowd
from usdfoot.writers.page.document import check_page, write_document
from usdfoot.writers.page.ground import GroundPicture, picture_ground
from usdfoot.writers.page.pictures import AgentPicture, CrowdPicture
from usdfoot.writers.page.three import three_source

__all__ = ["PageReport", "picture_crowd", "write_page"]

FULL_RATE = 30.0
"""Frames a second that are enough to look at [1/s]."""
MOST_SAMPLES = 6_000_000
"""Joint positions in the page at most, as long as LEAST_RATE allows."""
LEAST_RATE = 6.0
"""Frames a second that a stick figure needs to be followed [1/s]."""


@dataclass(frozen=True, kw_only=True)
class PageReport(Outcome):
    """What was written."""

    file: Path
    agents: tuple[str, ...]
    """Names of the agents shown."""


def write_page(
    crowd_file: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    agents: str = "*",
    executor: Executor | None = None,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> PageReport:
    """Measure a written crowd and write the page.

    Args:
        crowd_file: A crowd.usd written by `usdfoot animate`.
        output: The HTML file.
        agents: Glob on the agents' names.
        executor: Whose workers measure many agents; None = this process does.
        progress: Told what goes on, how much of it is done, and of how much: "measure", "write".

    Raises:
        SceneError: If the crowd cannot be opened or no agent can be shown.
        OutputError: If the page cannot be written.
        UsdfootError: If three.js is not installed.
    """
    check_page(Path(output))  # both before minutes of measuring
    three_source()
    picture, problems = picture_crowd(crowd_file, agents=agents, executor=executor, progress=progress)
    progress("write", 0, 0)
    write_document(Path(output), picture)
    return PageReport(file=Path(output), agents=tuple(agent.name for agent in picture.agents), problems=problems)


def picture_crowd(
    crowd_file: str | os.PathLike[str],
    *,
    agents: str = "*",
    executor: Executor | None = None,
    progress: Callable[[str, int, int], None] = lambda stage, done, total: None,
) -> tuple[CrowdPicture, tuple[Problem, ...]]:
    """All that the page shows of a written crowd, measured as `validate` does, and the agents that cannot be shown.

    Arguments and errors are those of `write_page`.
    """
    crowd = read_written_crowd(crowd_file)
    report = _read_report(crowd.folder / File.REPORT)
    names = [name for name in agent_names(crowd) if fnmatchcase(name, agents)]
    outcomes = list(see_agents(crowd, names, crowd_file=crowd_file, executor=executor, progress=progress))
    problems = tuple(outcome for outcome in outcomes if isinstance(outcome, Problem))
    seen = [outcome for outcome in outcomes if isinstance(outcome, SeenAgent)]
    if not seen:
        reasons = "; ".join(str(problem) for problem in problems[:3])
        raise SceneError(crowd_file, f"has no agent to show that is named {agents}", reasons)
    sources = read_sources(crowd.folder / File.REPORT)
    total = figures_of([agent.measures for agent in seen], "total", sources)
    places = np.concatenate([part for agent in seen for part in (agent.picture.plan.positions, agent.picture.roots)])
    ground = picture_ground(crowd.terrain, places)
    rate = crowd.units.time_codes_per_second
    every = _frame_step([agent.picture for agent in seen], rate)
    recorded = [f"{problem['severity']}: {problem['message']}" for problem in report.get("problems", ())]
    picture = CrowdPicture(
        title=f"{crowd.folder.name}/{Path(crowd_file).name}",
        agents=tuple(_completed(seen, report, sources, every)),
        figures=page_figures(total),
        ground=ground,
        frame_time=every / rate,
        code_rate=rate,
        total=tuple({**asdict(figure), "passed": figure.passed} for figure in total.figures),
        problems=(*recorded, *(str(problem) for problem in problems)),
        notes=tuple(_notes(crowd, ground, every)),
        facts=_facts(crowd, report),
    )
    return picture, problems


def _frame_step(agents: Sequence[AgentPicture], rate: float) -> int:
    """Every how many frames one is kept: FULL_RATE, less where many agents would make a page too large to open."""
    samples = sum(agent.joints.shape[0] * agent.joints.shape[1] for agent in agents)
    wanted = max(rate / FULL_RATE, min(samples / MOST_SAMPLES, rate / LEAST_RATE))
    return max(1, int(np.ceil(wanted - 1e-6)))


def _completed(
    seen: Sequence[SeenAgent], report: Mapping[str, Any], sources: Mapping[str, Mapping[str, float]], every: int
) -> Iterator[AgentPicture]:
    """Every `every`-th frame of the agents, with what the report knows of them."""
    prims = {agent["name"]: agent.get("prim", "") for agent in report.get("agents", ())}
    for agent in seen:
        picture = agent.picture
        yield replace(
            picture,
            source=prims.get(picture.name, ""),
            whole=whole_values(figures_of([agent.measures], picture.name, sources)),
            times=picture.times[::every],
            roots=picture.roots[::every],
            joints=picture.joints[::every],
            sole_heights=picture.sole_heights[::every],
        )


def _notes(crowd: WrittenCrowd, ground: GroundPicture, every: int) -> list[str]:
    """What the page leaves out or simplifies."""
    rate = crowd.units.time_codes_per_second
    shown = "every frame" if every == 1 else f"every {every}th frame"
    notes = [
        f"Drawn is {shown} ({rate / every:g} a second), positions to 1 mm, straight lines between; the figures are"
        f" measured on all {rate:g} frames a second, the slide also between them, before that rounding.",
        "Limbs that reach less than a fifth of a leg from the joint they hang on are not drawn.",
    ]
    if ground.sampled:
        notes.append(f"The terrain is drawn from its heights on a grid of {100.0 * ground.sampled:.0f} cm.")
    if crowd.terrain is None:
        where = crowd.scene or "not recorded"
        notes.append(f"The scene was not found ({Path(where).name}): no terrain, penetration or clearance.")
    elif not len(ground.triangles):
        notes.append("The scene has no terrain here: the ground is the plane through the lowest footstep.")
    return [*notes, ELSEWHERE]


def _facts(crowd: WrittenCrowd, report: Mapping[str, Any]) -> dict[str, str]:
    """What the crowd was made from and with."""
    units = crowd.units
    facts = {
        "scene": str(report.get("scene", "")) or (Path(crowd.scene).name if crowd.scene else "not recorded"),
        "stage": f"{units.meters_per_unit:g} m a unit, {units.up_axis} up, {units.time_codes_per_second:g} codes/s",
        "page": "metres, seconds, Y up, whatever the stage's units",
    }
    versions = report.get("versions", {})
    if versions:
        facts["made with"] = ", ".join(f"{name} {version}" for name, version in versions.items())
    options = report.get("options")
    if options:
        facts["options"] = json.dumps(options, sort_keys=True)
    return facts


def _read_report(path: Path) -> dict[str, Any]:
    """report.json beside the crowd, empty if there is none to read."""
    try:
        report = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return report if isinstance(report, dict) else {}
