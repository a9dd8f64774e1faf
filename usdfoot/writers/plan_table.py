"""CSV plans: a row a footstep, for spreadsheets and scripts (`bridge/plan_columns.py`)."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from usdfoot.bridge.plan_columns import PlanColumn as Column
from usdfoot.errors import OutputError
from usdfoot.model.biped import SIDES
from usdfoot.model.plan import FootstepPlan
from usdfoot.writers.staging import staged_files

__all__ = ["write_plan_table"]

LEVEL = 1e-3
"""Normals of the ground nearer to upward than this are not written [rad]."""


def write_plan_table(
    file: str | os.PathLike[str], plans: Mapping[str, FootstepPlan], *, source: str | os.PathLike[str] = ""
) -> Path:
    """Write plans, by name, as a CSV file; columns that would say nothing are left out.

    Args:
        file: .csv to write, replaced if it exists.
        plans: At least one, in the canonical world.
        source: File that must not be replaced.

    Raises:
        OutputError: If the file's name is no CSV file's, is the source's, or it cannot be written.
    """
    target = Path(os.path.realpath(file))
    if target.suffix.lower() != ".csv":
        raise OutputError(file, "is no name of a CSV file", "name a file that ends in .csv")
    if source and target == Path(os.path.realpath(source)):
        raise OutputError(file, "is the file that is read", "name another file")
    tilted = any((np.arccos(np.clip(plan.normals[:, 1], -1.0, 1.0)) > LEVEL).any() for plan in plans.values())
    optional = {
        Column.PLAN: len(plans) > 1,
        Column.STYLE: any(any(plan.styles) for plan in plans.values()),
        Column.ROOT_WEIGHT: any(plan.root_weights.any() for plan in plans.values()),
        **dict.fromkeys(Column.NORMAL, tilted),
    }
    columns = [name for name in Column.ALL if optional.get(name, True)]
    text = io.StringIO()
    table = csv.DictWriter(text, columns, extrasaction="ignore", lineterminator="\n")
    table.writeheader()
    for name, plan in plans.items():
        table.writerows(_rows(name, plan))
    with staged_files(target.parent) as files:
        files.add_text(target.name, text.getvalue())
    return target


def _rows(name: str, plan: FootstepPlan) -> Iterator[dict[str, str]]:
    """Cells by column, of each footstep."""
    for index in range(len(plan)):
        numbers = {
            **dict(zip(Column.POSITION, plan.positions[index], strict=True)),
            **dict(zip(Column.NORMAL, plan.normals[index], strict=True)),
            Column.YAW: np.degrees(plan.yaws[index]),
            Column.STRIKE: plan.strike_times[index],
            Column.LIFTOFF: plan.liftoff_times[index],
            Column.ROOT_WEIGHT: plan.root_weights[index],
        }
        words = {
            Column.PLAN: name,
            Column.FOOT: SIDES[int(plan.sides[index])],
            Column.STYLE: plan.styles[index] if plan.styles else "",
        }
        yield words | {column: f"{value:.9g}" for column, value in numbers.items()}
