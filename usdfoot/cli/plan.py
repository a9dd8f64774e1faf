"""usdfoot plan: where footsteps come from; one verb below it for each way."""

from __future__ import annotations

import argparse
from types import ModuleType

from usdfoot.cli import (
    plan_crowd,
    plan_lint,
    plan_path,
    plan_scenario,
    plan_stones,
    plan_timing,
    plan_trajectories,
    plan_wander,
)
from usdfoot.cli.verbs import add_verb

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "PLANNERS", "add_arguments"]

NAME = "plan"
HELP = "make footstep plans, or check them"
DESCRIPTION = "Makes footstep plans and writes them as a layer to sublayer over the scene, or checks plans."
EPILOG = """\
example:
  usdfoot plan path city.usda -o plans.usda
  usdfoot plan lint plans.usda

each verb explains itself: usdfoot plan path --help
"""
PLANNERS: tuple[ModuleType, ...] = (
    plan_path,
    plan_trajectories,
    plan_crowd,
    plan_wander,
    plan_stones,
    plan_scenario,
    plan_timing,
    plan_lint,
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verbs below."""
    verbs = parser.add_subparsers(title="verbs", required=True, metavar="WAY")
    for planner in PLANNERS:
        add_verb(verbs, planner)
