"""Plan scenario: a SteerSuite test case becomes a stage with agents, goals and obstacles."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from usdfoot import __version__
from usdfoot.errors import SceneError
from usdfoot.importers.steersuite import import_steersuite
from usdfoot.model.report import Problem
from usdfoot.planning.scenario import Scenario
from usdfoot.readers.stage import open_stage
from usdfoot.writers.scenario import write_scenario

__all__ = ["ScenarioReport", "convert_scenario"]


@dataclass(frozen=True, kw_only=True)
class ScenarioReport:
    """Outcome of one conversion."""

    file: Path
    """The stage written."""
    scenario: Scenario
    problems: tuple[Problem, ...]
    """What was odd or left out."""


def convert_scenario(
    file: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    seed: int = 0,
    character: str = "",
    clips: str = "",
) -> ScenarioReport:
    """Write a SteerSuite test case as a stage for `plan crowd`.

    Args:
        file: XML file.
        output: .usd, .usda or .usdc to write.
        seed: Of what the file leaves to chance; same seed, same bytes.
        character: USD file all agents reference as their character; empty = none.
        clips: USD file with their clips; empty = none.

    Raises:
        SceneError: If the XML is malformed; the line is named. If the character or the clips cannot be referenced.
        OutputError: If the stage cannot be written.
    """
    for asset in filter(None, (character, clips)):
        if not open_stage(asset).HasDefaultPrim():
            raise SceneError(asset, "has no defaultPrim that agents could reference", "author one")
    scenario, problems = import_steersuite(file, generator=np.random.default_rng(seed))
    provenance = {"version": __version__, "source": Path(file).name, "seed": seed}
    target = write_scenario(output, scenario, character=character, clips=clips, provenance=provenance)
    return ScenarioReport(file=target, scenario=scenario, problems=problems)
