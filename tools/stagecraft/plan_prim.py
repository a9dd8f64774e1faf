"""Footstep plans as PointInstancers with `UsdfootPlanAPI`, their prints shaped like shoe soles."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from stagecraft.footprints import Footprint
from stagecraft.rotation import FloatArray, about_y, to_quaternions
from stagecraft.stage_file import CODES_PER_SECOND, define_mesh, relate, vectors
from stagecraft.terrains import Surface, ground_under

SOLE = np.array(
    [
        (-0.026, -0.190),
        (-0.037, -0.160),
        (-0.035, -0.110),
        (-0.036, -0.060),
        (-0.046, -0.010),
        (-0.047, 0.025),
        (-0.036, 0.058),
        (-0.008, 0.074),
        (0.020, 0.068),
        (0.038, 0.042),
        (0.043, 0.000),
        (0.036, -0.045),
        (0.020, -0.085),
        (0.024, -0.130),
        (0.030, -0.165),
        (0.018, -0.190),
    ]
)
"""Outline of the right sole around the ball (x, z) [m], inner side at +x."""
BIRD_SOLE = np.array(
    [(-0.012, -0.085), (-0.018, -0.035), (-0.055, 0.050), (-0.022, 0.045), (0.0, 0.078), (0.022, 0.045), (0.055, 0.050),
     (0.018, -0.035), (0.012, -0.085)]
)  # fmt: skip
DINOSAUR_SOLE = np.array(
    [(-0.06, -0.07), (-0.09, 0.05), (-0.16, 0.22), (-0.10, 0.23), (-0.05, 0.12), (-0.03, 0.31), (0.03, 0.31),
     (0.05, 0.12), (0.10, 0.23), (0.16, 0.22), (0.09, 0.05), (0.06, -0.07)]
)  # fmt: skip
"""Webbed and three-toed feet, likewise."""
OVER_GROUND = 0.004
"""Height at which the prints are drawn over the ground [m]."""
COLOURS = ((0.15, 0.45, 0.85), (0.90, 0.45, 0.10))


@dataclass(frozen=True, kw_only=True)
class Plan:
    """Footsteps laid on terrain."""

    name: str
    prints: tuple[Footprint, ...]
    """In order of strike, positions on the ground."""
    orientations: FloatArray
    """Print to world, +Z forward, +Y the ground's normal, shape (N, 3, 3)."""


def lay_on(name: str, prints: Sequence[Footprint], surfaces: Sequence[Surface]) -> Plan:
    """The footsteps with heights and slopes of the highest surface under each."""
    places = np.array([footprint.position[[0, 2]] for footprint in prints])
    heights, normals = ground_under(surfaces, places)
    ahead = np.array([about_y(footprint.yaw)[:, 2] for footprint in prints])
    ahead[:, 1] = -np.sum(ahead * normals, axis=1) / normals[:, 1]  # up the slope, same heading seen from above
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    across = np.cross(normals, ahead)
    on_ground = [_at_height(footprint, height) for footprint, height in zip(prints, heights, strict=True)]
    return Plan(name=name, prints=tuple(on_ground), orientations=np.stack([across, normals, ahead], axis=-1))


def author_plan(stage: Usd.Stage, path: str, plan: Plan, *, sole: FloatArray = SOLE) -> None:
    """Author the plan at `path`, its prints shaped like the right `sole`, shape (N, 2)."""
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    UsdGeom.Scope.Define(stage, f"{path}/Prints")
    targets = [_author_print(stage, f"{path}/Prints/{name}", side, sole) for side, name in enumerate(("Left", "Right"))]
    relate(instancer.GetPrim(), "prototypes", targets)
    instancer.CreateProtoIndicesAttr([footprint.side for footprint in plan.prints])
    instancer.CreatePositionsAttr(vectors(np.array([footprint.position for footprint in plan.prints])))
    quaternions = [to_quaternions(turn[None])[0] for turn in plan.orientations]
    instancer.CreateOrientationsAttr(
        Vt.QuathArray([Gf.Quath(float(w), float(x), float(y), float(z)) for x, y, z, w in quaternions])
    )
    instancer.CreateExtentAttr(instancer.ComputeExtentAtTime(Usd.TimeCode.Default(), Usd.TimeCode.Default()))
    prim = instancer.GetPrim()
    prim.AddAppliedSchema("UsdfootPlanAPI")
    for event in ("strike", "liftoff"):
        codes = [round(getattr(footprint, event) * CODES_PER_SECOND, 3) for footprint in plan.prints]
        attribute = prim.CreateAttribute(
            f"usdfoot:plan:{event}Times",
            Sdf.ValueTypeNames.TimeCodeArray,
            custom=False,
            variability=Sdf.VariabilityUniform,
        )
        attribute.Set(Sdf.TimeCodeArray(codes))


def last_code(plan: Plan) -> float:
    """Time code of the last liftoff."""
    return max(footprint.liftoff for footprint in plan.prints) * CODES_PER_SECOND


def _author_print(stage: Usd.Stage, path: str, side: int, sole: FloatArray) -> str:
    outline = sole * [-1.0 if side == 0 else 1.0, 1.0]
    points = np.stack([outline[:, 0], np.full(len(outline), OVER_GROUND), outline[:, 1]], axis=1)
    order = np.arange(len(points)) if side else np.arange(len(points))[::-1]
    define_mesh(
        stage,
        path,
        points=points,
        counts=np.array([len(points)]),
        indices=order,
        normals=np.array([[0.0, 1.0, 0.0]]),
        colours=np.array([COLOURS[side]]),
        per="uniform",
    )
    return path


def _at_height(footprint: Footprint, height: float) -> Footprint:
    return Footprint(
        side=footprint.side,
        position=footprint.position * [1.0, 0.0, 1.0] + [0.0, height, 0.0],
        yaw=footprint.yaw,
        strike=footprint.strike,
        liftoff=footprint.liftoff,
        roll=footprint.roll,
    )
