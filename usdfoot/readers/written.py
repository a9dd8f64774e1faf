"""Written crowds: what UsdSkel makes of the files, back in canonical space, to be measured."""

from __future__ import annotations

import os
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdSkel

from usdfoot.bridge import tokens
from usdfoot.bridge.similarity import Similarity, similarity_of_matrices
from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError
from usdfoot.maths import quaternion
from usdfoot.maths.types import BoolArray, FloatArray
from usdfoot.model.biped import Biped
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.skeleton import Skeleton
from usdfoot.model.terrain import Terrain
from usdfoot.readers.authored import authored, targets
from usdfoot.readers.biped import read_biped
from usdfoot.readers.candidates import find_skeleton
from usdfoot.readers.plans import read_plan
from usdfoot.readers.skeleton import RawSkeleton, read_skeleton, skeleton_in
from usdfoot.readers.skins import read_skin
from usdfoot.readers.stage import collect_prims, open_stage, read_stage_info
from usdfoot.readers.terrain import read_terrain

__all__ = ["WrittenAgent", "WrittenCrowd", "agent_names", "read_agent", "read_agent_prim", "read_written_crowd"]

ON_SAMPLE = 1e-6
"""Time codes closer than this are the same."""


@dataclass(frozen=True, kw_only=True)
class WrittenAgent:
    """One agent of a written crowd."""

    name: str
    plan: FootstepPlan
    """As executed."""
    flat_times: FloatArray
    """Time each footstep's foot is flat, NaN where no contact tells [s], shape (N,)."""
    status: tuple[str, ...]
    """Status of each footstep; empty if there are no results."""
    blend_error: FloatArray
    """Recorded blend error of each footstep [m], shape (N,) or (0,)."""
    hull_distance: FloatArray
    """Recorded distance to the hull [m], shape (N,) or (0,)."""
    skeleton: Skeleton
    """Rest pose in the agent's space."""
    biped: Biped
    frame_codes: FloatArray
    """Whole time codes from the animation's first sample to its last, shape (F,)."""
    sampled: BoolArray
    """Whether the animation has samples there that are no farther apart than frames, shape (F,)."""
    skeleton_prim: Usd.Prim
    """Instance proxy of the Skeleton."""
    query: UsdSkel.SkeletonQuery

    @property
    def animation(self) -> str:
        """Path of its SkelAnimation."""
        return str(self.query.GetAnimQuery().GetPrim().GetPath())


@dataclass(frozen=True, kw_only=True)
class WrittenCrowd:
    """What a written crowd says of itself."""

    stage: Usd.Stage
    units: StageUnits
    folder: Path
    """Folder of crowd.usd."""
    terrain: Terrain | None
    """Terrain of the scene the crowd was made from; None if that cannot be found."""
    scene: str
    """Path of that scene, "" if not recorded."""
    provenance: Mapping[str, Any]
    """What the crowd says of its making, empty if nothing."""
    bipeds: dict[Hashable, Biped] = field(default_factory=dict)
    """What has been found of characters, which many agents share, by prototype and how it stands."""


def read_written_crowd(path: str | os.PathLike[str] | Usd.Stage) -> WrittenCrowd:
    """The crowd's stage, and the terrain of the scene recorded in its provenance.

    Args:
        path: A file, or an open stage, which is not changed.

    Raises:
        SceneError: If the file cannot be opened or has no agents.
    """
    stage = open_stage(path)
    agents = stage.GetPrimAtPath(tokens.Prim.AGENTS)
    if not agents or not agents.GetChildren():
        where = stage.GetRootLayer().identifier
        raise SceneError(
            where, f"has no agents below {tokens.Prim.AGENTS}", "give a crowd.usd written by usdfoot animate"
        )
    folder, provenance = _provenance(stage)
    recorded = str(provenance.get("scene", ""))
    scene = str((folder / recorded).resolve()) if recorded else ""
    return WrittenCrowd(
        stage=stage,
        units=read_stage_info(stage).units,
        folder=folder,
        terrain=_terrain(scene) if scene else None,
        scene=scene,
        provenance=provenance,
    )


def agent_names(crowd: WrittenCrowd) -> list[str]:
    """Names of all agents."""
    return [prim.GetName() for prim in crowd.stage.GetPrimAtPath(tokens.Prim.AGENTS).GetChildren()]


def read_agent(crowd: WrittenCrowd, name: str) -> WrittenAgent:
    """One agent of the crowd.

    Raises:
        UsdfootError: If the agent has no plan, Skeleton, biped or animation.
    """
    prim = crowd.stage.GetPrimAtPath(f"{tokens.Prim.AGENTS}/{name}")
    return read_agent_prim(prim, crowd.units, bipeds=crowd.bipeds)


def read_agent_prim(prim: Usd.Prim, units: StageUnits, *, bipeds: dict[Hashable, Biped] | None = None) -> WrittenAgent:
    """One agent of a stage, whatever its path.

    Args:
        prim: The agent's SkelRoot.
        units: Of its stage.
        bipeds: Those found for agents before, of which an instance of the same prototype has one; added to.

    Raises:
        UsdfootError: If the agent has no plan, Skeleton, biped or animation.
    """
    plans = [prim.GetStage().GetPrimAtPath(path) for path in targets(prim, tokens.Agent.PLAN)]
    if not plans or not plans[0]:
        raise SceneError(prim.GetPath(), "has no plan", f"{tokens.Agent.PLAN} must name one below {tokens.Prim.PLANS}")
    plan, _ = read_plan(plans[0], units)
    cache = UsdSkel.Cache()
    cache.Populate(UsdSkel.Root(prim), Usd.TraverseInstanceProxies())
    skeleton_prim = find_skeleton(prim)
    query = cache.GetSkelQuery(UsdSkel.Skeleton(skeleton_prim))
    animation = query.GetAnimQuery() if query else None
    if not animation:
        raise SceneError(prim.GetPath(), "has no animated Skeleton", "skel:animationSource must name a SkelAnimation")
    samples = animation.GetJointTransformTimeSamples()
    codes = np.arange(np.ceil(samples[0]), np.floor(samples[-1]) + 1.0) if samples else np.zeros(0)
    raw = read_skeleton(skeleton_prim)
    to_agent = _skeleton_to_agent(skeleton_prim, codes[0] if len(codes) else 0.0, units)
    skeleton = skeleton_in(raw, to_agent)
    known = bipeds if bipeds is not None and prim.IsInstance() else {}
    key = (prim.GetPrototype().GetPath() if prim.IsInstance() else None, _rounded(to_agent))
    if key not in known:
        known[key] = _read_biped(prim, skeleton_prim, raw, skeleton, to_agent)
    return WrittenAgent(
        name=prim.GetName(),
        plan=plan,
        flat_times=_flat_times(animation.GetPrim(), plan, units),
        status=tuple(str(value) for value in authored(plans[0], tokens.Result.STATUS) or ()),
        blend_error=_floats(plans[0], tokens.Result.BLEND_ERROR) * units.meters_per_unit,
        hull_distance=_floats(plans[0], tokens.Result.HULL_DISTANCE) * units.meters_per_unit,
        skeleton=skeleton,
        biped=known[key],
        frame_codes=codes,
        sampled=_sampled(np.array(samples), codes),
        skeleton_prim=skeleton_prim,
        query=query,
    )


def _read_biped(agent: Usd.Prim, prim: Usd.Prim, raw: RawSkeleton, skeleton: Skeleton, to_agent: Similarity) -> Biped:
    """The biped found as the scene's reader finds it."""
    below = Usd.PrimRange(agent, Usd.TraverseInstanceProxies())
    meshes = [child for child in below if child.IsA(UsdGeom.Mesh)]
    return read_biped(prim, raw, skeleton, skeleton_to_agent=to_agent, skin=read_skin(meshes, prim, raw))


def _rounded(similarity: Similarity) -> tuple[float, ...]:
    """Its numbers, the same for agents whose places alone make them differ."""
    values = np.concatenate([[similarity.scale], similarity.rotation[0], similarity.translation[0]])
    return tuple(np.round(values, 5).tolist())


def _skeleton_to_agent(prim: Usd.Prim, code: float, units: StageUnits) -> Similarity:
    """From the Skeleton's space to the canonical world at a time code, without the agent's place and yaw."""
    matrix = np.array(UsdGeom.XformCache(Usd.TimeCode(float(code))).GetLocalToWorldTransform(prim))
    to_world = similarity_of_matrices(matrix[None], prim.GetPath())
    place = _agent_matrix(prim, code)
    rotation = units.frames_to_canonical(to_world.rotation)
    origin = units.points_to_canonical(place[3:4, :3])
    turn = units.frames_to_canonical(similarity_of_matrices(place[None], prim.GetPath()).rotation)
    undo = quaternion.inverse(quaternion.normalised(turn * (0.0, 1.0, 0.0, 1.0)))
    shift = units.points_to_canonical(to_world.translation) - origin
    return Similarity(
        scale=to_world.scale * units.meters_per_unit,
        rotation=quaternion.compose(undo, rotation),
        translation=quaternion.rotate(undo, shift),
    )


def _agent_matrix(prim: Usd.Prim, code: float) -> FloatArray:
    """Local-to-world matrix of the agent prim above a Skeleton."""
    agents = Sdf.Path(tokens.Prim.AGENTS)
    path = next(path for path in prim.GetPath().GetPrefixes() if path.GetParentPath() == agents)
    cache = UsdGeom.XformCache(Usd.TimeCode(float(code)))
    return np.array(cache.GetLocalToWorldTransform(prim.GetStage().GetPrimAtPath(path)))


def _sampled(samples: FloatArray, codes: FloatArray) -> BoolArray:
    """Which codes (F,) are on a sample, or between two that are a frame apart, as in a crowd that was retimed."""
    if not len(codes):
        return np.zeros(0, dtype=bool)
    after = np.searchsorted(samples, codes - ON_SAMPLE)
    gaps = samples[after] - samples[np.maximum(after - 1, 0)]
    return (samples[after] - codes <= ON_SAMPLE) | (gaps <= 1.0 + ON_SAMPLE)


def _flat_times(animation: Usd.Prim, plan: FootstepPlan, units: StageUnits) -> FloatArray:
    """Flat times of the plan's footsteps by the strike times of the contacts."""
    flats = np.full(len(plan), np.nan)
    for side in (0, 1):
        strikes = _times(animation, tokens.Contact.STRIKE_TIMES[side], units)
        found = _times(animation, tokens.Contact.FLAT_TIMES[side], units)
        if not len(strikes) or len(strikes) != len(found):
            continue
        own = np.flatnonzero(plan.sides == side)
        distances = np.abs(plan.strike_times[own, None] - strikes)
        nearest = distances.argmin(axis=1)
        known = distances.min(axis=1) < 1e-6
        flats[own[known]] = found[nearest[known]]
    return flats


def _times(prim: Usd.Prim, name: str, units: StageUnits) -> FloatArray:
    return units.codes_to_times(np.array([float(code) for code in authored(prim, name) or ()]))


def _floats(prim: Usd.Prim, name: str) -> FloatArray:
    return np.array(authored(prim, name) or (), dtype=float)


def _provenance(stage: Usd.Stage) -> tuple[Path, dict[str, Any]]:
    """Folder of the layer that tells of the crowd's making, which may be a sublayer, and what it tells."""
    for layer in stage.GetLayerStack(includeSessionLayers=False):
        provenance = layer.customLayerData.get(tokens.PROVENANCE, {})
        if "scene" in provenance:
            return Path(os.path.realpath(layer.realPath)).parent, dict(provenance)
    return Path(os.path.realpath(stage.GetRootLayer().realPath)).parent, {}


def _terrain(scene: str) -> Terrain | None:
    """Terrain of a scene, None if the scene cannot be opened."""
    try:
        stage = open_stage(scene)
    except SceneError:
        return None
    terrain, _ = read_terrain(stage, collect_prims(stage), read_stage_info(stage).units)
    return terrain
