"""Carriage: how one person carries the pelvis in walks, measured of its clips from where average people's would be.

No footprint tells it: who stoops has the pelvis behind the centre of mass, and some sway and surge more than others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from usdfoot.analysis.clip_plans import plan_of
from usdfoot.analysis.world import WorldClip, world_clips
from usdfoot.errors import PlanError
from usdfoot.maths import planar, quaternion
from usdfoot.maths.types import BoolArray, FloatArray, IntArray
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.plan import FootstepPlan
from usdfoot.physics.biped import PhysicsBiped
from usdfoot.physics.heading import heading_of
from usdfoot.physics.optimise import ComMotion, optimise_com
from usdfoot.physics.pelvis import hung_pelvises
from usdfoot.physics.posture import Posture, lay_posture
from usdfoot.physics.rhythm import Rhythm

__all__ = [
    "Carriage",
    "CarriedClips",
    "PelvisTrack",
    "carried_offsets",
    "find_carried",
    "fit_carriage",
    "lay_carriage",
    "measure_carriage",
]

VALUES = 5
"""Numbers of a carriage: pelvis to the left, up and ahead, sway to the standing leg, surge as the legs part [m]."""
FEWEST_FOOTSTEPS = 3
"""Of a clip that shows a stride."""
AVERAGE = 1.0
"""As many clips stand for average people: what few clips show may be chance."""
SLOWEST = 0.1
"""Slower clips, in parts of the speed at which a leg would leave the ground (Froude number 1), go nowhere or aside."""
QUIET = 1e-3
"""Signals that vary little say little: added to their variance."""
FARTHEST = 0.2
"""A pelvis farther off, in legs (root mean square), is no walk, or its footsteps were not found."""
STEADY = 0.1
"""Clips whose speeds spread little say little of how the carriage changes with speed: added to the sum of their squared
differences from the mean [m^2/s^2]."""


@dataclass(frozen=True, kw_only=True)
class Carriage:
    """A straight line over the speed ahead or back; who stands, stands as at rest."""

    slowest: float
    quickest: float
    """Speeds of the clips it was measured of [m/s]; beyond them it stays what it is, and below fades to rest."""
    speed: float
    """Their mean [m/s]."""
    values: FloatArray
    """At that speed [m], shape (VALUES,)."""
    slopes: FloatArray
    """[s], shape (VALUES,)."""

    def at(self, speeds: FloatArray) -> FloatArray:
        """At speeds (F,) [m/s], shape (F, VALUES) [m]."""
        known = np.clip(speeds, self.slowest, self.quickest)[:, None]
        fade = np.clip(speeds / max(self.slowest, 1e-6), 0.0, 1.0)[:, None]
        return fade * (self.values + (known - self.speed) * self.slopes)


@dataclass(frozen=True, kw_only=True)
class PelvisTrack:
    """A recorded pelvis."""

    times: FloatArray
    """[s], shape (T,)."""
    positions: FloatArray
    """World [m], shape (T, 3)."""


@dataclass(frozen=True, kw_only=True)
class CarriedClips:
    """What each of C clips shows of the carriage."""

    speeds: FloatArray
    """Mean speed ahead or back [m/s], shape (C,)."""
    values: FloatArray
    """[m], shape (C, VALUES)."""
    walks: BoolArray
    """Whether it walks ahead or back, shape (C,). In runs a strike 20 ms late moves the pelvis farther."""


def measure_carriage(library: ClipLibrary, biped: PhysicsBiped) -> Carriage | None:
    """How the person of a library carries the pelvis; None if no recorded clip of it walks.

    Args:
        library: Clips, of which synthetic ones count for nothing.
        biped: Measured on the library's skeleton.
    """
    recorded = [clip for clip in library.clips if not clip.synthetic]
    plans: list[FootstepPlan] = []
    tracks: list[PelvisTrack] = []
    for world in world_clips(recorded, library.skeleton, library.biped):
        if not isinstance(world, WorldClip):
            continue
        scale = library.biped.maximal_leg_length / world.leg_length
        try:
            plan = plan_of(world, scale=scale)
        except PlanError:
            continue
        if len(plan) >= FEWEST_FOOTSTEPS:
            plans.append(plan)
            times = world.clip.times - world.clip.times[0]
            tracks.append(PelvisTrack(times=times, positions=scale * world.pelvis_positions))
    return fit_carriage(find_carried(optimise_com(plans, biped), tracks)) if plans else None


def find_carried(com: ComMotion, tracks: Sequence[PelvisTrack]) -> CarriedClips:
    """What clips show over whose footsteps the motion was optimised, one an agent, from first to last strike."""
    speeds, values, walks = [], [], []
    for agent, track in enumerate(tracks):
        planned = np.flatnonzero((com.contacts.agents == agent) & (com.contacts.steps >= 0))
        begin, end = com.contacts.strikes[planned[[0, -1]]]
        inside = (track.times >= begin) & (track.times <= end)
        times, agents = track.times[inside], np.full(int(inside.sum()), agent)
        turns = com.evaluate(agents, times).orientations
        apart = track.positions[inside] - hung_pelvises(com, agents=agents, times=times, offsets=np.zeros(3))
        values.append(_values(quaternion.rotate(quaternion.inverse(turns), apart), _rhythm(com, agents, times)))
        speeds.append(abs(float(np.mean(_speeds_ahead(com, agents, times)))))
        length = com.biped.nominal_length
        travels = speeds[-1] > SLOWEST * np.sqrt(com.options.gravity * length)
        near = np.mean(np.sum(apart**2, axis=1)) < (FARTHEST * length) ** 2
        walks.append(bool(travels and near and np.mean(com.footing.run_shares(agents, times)) < 0.5))
    return CarriedClips(speeds=np.array(speeds), values=np.array(values), walks=np.array(walks))


def fit_carriage(clips: CarriedClips, *, without: int | None = None) -> Carriage | None:
    """The carriage of all walks among the clips but the one `without`; None if there is no other."""
    rows = np.flatnonzero(clips.walks & (np.arange(len(clips.speeds)) != without))
    if not rows.size:
        return None
    speeds, values = clips.speeds[rows], clips.values[rows]
    apart, mean = speeds - speeds.mean(), values.mean(axis=0)
    shrunk = len(rows) / (len(rows) + AVERAGE)
    return Carriage(
        slowest=float(speeds.min()),
        quickest=float(speeds.max()),
        speed=float(speeds.mean()),
        values=shrunk * mean,
        slopes=apart @ (values - mean) / (np.sum(apart**2) + STEADY),
    )


def lay_carriage(com: ComMotion, carriage: Carriage) -> Posture:
    """A carriage over the motions of all agents, by their speed; not in runs."""

    def values_at(agents: IntArray, times: FloatArray) -> FloatArray:
        speeds = np.abs(_speeds_ahead(com, agents, times))
        return (1.0 - com.footing.run_shares(agents, times))[:, None] * carriage.at(speeds)

    return lay_posture(com.contacts, values_at)


def carried_offsets(values: FloatArray, rhythm: Rhythm) -> FloatArray:
    """Where values (F, VALUES) of a carriage put the pelvis at a rhythm, in the body's frame [m], shape (F, 3)."""
    offsets = np.array(values[:, :3])
    offsets[:, 0] += values[:, 3] * rhythm.lean
    offsets[:, 2] += values[:, 4] * _parting(rhythm)
    return offsets


def _values(offsets: FloatArray, rhythm: Rhythm) -> FloatArray:
    """The values that fit offsets (T, 3) best, shape (VALUES,)."""
    left, sway = _line(rhythm.lean, offsets[:, 0])
    ahead, surge = _line(_parting(rhythm), offsets[:, 2])
    return np.array([left, offsets[:, 1].mean(), ahead, sway, surge])


def _line(signal: FloatArray, offsets: FloatArray) -> tuple[float, float]:
    """Offset where a signal (T,) is zero, and its rise with the signal."""
    rise = np.cov(signal, offsets, bias=True)[0, 1] / (np.var(signal) + QUIET)
    return float(offsets.mean() - rise * signal.mean()), float(rise)


def _parting(rhythm: Rhythm) -> FloatArray:
    """Once a step: the standing leg ahead of the other 1 early in its stance, -1 late, in legs, shape (F,)."""
    return rhythm.lean * rhythm.stride


def _rhythm(com: ComMotion, agents: IntArray, times: FloatArray) -> Rhythm:
    return com.rhythm(agents, times, heading_of(com.evaluate(agents, times).orientations))


def _speeds_ahead(com: ComMotion, agents: IntArray, times: FloatArray) -> FloatArray:
    """Speed in the direction of the heading [m/s], shape (F,)."""
    sample = com.evaluate(agents, times)
    return np.sum(sample.velocities[:, [0, 2]] * planar.direction(heading_of(sample.orientations)), axis=1)
