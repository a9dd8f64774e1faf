"""Opens a stage, reads its metadata and lists the prims the readers look at."""

from __future__ import annotations

import logging
import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

from pxr import Sdf, Tf, Usd, UsdGeom, UsdSkel, UsdUtils

from usdfoot.bridge.scene import StageInfo
from usdfoot.bridge.schema import applied_apis
from usdfoot.bridge.tokens import File
from usdfoot.bridge.units import StageUnits
from usdfoot.bridge.usd_errors import usd_reason
from usdfoot.errors import SceneError
from usdfoot.model.limits import DEFAULT_LIMITS, check_limit
from usdfoot.model.report import Problem

__all__ = [
    "StagePrims",
    "collect_prims",
    "composition_problems",
    "has_marked",
    "identifier_of",
    "is_as_saved",
    "keep_open",
    "layers_of",
    "open_stage",
    "read_stage_info",
    "start_code",
    "walk_stage",
]

_logger = logging.getLogger(__name__)

_EXTENSIONS = "usd, usda, usdc or usdz"
_MESHES, _INSTANCERS, _SHAPES = "meshes", "instancers", "shapes"
_KINDS = {
    _MESHES: UsdGeom.Mesh,
    "skeletons": UsdSkel.Skeleton,
    "animations": UsdSkel.Animation,
    _INSTANCERS: UsdGeom.PointInstancer,
}
_GEOMETRY = (_MESHES, _SHAPES)
_OURS = "Usdfoot"
_SESSION = re.compile(r",@anon:0x[0-9a-f]+:[^@]*@")
"""A stage's session layer beside its root, as USD names it in errors: by where it is in memory, each time elsewhere."""


def open_stage(scene: str | os.PathLike[str] | Usd.Stage) -> Usd.Stage:
    """The stage of a file as it is on disk now, or the stage given.

    What this process edited of a file and did not save stays.

    Raises:
        SceneError: If the file does not exist or is not USD.
    """
    if isinstance(scene, Usd.Stage):
        return scene
    path = os.fspath(scene)
    is_anonymous = Sdf.Layer.IsAnonymousLayerIdentifier(path)
    package = Sdf.Layer.SplitIdentifier(path)[0].split("[")[0]
    if os.path.isdir(path):
        crowd = os.path.join(path, File.CROWD)
        raise SceneError(
            path, "is a folder", f"give {crowd if os.path.isfile(crowd) else f'a {_EXTENSIONS} file in it'}"
        )
    if not is_anonymous and "://" not in path and not os.path.isfile(path) and not os.path.isfile(package):
        raise SceneError(path, "no such file", f"give a {_EXTENSIONS} file")
    try:
        stage = Usd.Stage.Open(path)
        while stage and _reload_written(stage):  # after which it may have other layers
            pass
    except Tf.ErrorException as error:
        raise SceneError(path, "cannot be opened as USD", usd_reason(error)) from error
    if not stage:
        raise SceneError(path, "cannot be opened as USD", f"give a {_EXTENSIONS} file")
    return stage


def keep_open(stage: Usd.Stage) -> None:
    """Has a stage stay open until the process ends, without being closed then.

    Closing that of a large crowd takes a sixth of the time in which nothing of it is found to be made. For processes of
    usdfoot's own, which open one.
    """
    UsdUtils.StageCache.Get().Insert(stage)


def read_stage_info(stage: Usd.Stage) -> StageInfo:
    """Metadata of a stage; what is not authored takes USD's fallback and is logged.

    Raises:
        SceneError: If a unit is not positive, the up axis is neither Y nor Z, or the rate is beyond all limits.
    """
    root = stage.GetRootLayer()
    rate = stage.GetTimeCodesPerSecond()
    if rate > DEFAULT_LIMITS.frames:
        what = f"timeCodesPerSecond is {rate:g}, more frames in one second than there may be in all"
        raise SceneError(root.identifier, what, f"author at most {DEFAULT_LIMITS.frames}")
    for key, is_authored, fallback in (
        ("metersPerUnit", UsdGeom.StageHasAuthoredMetersPerUnit(stage), "0.01"),
        ("upAxis", stage.HasAuthoredMetadata(UsdGeom.Tokens.upAxis), UsdGeom.GetFallbackUpAxis()),
        ("timeCodesPerSecond", _has_rate(stage), "24"),
    ):
        if not is_authored:
            _logger.info("%s: %s is not authored, USD's fallback %s is used", root.identifier, key, fallback)
    return StageInfo(
        identifier=identifier_of(root),
        units=StageUnits(
            meters_per_unit=UsdGeom.GetStageMetersPerUnit(stage),
            up_axis=str(UsdGeom.GetStageUpAxis(stage)),
            time_codes_per_second=rate,
        ),
        frames_per_second=stage.GetFramesPerSecond(),
        start_code=stage.GetStartTimeCode(),
        end_code=stage.GetEndTimeCode(),
        layers=layers_of(stage),
        as_saved=is_as_saved(stage),
    )


def layers_of(stage: Usd.Stage) -> tuple[str, ...]:
    """Files of a stage, sorted; layers in memory by their names."""
    return tuple(sorted({identifier_of(layer) for layer in _shared_layers(stage)}))


def is_as_saved(stage: Usd.Stage) -> bool:
    """Whether whoever opens the stage's file sees the same: nothing edited, hidden or left out in memory alone."""
    return (
        stage.GetSessionLayer().empty
        and not any(layer.anonymous or layer.dirty for layer in _shared_layers(stage))
        and not stage.GetMutedLayers()
        and stage.GetPopulationMask() == Usd.StagePopulationMask.All()
        and stage.GetLoadRules() == Usd.StageLoadRules.LoadAll()
        and stage.GetInterpolationType() == Usd.InterpolationTypeLinear
    )


def identifier_of(layer: Sdf.Layer) -> str:
    """Path of a layer's file; of one in memory its name."""
    return str(layer.realPath or layer.identifier)


def has_marked(stage: Usd.Stage, *, more_than: int) -> bool:
    """Whether so many prims are marked with schemas of usdfoot, found without looking at the others."""
    marked = (prim for prim in stage.Traverse() if any(name.startswith(_OURS) for name in applied_apis(prim)))
    return next(islice(marked, more_than, None), None) is not None


def composition_problems(stage: Usd.Stage) -> tuple[Problem, ...]:
    """A warning for each file or prim that the stage refers to and USD does not find, and for each broken arc."""
    where = stage.GetRootLayer().identifier
    said = (_SESSION.sub("", str(error)) for error in stage.GetCompositionErrors())
    texts = dict.fromkeys(" ".join(text.split()).rstrip(".") for text in said)
    remedy = "what it would bring is missing here; correct or remove the arc"
    return tuple(Problem(severity="warning", where=where, message=f"{where}: {text}. {remedy}") for text in texts)


def start_code(stage: Usd.Stage) -> Usd.TimeCode:
    """Time code at which what does not move is read: the stage's start, or 0."""
    return Usd.TimeCode(stage.GetStartTimeCode())


@dataclass(frozen=True, kw_only=True)
class StagePrims:
    """Prims of a stage by kind, in stage order, instance proxies included."""

    skeletons: tuple[Usd.Prim, ...]
    animations: tuple[Usd.Prim, ...]
    meshes: tuple[Usd.Prim, ...]
    """Without those below point instancers, which are prototypes."""
    instancers: tuple[Usd.Prim, ...]
    shapes: tuple[Usd.Prim, ...]
    """Other surfaces: cubes, planes, spheres, patches, but no curves and points; without prototypes too."""
    with_apis: dict[str, tuple[Usd.Prim, ...]]
    """Prims by the usdfoot API schemas applied to them."""


def collect_prims(stage: Usd.Stage, *, most: int = DEFAULT_LIMITS.prims) -> StagePrims:
    """Every prim the readers look at, found in one walk.

    Raises:
        SceneError: If there are more prims than `most`.
    """
    found: dict[str, list[Usd.Prim]] = {kind: [] for kind in (*_KINDS, _SHAPES)}
    with_apis: dict[str, list[Usd.Prim]] = {}
    kinds: dict[str, str] = {}
    prototypes: list[Sdf.Path] = []
    for prim in walk_stage(stage, most=most):
        for name in applied_apis(prim):
            if name.startswith(_OURS):
                with_apis.setdefault(name, []).append(prim)
        type_name = prim.GetTypeName()
        kind = kinds.get(type_name)
        if kind is None:
            kind = kinds[type_name] = _kind(prim)
        if not kind or (kind in _GEOMETRY and prototypes and prim.GetPath().HasPrefix(prototypes[-1])):
            continue
        if kind == _INSTANCERS:
            prototypes.append(prim.GetPath())
        found[kind].append(prim)
    prims = {kind: tuple(found[kind]) for kind in (*_KINDS, _SHAPES)}
    return StagePrims(**prims, with_apis={name: tuple(marked) for name, marked in with_apis.items()})


def _kind(prim: Usd.Prim) -> str:
    """Field of `StagePrims` that prims of this one's type belong to, "" if none."""
    for kind, schema in _KINDS.items():
        if prim.IsA(schema):
            return kind
    is_surface = prim.IsA(UsdGeom.Gprim) and not (prim.IsA(UsdGeom.Curves) or prim.IsA(UsdGeom.Points))
    return _SHAPES if is_surface else ""


def walk_stage(stage: Usd.Stage, *, most: int = DEFAULT_LIMITS.prims) -> Iterator[Usd.Prim]:
    """Every prim that is active, loaded and defined, instance proxies included.

    Raises:
        SceneError: If there are more than `most`: a few instances within instances are billions.
    """
    for number, prim in enumerate(Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies())):
        if number > most:
            check_limit(stage.GetRootLayer().identifier, "prims", number, limit=most)
        yield prim


def _has_rate(stage: Usd.Stage) -> bool:
    return stage.HasAuthoredMetadata("timeCodesPerSecond") or stage.HasAuthoredMetadata("framesPerSecond")


def _reload_written(stage: Usd.Stage) -> bool:
    """Has a stage show what others wrote into files that this process had open; whether there was any."""
    layers = [layer for layer in _shared_layers(stage) if not (layer.anonymous or layer.dirty)]
    return any([layer.Reload() for layer in layers])


def _shared_layers(stage: Usd.Stage) -> list[Sdf.Layer]:
    """Layers of the stage but for its session, which belongs to whoever looks at it."""
    session = stage.GetSessionLayer()
    return [layer for layer in stage.GetUsedLayers() if layer != session]
