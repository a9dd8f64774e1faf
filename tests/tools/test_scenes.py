"""The scenes of `stages/`: plans as design.md section 2 asks, soles on the ground, steps the clips can make."""

from dataclasses import dataclass

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom
from scipy.spatial import Delaunay
from stagecraft.course import obstacle_course
from stagecraft.gaits import all_clips
from stagecraft.plan_prim import SOLE
from stagecraft.rig import human_foot, human_rig
from stagecraft.stones import stepping_stones
from stagecraft.terrains import ground_under, hills, slope, stairs
from stagecraft.walker import walk

SCENES = ("obstacle_course", "stepping_stones", "crowd")


@dataclass(frozen=True, kw_only=True)
class WrittenPlan:
    """A plan as the file has it."""

    sides: np.ndarray
    places: np.ndarray
    orientations: list[Gf.Quath]
    strikes: np.ndarray
    liftoffs: np.ndarray
    schemas: list[str]
    stage_end: float


def plans(stages, scene) -> list[WrittenPlan]:
    stage = Usd.Stage.Open(str(stages / f"{scene}.usda"))
    return [_read(UsdGeom.PointInstancer(prim)) for prim in stage.GetPrimAtPath("/World/Plans").GetChildren()]


def _read(plan: UsdGeom.PointInstancer) -> WrittenPlan:
    prim = plan.GetPrim()
    strikes, liftoffs = (
        np.array(prim.GetAttribute(f"usdfoot:plan:{event}Times").Get(), dtype=float) for event in ("strike", "liftoff")
    )
    return WrittenPlan(
        sides=np.array(plan.GetProtoIndicesAttr().Get()),
        places=np.array(plan.GetPositionsAttr().Get()),
        orientations=list(plan.GetOrientationsAttr().Get()),
        strikes=strikes,
        liftoffs=liftoffs,
        schemas=list(prim.GetMetadata("apiSchemas").GetAddedOrExplicitItems()),
        stage_end=prim.GetStage().GetEndTimeCode(),
    )


def landings(prints, start=-np.inf, end=np.inf):
    """Swing ball from support ball (outward, forward) [m] in the mean heading of the feet at each step's start."""
    found = []
    for before, support, swing in zip(prints, prints[1:], prints[2:], strict=False):
        if support.strike < start or swing.strike > end + 1e-6 or swing.strike <= support.strike:
            continue
        heading = 0.5 * (before.yaw + support.yaw)
        x, z = (swing.position - support.position)[[0, 2]]
        left, forward = np.cos(heading) * x - np.sin(heading) * z, np.sin(heading) * x + np.cos(heading) * z
        found.append((left if swing.side == 0 else -left, forward))
    return np.array(found).reshape(-1, 2)


@pytest.mark.parametrize("scene", SCENES)
def test_plans_keep_the_contract(stages, scene):
    for plan in plans(stages, scene):
        count = len(plan.sides)
        assert count == len(plan.places) == len(plan.orientations) == len(plan.strikes) == len(plan.liftoffs)
        assert (np.abs(np.diff(plan.sides)) == 1).all()
        assert (np.diff(plan.strikes) >= 0).all() and (plan.liftoffs > plan.strikes).all()
        assert (plan.liftoffs[:-2] < plan.strikes[2:]).all()  # a foot leaves before it comes down again
        assert plan.schemas == ["UsdfootPlanAPI"]


@pytest.mark.parametrize("scene", ["obstacle_course", "stepping_stones"])
def test_scenes_start_and_end_standing(stages, scene):
    (plan,) = plans(stages, scene)
    assert plan.strikes[0] == plan.strikes[1] == 0.0
    assert plan.liftoffs[-1] == plan.liftoffs[-2]
    assert plan.stage_end == np.ceil(plan.liftoffs[-1])


def test_the_course_has_every_gait(stages):
    (plan,) = plans(stages, "obstacle_course")
    flights = plan.strikes[1:] - plan.liftoffs[:-1]
    assert (flights > 1.0).sum() >= 4  # more than a code in the air
    assert 50 <= len(plan.strikes) <= 75
    assert np.ptp(plan.places[:, 1]) > 0.55 and (plan.places[:, 1] > 0.05).sum() >= 10
    steps = landings(obstacle_course().plan.prints)
    assert sum(forward < -0.15 for _, forward in steps) >= 3
    assert sum(abs(forward) < 0.05 and outward > 0.25 for outward, forward in steps) >= 3
    assert np.abs(np.diff(plan.places[:, 1])).max() <= 0.17


def test_prints_lie_on_the_ground_with_the_whole_sole():
    course, crossing = obstacle_course(), stepping_stones()
    ramp, steps = slope().placed(course.slope_at, np.pi / 2), stairs().placed(course.stairs_at)
    for plan, surfaces in (
        (course.plan, [course.ground, ramp, steps]),
        (crossing.plan, [*crossing.stones, crossing.water]),
    ):
        for footprint, turn in zip(plan.prints, plan.orientations, strict=True):
            outline = SOLE * [1.0 if footprint.side else -1.0, 1.0]
            sole = np.stack([outline[:, 0], np.zeros(len(SOLE)), outline[:, 1]], axis=1)
            world = footprint.position + sole @ turn.T
            heights, _ = ground_under(surfaces, world[:, [0, 2]])
            assert np.abs(heights - world[:, 1]).max() < 1e-3


def test_orientations_face_the_heading_and_the_normal(stages):
    (plan,) = plans(stages, "obstacle_course")
    expected = obstacle_course().plan
    for quaternion, turn, footprint in zip(plan.orientations, expected.orientations, expected.prints, strict=True):
        rotation = Gf.Rotation(Gf.Quatd(quaternion))
        ahead, up = (np.array(rotation.TransformDir(axis)) for axis in (Gf.Vec3d(0, 0, 1), Gf.Vec3d(0, 1, 0)))
        assert np.degrees(np.arccos(np.clip(ahead @ turn[:, 2], -1, 1))) < 0.3  # half precision
        assert np.degrees(np.arccos(np.clip(up @ turn[:, 1], -1, 1))) < 0.3  # half precision
        flat = np.arctan2(ahead[0], ahead[2]) - footprint.yaw
        assert abs(np.degrees(np.angle(np.exp(1j * flat)))) < 0.3  # half precision


def test_every_planned_step_is_well_inside_what_the_clips_do():
    examples = np.concatenate([landings(clip.prints, clip.start, clip.end) for clip in all_clips()])
    hull = Delaunay(np.unique(examples.round(3), axis=0))
    for plan in (obstacle_course().plan, stepping_stones().plan):
        for angle in np.arange(0.0, 2.0 * np.pi, np.pi / 4):
            around = landings(plan.prints) + 0.03 * np.array([np.cos(angle), np.sin(angle)])
            assert (hull.find_simplex(around) >= 0).all()


def test_a_person_can_walk_the_plans():
    rig, foot = human_rig(), human_foot()
    for plan in (obstacle_course().plan, stepping_stones().plan):
        motion = walk(plan.prints, rig, foot)  # raises where a leg is too short
        lowest = min(footprint.position[1] for footprint in plan.prints)
        assert motion.pelvis[:, 1].min() > lowest + 0.8


def test_agents_point_at_plans_clips_and_characters(stages):
    for scene in SCENES:
        stage = Usd.Stage.Open(str(stages / f"{scene}.usda"))
        agents = [
            prim for prim in stage.GetPrimAtPath("/World").GetChildren() if prim.HasRelationship("usdfoot:agent:plan")
        ]
        assert len(agents) == (12 if scene == "crowd" else 1)
        for agent in agents:
            for name in ("plan", "clips", "character"):
                relationship = agent.GetRelationship(f"usdfoot:agent:{name}")
                for target in relationship.GetTargets() if relationship else []:
                    assert stage.GetPrimAtPath(target), (agent.GetPath(), name, target)


def test_followers_point_at_animated_xforms_and_points_that_hold_their_ids(stages):
    stage = Usd.Stage.Open(str(stages / "trajectories.usda"))
    agents = [
        prim for prim in stage.GetPrimAtPath("/World").GetChildren() if prim.HasRelationship("usdfoot:agent:trajectory")
    ]
    assert len(agents) == 6
    for agent in agents:
        (target,) = agent.GetRelationship("usdfoot:agent:trajectory").GetTargets()
        prim = stage.GetPrimAtPath(target)
        if prim.IsA(UsdGeom.Points):
            ids = prim.GetAttribute("ids")
            held = [agent.GetAttribute("usdfoot:agent:id").Get() in ids.Get(code) for code in ids.GetTimeSamples()]
            assert sum(held) > 10
        else:
            assert len(UsdGeom.Xformable(prim).GetTimeSamples()) > 10


def test_the_hills_are_gentle():
    normals = hills().face_normals()
    assert 5.0 < np.degrees(np.arccos(normals[:, 1].min())) < 15.0
