"""The pelvis that physics puts over a take's footsteps, against the one of the person who left them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise

import numpy as np

from replaying.takes import Take
from usdfoot.analysis.smoothness import body_joints
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.plan import FootstepPlan
from usdfoot.physics.biped import measure_biped
from usdfoot.physics.optimise import ComMotion, optimise_com
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.pelvis import hung_pelvises

__all__ = ["PelvisErrors", "pelvis_json", "pelvis_table", "replay_pelvises"]

WINDOW = 2.0
"""The pelvis's slow rise and fall, left out of the phase, is its mean over this many steps."""
FEWEST = 3
"""Other takes of which a line over the speed says anything."""
WALK_FLIGHT = 0.1
"""Part of a step."""
LARGEST_LAG = 0.25
"""Part of a step up to which the phase is searched."""


@dataclass(frozen=True, kw_only=True)
class PelvisErrors:
    """Physics pelvis against the real one, first strike to last strike."""

    rms: float
    """Root mean square distance [m]."""
    rms_centred: float
    """The same without the constant offset in the heading frame, which is posture [m]."""
    rms_carried: float
    """The same less the offset that other takes of the same gait say for its speed; not a number without three [m]."""
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
    """Errors of all takes of a library, their centres of mass optimised together."""
    if not takes:
        return []
    biped = measure_biped(library.skeleton, library.biped)
    motion = optimise_com([take.plan for take in takes], biped, options)
    joint = list(body_joints(library.skeleton, library.biped)).index(library.biped.pelvis)
    found = [_errors(motion, agent, take, take.positions[:, joint]) for agent, take in enumerate(takes)]
    offsets, speeds = np.array([offset for _, offset in found]), np.array([speed_ahead(take.plan) for take in takes])
    gaits = 2 * (speeds < 0.0) + np.array([flies(take.plan) for take in takes])
    apart = offsets - carried_offsets(offsets, speeds, gaits)
    return [
        replace(errors, rms_carried=float(np.sqrt(errors.rms_centred**2 + np.sum(own**2))))
        for (errors, _), own in zip(found, apart, strict=True)
    ]


def carried_offsets(offsets: FloatArray, speeds: FloatArray, gaits: IntArray) -> FloatArray:
    """How far off a body carries its pelvis by what its other takes of the same gait say [m], shape (A, 3).

    What is measured of the person, not of the take: straight lines over the speed of all takes but that one.

    Args:
        offsets: Mean of each take in its heading frame [m], shape (A, 3).
        speeds: [m/s], shape (A,).
        gaits: Takes with the same number are alike, shape (A,).
    """
    carried = np.full(offsets.shape, np.nan)
    for take in range(len(speeds)):
        others = np.flatnonzero((gaits == gaits[take]) & (np.arange(len(speeds)) != take))
        if len(others) >= FEWEST:
            lines = np.polynomial.polynomial.polyfit(speeds[others], offsets[others], 1)
            carried[take] = lines[0] + lines[1] * speeds[take]
    return carried


def speed_ahead(plan: FootstepPlan) -> float:
    """Mean speed of a plan in the direction its feet point [m/s]."""
    steps = np.diff(plan.positions[:, [0, 2]], axis=0)
    yaws = planar.yaw_of(quaternion.rotate(plan.orientations, np.array([0.0, 0.0, 1.0]))[:, [0, 2]])
    ahead = planar.direction(yaws[1:]) + planar.direction(yaws[:-1])
    return float(0.5 * np.sum(steps * ahead) / (plan.strike_times[-1] - plan.strike_times[0]))


def flies(plan: FootstepPlan) -> bool:
    """Whether most steps of a plan have a flight longer than those walks seem to have by their balls' contacts."""
    steps = np.diff(plan.strike_times)
    return bool(np.median((plan.strike_times[1:] - plan.liftoff_times[:-1]) / steps) > WALK_FLIGHT)


def _errors(motion: ComMotion, agent: int, take: Take, real: FloatArray) -> tuple[PelvisErrors, FloatArray]:
    """Errors of a take but those less other takes' offset, and its own offset in the heading frame [m], shape (3,)."""
    strikes = take.plan.strike_times
    times = np.arange(len(real)) / take.rate
    inside = (times >= strikes[0]) & (times <= strikes[-1])
    times, real = times[inside], real[inside]
    agents = np.full(len(times), agent)
    made = hung_pelvises(motion, agents, times, np.zeros(3))
    yaws = motion.footing.body_yaws(agents, times, window=motion.options.heading_window)
    apart = _in_heading(made - real, yaws)
    centred = apart - apart.mean(axis=0)
    step = float(np.median(np.diff(strikes)))
    errors = PelvisErrors(
        rms=_root_mean_square(apart),
        rms_centred=_root_mean_square(centred),
        rms_carried=float("nan"),
        lateral=_root_mean_square(apart[:, :1]),
        vertical=_root_mean_square(apart[:, 1:2]),
        forward=_root_mean_square(apart[:, 2:]),
        rise=_rise(times, made[:, 1], strikes),
        real_rise=_rise(times, real[:, 1], strikes),
        sway=_sway(times, made, yaws, strikes),
        real_sway=_sway(times, real, yaws, strikes),
        lag=_lag(made[:, 1], real[:, 1], round(step * take.rate)),
    )
    return errors, apart.mean(axis=0)


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
    titles = ("rms", "centred", "carried", "up", "left", "ahead", "rise", "real", "sway", "real", "lag")
    order = (
        "rms", "rms_centred", "rms_carried", "vertical", "lateral", "forward", "rise", "real_rise", "sway", "real_sway",
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
