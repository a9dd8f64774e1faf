"""Motion: one agent's finished animation with the error of every step."""

from __future__ import annotations

from dataclasses import dataclass

from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.clip import ShapeTrack
from usdfoot.model.contacts import Contacts

__all__ = ["STATUSES", "ForceResults", "Motion", "StepResults"]

STATUSES = ("ok", "outsideHull", "rootWeighted", "ikLimited", "unreachable", "offTerrain")


@dataclass(frozen=True, kw_only=True)
class ForceResults:
    """What each step of a motion asks of physics ([P] 2.4.1), from its strike to the next, shape (N,) each."""

    force_imbalance: FloatArray
    """External force per unit mass that the motion needs, mean [m/s^2]."""
    clamp_time: FloatArray
    """Time in which standing legs would have to pull [s]."""
    jump_height: FloatArray
    """How far the centre of mass rises in the step's flight [m]."""


@dataclass(frozen=True, kw_only=True)
class StepResults:
    """Figures of every footstep of a plan (design.md section 3, UsdfootResultAPI), shape (N,) each."""

    blend_error: FloatArray
    """Blended landing to footstep, horizontal, before IK [m]."""
    placement_error: FloatArray
    """Ball to footstep after IK, horizontal, mean over the planted frames [m]; NaN, as slide and yaw, where none is."""
    slide: FloatArray
    """Largest distance between two positions of the ball over the planted frames [m]."""
    yaw_error: FloatArray
    """Foot direction to the footstep's at mid contact [rad]."""
    hull_distance: FloatArray
    """Landing to the hull of the footstep space, 0 inside [m]."""
    time_warp: FloatArray
    """Planned step duration over the blended one ([B] 5)."""
    root_weight: FloatArray
    """lambda4 as used."""
    beta: FloatArray
    """Largest lambda4 that still places the foot exactly ([B] 5)."""
    root_velocity_error: FloatArray
    """Mean root velocity of the blended clips, at their own pace, to the wanted one [m/s]."""
    status: tuple[str, ...]
    """One of STATUSES a step; where `placement_error` is NaN, what the step is to be, not measured."""
    clip_counts: IntArray
    """Number of clips blended in each step."""
    clips: tuple[str, ...]
    """Names of the clips blended, steps concatenated."""
    clip_weights: FloatArray
    """Their weights, shape (sum of clip_counts,)."""
    forces: ForceResults | None = None
    """Of motions that physics makes or carries."""


@dataclass(frozen=True, kw_only=True)
class Motion:
    """Samples of one agent in the canonical world.

    The agent's root carries the planar path; `pelvis_*` are relative to the root, canonical axes; the other joints
    are joint-local, with the skeleton's rest translations. Joints above the pelvis keep their rest transforms.
    """

    name: str
    """Agent's name."""
    times: FloatArray
    """Sample times [s], shape (F,)."""
    root_positions: FloatArray
    """On the ground [m], shape (F, 3)."""
    root_yaws: FloatArray
    """Heading [rad], continuous, shape (F,)."""
    pelvis_positions: FloatArray
    """In the agent's space [m], shape (F, 3)."""
    pelvis_rotations: FloatArray
    """In the agent's space, xyzw, shape (F, 4)."""
    rotations: FloatArray
    """Joint-local rotations xyzw (the pelvis's entry repeats `pelvis_rotations`), shape (F, J, 4)."""
    contacts: Contacts
    """As executed, positions in the world."""
    results: StepResults
    shapes: ShapeTrack | None = None
    """Blend shapes of the clips blended, if any has some."""
