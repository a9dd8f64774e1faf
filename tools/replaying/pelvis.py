"""The pelvis that physics puts over a take's footsteps, against the one of the person who left them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise

import numpy as np

from replaying.takes import Take
from usdfoot.analysis.smoothness import body_joints
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.physics.biped import measure_biped
from usdfoot.physics.carriage import (
    Carriage,
    PelvisTrack,
    carried_offsets,
    find_carried,
    fit_carriage,
    lay_carriage,
)
from usdfoot.physics.optimise import ComMotion, optimise_com
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.pelvis import hung_pelvises

__all__ = ["PelvisErrors", "pelvis_json", "pelvis_table", "replay_pelvises"]

WINDOW = 2.0
"""The pelvis's slow rise and fall, left out of the phase, is its mean over this many steps."""
LARGEST_LAG = 0.25
"""Part of a step up to which the phase is searched."""


@dataclass(frozen=True, kw_only=True)
class PelvisErrors:
    """Physics pelvis against the real one, first strike to last strike."""

    rms: float
    """Root mean square distance, the pelvis carried as all other clips of the library show [m]."""
    rms_centred: float
    """The same without the constant offset in the heading frame, which is posture [m]."""
    rms_average: float
    """As average people carry it, as if there were no clips [m]."""
    vertical: float
    lateral: float
    forward: float
    """Its parts, offset included, in the heading frame [m]."""
    rise: float
    real_rise: float
    """Vertical excursion within a step, mean over the steps [m]."""
    sway: float
    real_sway: float
    """Lateral excursion within a stride about the straight line from its begin to its end [m]."""
    lag: float
    """How much later the physics pelvis rises, parts of a step."""


def replay_pelvises(
    library: ClipLibrary, takes: Sequence[Take], options: PhysicsOptions | None = None
) -> list[PelvisErrors]:
    """Errors of all takes of a library, their centres of mass optimised together.

    Nothing of a take itself is known but its footsteps: its carriage is measured of the other takes.
    """
    if not takes:
        return []
    biped = measure_biped(library.skeleton, library.biped)
    motion = optimise_com([take.plan for take in takes], biped, options)
    joint = list(body_joints(library.skeleton, library.biped)).index(library.biped.pelvis)
    tracks = [
        PelvisTrack(times=np.arange(len(take.positions)) / take.rate, positions=take.positions[:, joint])
        for take in takes
    ]
    clips = find_carried(motion, tracks)
    found = []
    for agent, (take, track) in enumerate(zip(takes, tracks, strict=True)):
        carriage = fit_carriage(clips, without=agent)
        average = pelvis_errors(motion, agent, take, track)
        carried = average if carriage is None else pelvis_errors(motion, agent, take, track, carriage)
        found.append(replace(carried, rms_average=average.rms))
    return found


def pelvis_errors(
    motion: ComMotion, agent: int, take: Take, track: PelvisTrack, carriage: Carriage | None = None
) -> PelvisErrors:
    """Errors of an agent over a take's footsteps, carried as average people do or as other clips show."""
    strikes = take.plan.strike_times
    inside = (track.times >= strikes[0]) & (track.times <= strikes[-1])
    times, real = track.times[inside], track.positions[inside]
    agents = np.full(len(times), agent)
    yaws = motion.footing.body_yaws(agents, times, window=motion.options.heading_window)
    made = hung_pelvises(motion, agents=agents, times=times, offsets=np.zeros(3))
    if carriage is not None:
        values = lay_carriage(motion, carriage).at(agents, times)
        offsets = carried_offsets(values, motion.rhythm(agents, times, yaws))
        made = hung_pelvises(motion, agents=agents, times=times, offsets=offsets)
    apart = _in_heading(made - real, yaws)
    step = float(np.median(np.diff(strikes)))
    return PelvisErrors(
        rms=_root_mean_square(apart),
        rms_centred=_root_mean_square(apart - apart.mean(axis=0)),
        rms_average=_root_mean_square(apart),
        lateral=_root_mean_square(apart[:, :1]),
        vertical=_root_mean_square(apart[:, 1:2]),
        forward=_root_mean_square(apart[:, 2:]),
        rise=_rise(times, made[:, 1], strikes),
        real_rise=_rise(times, real[:, 1], strikes),
        sway=_sway(times, made, yaws, strikes),
        real_sway=_sway(times, real, yaws, strikes),
        lag=_lag(made[:, 1], real[:, 1], round(step * take.rate)),
    )


def _in_heading(vectors: FloatArray, yaws: FloatArray) -> FloatArray:
    """World vectors (F, 3) as left, up, ahead of the heading."""
    ground = planar.rotate(-yaws, vectors[:, [0, 2]])
    return np.column_stack([ground[:, 0], vectors[:, 1], ground[:, 1]])


def _root_mean_square(vectors: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))


def _rise(times: FloatArray, heights: FloatArray, strikes: FloatArray) -> float:
    spans = [heights[(times >= a) & (times <= b)] for a, b in pairwise(strikes)]
    return float(np.mean([np.ptp(span) for span in spans if len(span) > 2]))


def _sway(times: FloatArray, positions: FloatArray, yaws: FloatArray, strikes: FloatArray) -> float:
    sways = []
    for begin, end in zip(strikes[:-2], strikes[2:], strict=True):
        rows = np.flatnonzero((times >= begin) & (times <= end))
        if len(rows) > 2:
            share = np.linspace(0.0, 1.0, len(rows))[:, None]
            line = positions[rows[0]] + share * (positions[rows[-1]] - positions[rows[0]])
            sways.append(np.ptp(_in_heading(positions[rows] - line, yaws[rows])[:, 0]))
    return float(np.mean(sways)) if sways else float("nan")


def _lag(made: FloatArray, real: FloatArray, step: int) -> float:
    """Shift at which both heights go best together, parts of a step of `step` samples."""
    size = max(3, round(WINDOW * step))
    if len(made) < size:
        return float("nan")
    kernel = np.ones(size) / size
    first, second = (
        heights - np.convolve(np.pad(heights, size, mode="edge"), kernel, "same")[size:-size]
        for heights in (made, real)
    )
    shifts = range(-round(LARGEST_LAG * step), round(LARGEST_LAG * step) + 1)
    products = [np.mean((first * np.roll(second, shift))[abs(shift) : len(first) - abs(shift)]) for shift in shifts]
    return shifts[int(np.argmax(products))] / step


def pelvis_table(names: Sequence[str], kinds: Sequence[str], errors: Sequence[PelvisErrors]) -> str:
    """Errors in centimetres by clip, by kind and in all."""
    titles = ("rms", "centred", "average", "up", "left", "ahead", "rise", "real", "sway", "real", "lag")
    order = (
        "rms", "rms_centred", "rms_average", "vertical", "lateral", "forward", "rise", "real_rise", "sway", "real_sway",
        "lag",
    )  # fmt: skip
    lines = [f"{'pelvis [cm], lag [steps]':<42}" + "".join(f"{title:>8}" for title in titles)]

    def row(label: str, members: Sequence[PelvisErrors]) -> str:
        values = [_mean([getattr(member, name) for member in members]) for name in order]
        shown = [value if name == "lag" else 100.0 * value for name, value in zip(order, values, strict=True)]
        return f"{label:<42}" + "".join(f"{value:8.2f}" for value in shown)

    lines += [row(name, [each]) for name, each in zip(names, errors, strict=True)]
    for kind in sorted(set(kinds) - {""}):
        members = [each for each, own in zip(errors, kinds, strict=True) if own == kind]
        lines.append(row(f"{kind} ({len(members)}), mean", members))
    return "\n".join([*lines, row(f"all ({len(errors)}), mean", errors)])


def _mean(values: Sequence[float]) -> float:
    """Mean of the numbers among the values, not a number where there is none."""
    known = [value for value in values if not np.isnan(value)]
    return float(np.mean(known)) if known else float("nan")


def pelvis_json(errors: PelvisErrors) -> dict[str, float | None]:
    """Errors in metres by name."""
    values = {field.name: float(getattr(errors, field.name)) for field in fields(PelvisErrors)}
    return {name: None if np.isnan(value) else value for name, value in values.items()}
