"""Outcomes: what became of the footsteps of each take, as a table and as JSON."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from replaying.leave_out import ReplayErrors

__all__ = ["MEASURES", "Replay", "replay_json", "replay_table"]

MEASURES = ("pelvis_legs", "pelvis", "world_legs", "world", "pelvis_alone")
COLUMNS = ("blended", "filled", "nearest", "best", "own")

Middle = Callable[[Sequence[float]], float]


@dataclass(frozen=True, kw_only=True)
class Replay:
    """One take and what became of its footsteps."""

    clip: str
    kind: str
    """What the clip shows, from customData.kind; "" if it does not say."""
    steps: int
    blended: ReplayErrors
    """All other clips."""
    filled: ReplayErrors | None
    """All other clips and steps for the holes they leave, if asked for."""
    nearest: ReplayErrors | None
    """The other clip with the nearest steps; None where there is no other."""
    best: dict[str, float]
    """Smallest error of any other clip, by measure; chosen for each measure on its own."""
    own: ReplayErrors | None
    """The clip itself: what the engine adds; None where it has no usable step."""


def replay_table(replays: Sequence[Replay]) -> str:
    """Errors in centimetres by clip, by kind and in all."""
    columns = [name for name in COLUMNS if name != "filled" or any(replay.filled for replay in replays)]
    header, titles = f"{'[cm]':<42} {'steps':>5} {'out':>4}", "".join(f"{name:>8}" for name in columns)
    for title in ("from pelvis, legs", "from pelvis, all", "world, legs", "world, all", "world, pelvis"):
        header += f" | {title:^{len(titles)}}"
    lines = [header, " " * 53 + f" | {titles}" * len(MEASURES)]

    def row(label: str, steps: str, outside: str, members: Sequence[Replay], middle: Middle) -> str:
        each = [_values(member) for member in members]
        text = f"{label:<42} {steps:>5} {outside:>4}"
        for name in MEASURES:
            shown = (100.0 * middle([values[name][column] for values in each]) for column in columns)
            text += " | " + "".join(f"{value:8.2f}" for value in shown)
        return text

    for replay in replays:
        lines.append(row(replay.clip, str(replay.steps), str(replay.blended.outside), [replay], np.mean))
    groups = [(kind, [r for r in replays if r.kind == kind]) for kind in sorted({r.kind for r in replays}) if kind]
    for label, members in [*groups, ("all", list(replays))]:
        steps, outside = (
            str(sum(values)) for values in zip(*((m.steps, m.blended.outside) for m in members), strict=True)
        )
        for name, middle in (("mean", np.nanmean), ("median", np.nanmedian)):
            lines.append(row(f"{label} ({len(members)}), {name}", steps, outside, members, middle))
    return "\n".join(lines)


def _values(replay: Replay) -> dict[str, dict[str, float]]:
    """Errors by measure and column [m], not a number where there is none."""
    errors = {name: getattr(replay, name) for name in COLUMNS if name != "best"}
    return {
        measure: {
            column: replay.best[measure]
            if column == "best"
            else (getattr(errors[column], measure) if errors[column] else np.nan)
            for column in COLUMNS
        }
        for measure in MEASURES
    }


def replay_json(replay: Replay) -> dict[str, object]:
    """Errors in metres."""
    errors = {
        name: {column: None if np.isnan(value) else float(value) for column, value in values.items()}
        for name, values in _values(replay).items()
    }
    outside = {"outside": replay.blended.outside} | ({"filled_outside": replay.filled.outside} if replay.filled else {})
    return {"clip": replay.clip, "kind": replay.kind, "steps": replay.steps, **outside, **errors}
