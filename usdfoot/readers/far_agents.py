"""Far agents: how far each is from the camera, and at which frames it has its samples."""

from __future__ import annotations

import hashlib

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from usdfoot.bridge.units import StageUnits
from usdfoot.errors import SceneError
from usdfoot.maths.types import FloatArray
from usdfoot.model.agent import SampledFrames
from usdfoot.model.plan import FootstepPlan
from usdfoot.model.sampling import SamplingOptions
from usdfoot.model.trajectory import RootTrajectory
from usdfoot.readers.skeleton import matrices_of

__all__ = ["SamplingReader"]


class SamplingReader:
    """The camera's way, read once.

    Args:
        stage: With the camera.
        options: Who is sampled how often.
        units: Of the stage.
        codes: Time codes of the crowd's frames, shape (F,).

    Raises:
        SceneError: If there is no such camera.
    """

    def __init__(self, stage: Usd.Stage, options: SamplingOptions, units: StageUnits, codes: FloatArray) -> None:
        self._options = options
        self._times = units.codes_to_times(codes)
        self._camera: FloatArray = np.zeros((0, 3))
        if options.camera:
            matrices = matrices_of(_camera_prim(stage, options.camera), codes)
            self._camera = units.points_to_canonical(matrices[:, 3, :3])

    def frames_of(self, walk: FootstepPlan | RootTrajectory, name: str) -> SampledFrames:
        """The frames at which an agent has samples.

        Args:
            walk: Where it goes.
            name: Its name, which settles its turn: agents that come or go beside it leave it as it is.
        """
        every = self._options.every
        if every == 1 or self._distance(walk) < self._options.near:
            return SampledFrames()
        return SampledFrames(every=every, turn=_turn(name, every))

    def _distance(self, walk: FootstepPlan | RootTrajectory) -> float:
        """Least distance to the camera while the agent walks [m], infinite without a camera."""
        if not len(self._camera):
            return np.inf
        own = (self._times > walk.start) & (self._times < walk.end)
        times = np.concatenate([[walk.start], self._times[own], [walk.end]])
        stops = walk.strike_times if isinstance(walk, FootstepPlan) else walk.times
        return float(
            np.linalg.norm(_at(times, stops, walk.positions) - _at(times, self._times, self._camera), axis=1).min()
        )


def _turn(name: str, every: int) -> int:
    """One of `every` turns, each that of as many names as any other, the same in all processes."""
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:8], "big") % every


def _at(times: FloatArray, known: FloatArray, positions: FloatArray) -> FloatArray:
    """Positions (K, 3) known at times (K,), straight between them, shape (F, 3)."""
    return np.stack([np.interp(times, known, positions[:, axis]) for axis in range(3)], axis=1)


def _camera_prim(stage: Usd.Stage, path: str) -> Usd.Prim:
    prim = stage.GetPrimAtPath(path) if Sdf.Path.IsValidPathString(path) else None
    if prim and prim.IsA(UsdGeom.Xformable):
        return prim
    cameras = [found.GetPath() for found in stage.Traverse() if found.IsA(UsdGeom.Camera)]
    what = "is no prim that stands anywhere"
    remedy = "give the path of a camera or of another prim with a transform"
    raise SceneError(path, f"{what}; the scene's cameras are" if cameras else what, remedy, cameras)
