"""Clips of `stages/clips.usdc` as UsdSkel evaluates them: nothing of the generator is used to check its work."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdSkel

FloatArray = NDArray[np.float64]
SIDES = ("left", "right")


@dataclass(frozen=True, kw_only=True)
class ClipPoses:
    """One clip, frame by frame."""

    name: str
    cyclic: bool
    codes: FloatArray
    places: FloatArray
    """Joints in the world [m], shape (F, J, 3)."""
    turns: FloatArray
    """Joints to world, column vectors, shape (F, J, 3, 3)."""
    local: FloatArray
    """Joints to parents, xyzw, shape (F, J, 4)."""
    joints: tuple[str, ...]
    truth: dict[str, FloatArray]
    """Contact times by construction [time codes]."""

    def joint(self, name: str) -> int:
        """Index of the joint with that leaf name."""
        return [path.rsplit("/", 1)[-1] for path in self.joints].index(name)

    def place(self, name: str) -> FloatArray:
        """A joint's path [m], shape (F, 3)."""
        return self.places[:, self.joint(name)]

    def contacts(self, side: str) -> list[tuple[float, float, float]]:
        """Strike, flat and liftoff of every contact that lies wholly in the clip [time codes]."""
        found = []
        for strike in self.truth[f"{side}StrikeTimes"]:
            flats, liftoffs = self.truth[f"{side}FlatTimes"], self.truth[f"{side}LiftoffTimes"]
            if (flats >= strike).any() and (liftoffs > strike).any():
                found.append((strike, flats[flats >= strike][0], liftoffs[liftoffs > strike][0]))
        return found

    def knee_flexion(self, side: str) -> FloatArray:
        """Angle at the knee, 0 straight [rad], shape (F,)."""
        hip, knee, ankle = (self.place(f"{side.capitalize()}{name}") for name in ("UpLeg", "Leg", "Foot"))
        thigh, shank = knee - hip, ankle - knee
        cosine = np.sum(thigh * shank, axis=1) / np.linalg.norm(thigh, axis=1) / np.linalg.norm(shank, axis=1)
        return np.arccos(np.clip(cosine, -1.0, 1.0))


def read_clip_poses(path: Path) -> dict[str, ClipPoses]:
    """All clips of the library by name."""
    stage = Usd.Stage.Open(str(path))
    skeleton = UsdSkel.Skeleton.Get(stage, "/HumanClips/Rig/Skeleton")
    clips = (UsdSkel.Animation(prim) for prim in stage.GetPrimAtPath("/HumanClips/Clips").GetChildren())
    return {clip.GetPrim().GetName(): _read(clip, skeleton) for clip in clips}


def _read(clip: UsdSkel.Animation, skeleton: UsdSkel.Skeleton) -> ClipPoses:
    topology = UsdSkel.Topology(skeleton.GetJointsAttr().Get())
    codes = clip.GetRotationsAttr().GetTimeSamples()
    query = UsdSkel.Cache().GetAnimQuery(clip)
    matrices = np.array(
        [UsdSkel.ConcatJointTransforms(topology, query.ComputeJointLocalTransforms(code)) for code in codes]
    )
    quaternions = np.array([[(*q.imaginary, q.real) for q in clip.GetRotationsAttr().Get(code)] for code in codes])
    prim = clip.GetPrim()
    return ClipPoses(
        name=prim.GetName(),
        cyclic=prim.GetAttribute("usdfoot:clip:cyclic").Get(),
        codes=np.array(codes),
        places=matrices[:, :, 3, :3],
        turns=np.swapaxes(matrices[:, :, :3, :3], -1, -2),
        local=quaternions,
        joints=tuple(skeleton.GetJointsAttr().Get()),
        truth={name: np.array(times) for name, times in prim.GetCustomDataByKey("truth").items()},
    )
