"""`clips.usdc`: the clip library of the person, with the contacts known by construction in `customData`."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

from stagecraft.footprints import LEFT
from stagecraft.gaits import ClipPlan
from stagecraft.pelvis_path import RATE
from stagecraft.rig import FootShape, Rig
from stagecraft.rotation import FloatArray, to_quaternions
from stagecraft.stage_file import CODES_PER_SECOND, new_stage, relate, uniform, vectors
from stagecraft.walker import local_rotations, walk


@dataclass(frozen=True, kw_only=True)
class Clip:
    """A clip cut into frames."""

    plan: ClipPlan
    start: float
    """Time of the first frame on the plan's clock [s]."""
    pelvis: FloatArray
    """Pelvis joint in the world [m], shape (F, 3)."""
    rotations: FloatArray
    """Joints to parents, xyzw, shape (F, J, 4)."""
    world: FloatArray
    """Joints to world, shape (F, J, 3, 3)."""


def make_clip(plan: ClipPlan, rig: Rig, foot: FootShape) -> Clip:
    """Walk the plan and keep the frames of its interval."""
    motion = walk(plan.prints, rig, foot, breath=plan.breath)
    first = round((plan.start - motion.times[0]) * RATE)
    frames = round((plan.end - plan.start) * CODES_PER_SECOND) + 1
    kept = first + np.arange(frames) * round(RATE / CODES_PER_SECOND)
    local = local_rotations(rig, motion.rotations[kept])
    return Clip(
        plan=plan,
        start=float(motion.times[first]),
        pelvis=motion.pelvis[kept],
        rotations=to_quaternions(local),
        world=motion.rotations[kept],
    )


def write_clips(path: Path, clips: Sequence[Clip], rig: Rig, *, human: str) -> None:
    """Write `clips` to `path`; `human` is the asset path of the character whose skeleton they move."""
    stage = new_stage(path, "HumanClips", "Xform", "gaits of a kinematic walker, tools/stagecraft/gaits.py")
    UsdSkel.Root.Define(stage, "/HumanClips/Rig")
    skeleton = UsdSkel.Skeleton.Define(stage, "/HumanClips/Rig/Skeleton").GetPrim()
    skeleton.GetReferences().AddReference(human, "/Human/Skeleton")
    UsdGeom.Scope.Define(stage, "/HumanClips/Clips")
    for clip in clips:
        _author(stage, clip, rig)
    UsdSkel.BindingAPI.Apply(skeleton).CreateAnimationSourceRel().SetTargets(
        [f"/HumanClips/Clips/{clips[0].plan.name}"]
    )
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(max(len(clip.pelvis) for clip in clips) - 1)
    stage.Save()


def contact_truth(clip: Clip) -> dict[str, NDArray[np.float64]]:
    """Strikes, flats and liftoffs of both feet within the clip, in time codes."""
    last = len(clip.pelvis) - 1
    found = {}
    for side, name in ((LEFT, "left"), (1 - LEFT, "right")):
        own = [footprint for footprint in clip.plan.prints if footprint.side == side]
        for event in ("strike", "flat", "liftoff"):
            codes = np.array([(getattr(footprint, event) - clip.start) * CODES_PER_SECOND for footprint in own])
            found[f"{name}{event.capitalize()}Times"] = codes[(codes >= 0.0) & (codes <= last)]
    return found


def _author(stage: Usd.Stage, clip: Clip, rig: Rig) -> None:
    """One SkelAnimation; samples go in through the layer, which is faster."""
    path = Sdf.Path(f"/HumanClips/Clips/{clip.plan.name}")
    animation = UsdSkel.Animation.Define(stage, path)
    animation.CreateJointsAttr(rig.tokens)
    animation.CreateScalesAttr([Gf.Vec3h(1.0)] * len(rig.names))
    animation.CreateTranslationsAttr()
    animation.CreateRotationsAttr()
    translations = np.tile([rig.bone(name) for name in rig.names], (len(clip.pelvis), 1, 1))
    translations[:, 0] = clip.pelvis
    layer = stage.GetRootLayer()
    with Sdf.ChangeBlock():
        for frame, (places, turns) in enumerate(zip(translations, clip.rotations, strict=True)):
            layer.SetTimeSample(path.AppendProperty("translations"), frame, vectors(places))
            layer.SetTimeSample(
                path.AppendProperty("rotations"), frame, Vt.QuatfArray.FromNumpy(turns.astype(np.float32))
            )
    prim = animation.GetPrim()
    prim.AddAppliedSchema("UsdfootClipAPI")
    uniform(prim, "usdfoot:clip:cyclic", Sdf.ValueTypeNames.Bool, clip.plan.cyclic)
    relate(prim, "usdfoot:clip:skeleton", ["/HumanClips/Rig/Skeleton"])
    truth = {name: Vt.DoubleArray.FromNumpy(codes) for name, codes in contact_truth(clip).items()}
    prim.SetCustomDataByKey("truth", truth)
