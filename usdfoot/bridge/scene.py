"""Scene: what was read of a stage; Character: what the writers must know of an asset to reference and animate it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from usdfoot.bridge.own_attributes import OwnAttributes
from usdfoot.bridge.placements import Placement
from usdfoot.bridge.similarity import Similarity
from usdfoot.bridge.units import StageUnits
from usdfoot.maths.types import FloatArray, IntArray
from usdfoot.model.agent import Crowd
from usdfoot.model.biped import Biped
from usdfoot.model.skeleton import Pose, Skeleton

__all__ = ["BlendShapes", "Character", "Scene", "SkinBound", "StageInfo", "Variants", "Visibility"]

Visibility = tuple[tuple[float | None, str], ...]
"""Time codes, None = at all times, and USD's visibility from each on; empty = always inherited."""

Variants = tuple[tuple[str, str], ...]
"""Variant sets and what is selected in each, "" = nothing whatever the asset selects; sorted."""


@dataclass(frozen=True, kw_only=True)
class StageInfo:
    """Metadata of the stage read."""

    identifier: str
    """Root layer: a file path, or the identifier of a layer in memory."""
    units: StageUnits
    """Lengths, axes and times."""
    frames_per_second: float
    """Playback rate, only for viewers."""
    start_code: float
    """First time code: authored, else 0."""
    end_code: float
    """Last time code: authored, else 0."""
    layers: tuple[str, ...]
    """Files of all layers the stage uses, sorted; what the result depends on."""
    as_saved: bool = True
    """Whether these files say all: nothing of the stage is edited, hidden or left out in memory alone."""

    @property
    def start_time(self) -> float:
        """Time of the first time code [s]."""
        return float(self.units.codes_to_times(np.array(self.start_code)))


@dataclass(frozen=True, kw_only=True)
class BlendShapes:
    """Blend shapes of the animation a character is bound to, to be passed through."""

    names: tuple[str, ...]
    """Names, B of them."""
    codes: FloatArray
    """Time codes of the samples, shape (K,)."""
    weights: FloatArray
    """Shape (K, B)."""


@dataclass(frozen=True, kw_only=True)
class SkinBound:
    """A Skeleton of a character and how far its skin reaches beyond its joints, in USD's spaces and units."""

    parents: IntArray
    """Index of each joint's parent, -1 for roots, shape (K,)."""
    sources: IntArray
    """Joint of the character's animation that moves each joint, -1 for those that rest, shape (K,)."""
    rest_matrices: FloatArray
    """Joint-local rest transforms, row vectors, shape (K, 4, 4)."""
    to_prim: FloatArray
    """From the Skeleton to the character prim, row vectors, shape (4, 4)."""
    padding: float
    """Beyond the box of the joints on all sides [units of the character prim]."""


@dataclass(frozen=True, kw_only=True)
class Character:
    """An asset that agents reference, with its skeleton in the agent's space.

    The agent's space stands upright on the ground in canonical axes and metres. It is the space of the character prim
    after `agent_rotation` and `agent_scale`, which the transform of a written agent prim must therefore hold below
    the agent's position and yaw.
    """

    path: str
    """Prim of the character in the scene."""
    asset: str
    """Layer to reference: a file path, or the identifier of a layer in memory."""
    asset_prim: str
    """Prim path to reference in that layer."""
    variants: Variants = ()
    """What the scene selects of it; what it selects itself is not among these."""
    skeleton_path: str
    """Path of the Skeleton relative to the character prim, "" if it is the character prim itself."""
    agent_rotation: FloatArray
    """Rotation without yaw that stands the character prim upright, stage axes, xyzw, shape (4,)."""
    agent_scale: float
    """Scale the character prim has in the world."""
    skeleton_to_agent: Similarity
    """From the Skeleton's space [its units] to the agent's [m]; K = 1, or one a frame of the crowd if it moves."""
    skeleton: Skeleton
    """Canonical, in the agent's space, joints in the order of the USD Skeleton; joint scales folded in."""
    biped: Biped
    """Leg joints and foot heights."""
    rest_scales: FloatArray
    """Joint-local scales of the rest pose, what `scales` of a written animation must hold, shape (J, 3)."""
    inherited_scales: FloatArray
    """Product of the uniform scales of all joints above each: USD translation = canonical / it, shape (J,)."""
    bounds: tuple[SkinBound, ...]
    """What USD bounds the character by."""
    still_extent: FloatArray | None
    """Lowest and highest corner of the geometry that is not skinned, in the agent's space [m], shape (2, 3)."""
    bind_pose: Pose | None = None
    """Of the Skeleton in the agent's space, where it has one."""
    blend_shapes: BlendShapes | None = None
    """Of the animation the asset is bound to."""


@dataclass(frozen=True, kw_only=True)
class Scene:
    """A stage as read: the crowd for the engine, the rest for the writers."""

    stage: StageInfo
    """Units, range and layers."""
    crowd: Crowd
    """Agents, libraries and terrain."""
    characters: tuple[Character, ...]
    """What `Agent.character` counts."""
    frame_codes: FloatArray
    """Time codes of the crowd's frames, whole numbers, shape (F,)."""
    placements: Mapping[str, Placement] = field(default_factory=dict)
    """Of agents that artists placed, or whose plans they changed, by agent name."""
    visibility: Mapping[str, Visibility] = field(default_factory=dict)
    """Of agents that are not always to be seen, by agent name."""
    own_attributes: Mapping[str, OwnAttributes] = field(default_factory=dict)
    """Of agents that have some, by agent name."""
