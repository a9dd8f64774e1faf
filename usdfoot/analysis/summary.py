"""Summary of clips: what `usdfoot analyze` prints of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.motion import partial_kinematics
from usdfoot.analysis.steps import Step, cut_steps
from usdfoot.analysis.world import WorldClip, listed_contacts, world_clips
from usdfoot.errors import ClipError
from usdfoot.maths import planar
from usdfoot.maths.types import FloatArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.contacts import Contacts

__all__ = ["ClipSummary", "summarise"]


@dataclass(frozen=True, kw_only=True)
class ClipSummary:
    """What a clip shows in its range, in its own proportions; NaN where it has no steps."""

    name: str
    """Prim path of the SkelAnimation."""
    style: str
    contacts: Contacts | None
    """Contacts as `listed_contacts` lists them; None if they could not be found."""
    steps: int
    """Steps that can be used."""
    speed: float
    """Of the pelvis over the ground [m/s]."""
    direction: float
    """Of travel against the facing direction, positive to the left [rad]."""
    turn_rate: float
    """Change of heading in time, positive to the left [rad/s]."""
    step_lengths: FloatArray
    """From the ball of the support foot to where the swing foot's ball lands, over the ground [m], shape (steps,)."""
    root_height: float
    """Mean height of the pelvis above the ground the feet stand on [leg lengths]."""
    leg_length: float
    """Hip to ankle with the knee straight [m]."""
    duty_factor: float
    """Part of a stride for which a foot stands; below 0.5 there is flight."""
    period: float | None
    """Duration of a cycle [s]; None if the clip is no loop."""
    in_place: bool
    """Whether the clip runs in place, its travel restored here."""
    warnings: tuple[str, ...]
    """Steps that cannot be used, and why; or why the clip cannot."""


def summarise(library: ClipLibrary) -> tuple[ClipSummary, ...]:
    """Summaries of all clips of a library, in its order."""
    summaries = []
    worlds = world_clips(library.clips, library.skeleton, library.biped)
    for clip, world in zip(library.clips, worlds, strict=True):
        if isinstance(world, ClipError):
            summaries.append(_unusable(clip.name, clip.style, str(world)))
            continue
        steps, warnings = cut_steps(world)
        summaries.append(_summary(library, world, steps, warnings))
    return tuple(summaries)


def _summary(library: ClipLibrary, world: WorldClip, steps: tuple[Step, ...], warnings: tuple[str, ...]) -> ClipSummary:
    lengths = np.array([_length(world, step) for step in steps])
    speed, direction, turn_rate = _pace(library, world, steps) if steps else (np.nan, np.nan, np.nan)
    return ClipSummary(
        name=world.clip.name,
        style=world.clip.style,
        contacts=listed_contacts(world),
        steps=len(steps),
        speed=speed,
        direction=direction,
        turn_rate=turn_rate,
        step_lengths=lengths,
        root_height=_root_height(world),
        leg_length=world.leg_length,
        duty_factor=_duty_factor(world.contacts),
        period=world.period,
        in_place=world.root_motion.in_place,
        warnings=warnings if steps else (*warnings, "no usable step in its range"),
    )


def _length(world: WorldClip, step: Step) -> float:
    """Distance over the ground from the support ball to the landing [m]."""
    support = world.contacts[1 - step.swing_side].positions[step.support]
    landing = world.contacts[step.swing_side].positions[step.landing]
    return float(np.linalg.norm((landing - support)[[0, 2]]))


def _pace(library: ClipLibrary, world: WorldClip, steps: tuple[Step, ...]) -> tuple[float, float, float]:
    """Speed [m/s], direction against the heading [rad] and turn rate [rad/s], mean over the steps' time."""
    pelvis = partial_kinematics(library.skeleton, world.clip, np.array([library.biped.pelvis]))[0][:, 0]
    starts, ends = np.array([step.start for step in steps]), np.array([step.end for step in steps])
    places = [np.stack([np.interp(t, world.clip.times, pelvis[:, i]) for i in (0, 2)], axis=1) for t in (starts, ends)]
    travel = places[1] - places[0]
    yaws = np.array([_yaws(world, step) for step in steps])  # departure, support, landing
    headings = planar.circular_mean(yaws[:, :2])
    velocity = planar.rotate(-headings, travel).sum(axis=0) / np.sum(ends - starts)
    turn = np.sum(0.5 * planar.wrap_angle(yaws[:, 2] - yaws[:, 0]))
    return float(np.linalg.norm(velocity)), float(planar.yaw_of(velocity)), float(turn / np.sum(ends - starts))


def _yaws(world: WorldClip, step: Step) -> tuple[float, float, float]:
    """Direction of the departing, the supporting and the landed foot [rad]."""
    swing, support = world.contacts[step.swing_side], world.contacts[1 - step.swing_side]
    return float(swing.yaws[step.departure]), float(support.yaws[step.support]), float(swing.yaws[step.landing])


def _root_height(world: WorldClip) -> float:
    """Mean height of the pelvis in the clip's range above the middle height of the contacts [leg lengths]."""
    inside = (world.clip.times >= world.start) & (world.clip.times <= world.end)
    grounds = np.concatenate([world.contacts[side].positions[:, 1] for side in range(2)])
    if not grounds.size:
        return float("nan")
    return float((world.pelvis_positions[inside, 1].mean() - np.median(grounds)) / world.leg_length)


def _duty_factor(contacts: Contacts) -> float:
    """Mean part of its stride for which a foot stands, over all whole strides."""
    parts = []
    for side in range(2):
        foot = contacts[side]
        strides = np.diff(foot.strike_times)
        whole = np.isfinite(strides)
        parts.append((foot.liftoff_times - foot.strike_times)[:-1][whole] / strides[whole])
    joined = np.concatenate(parts)
    return float(joined.mean()) if joined.size else float("nan")


def _unusable(name: str, style: str, reason: str) -> ClipSummary:
    return ClipSummary(
        name=name,
        style=style,
        contacts=None,
        steps=0,
        speed=float("nan"),
        direction=float("nan"),
        turn_rate=float("nan"),
        step_lengths=np.zeros(0),
        root_height=float("nan"),
        leg_length=float("nan"),
        duty_factor=float("nan"),
        period=None,
        in_place=False,
        warnings=(reason,),
    )
