"""What usdfoot writes passes its validators; every fault is found by exactly one of them, named, mended if possible."""

import shutil

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, UsdValidation, Vt

import usdfoot.validators
from usdfoot.bridge import tokens
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.validate import validate

NAMES = {"AnimationComplete", "Contacts", "FeetOnFootsteps", "JointArrays", "PlanArrays", "Quaternions"}
ANIMATION = "/Crowd/Anims/Walker"
PLAN = "/Crowd/Plans/Walker"
AGENT = "/Crowd/Agents/Walker"
CONTACT = tokens.Contact


def validators():
    registry = UsdValidation.ValidationRegistry()
    return [registry.GetOrLoadValidatorByName(f"usdfoot.validators:{name}") for name in sorted(NAMES)]


def errors_of(stage):
    return UsdValidation.ValidationContext(validators()).Validate(stage)


def told(errors):
    return {error.GetName(): error.GetMessage() for error in errors}


@pytest.fixture
def crowd(stones, tmp_path):
    """A copy of the stones crowd, open, with the artists' layer as edit target."""
    assert tmp_path.parent == stones.crowd_file.parent.parent  # so relative paths stay right
    shutil.copytree(stones.crowd_file.parent, tmp_path, dirs_exist_ok=True)
    stage = Usd.Stage.Open(str(tmp_path / "crowd.usd"))
    stage.SetEditTarget(Sdf.Layer.FindOrOpen(str(tmp_path / "overrides.usda")))
    return stage


def change(stage, path, edit):
    """Override an attribute's default, or all of its samples, by what `edit` makes of them."""
    attribute = stage.GetAttributeAtPath(path)
    samples = [(Usd.TimeCode(code), attribute.Get(code)) for code in attribute.GetTimeSamples()]
    for code, value in samples or [(Usd.TimeCode.Default(), attribute.Get())]:
        attribute.Set(edit(value, code), code)


def put(values, index, value):
    """A copy of an array with one value replaced."""
    values = type(values)(values)
    values[index] = value
    return values


def test_all_validators_are_registered_with_what_the_plugin_says():
    assert all(validators()) and usdfoot.validators.__doc__
    for validator in validators():
        metadata = validator.GetMetadata()
        assert "UsdfootValidators" in metadata.GetKeywords() and metadata.doc and metadata.GetSchemaTypes()


def test_what_is_written_passes_with_and_without_instancing(stones):
    for name in ("crowd.usd", "crowd.expanded.usda"):
        assert not told(errors_of(Usd.Stage.Open(str(stones.crowd_file.with_name(name)))))


def test_a_part_of_the_frames_passes_too_and_its_contacts_end_with_them(scene, tmp_path):
    report = animate(scene, tmp_path, frames=(50.0, 90.0))
    stage = Usd.Stage.Open(str(report.crowd_file))
    assert not told(errors_of(stage))
    animation = stage.GetPrimAtPath(ANIMATION)
    strikes, liftoffs = (
        np.array([float(code) for side in (0, 1) for code in animation.GetAttribute(names[side]).Get()])
        for names in (CONTACT.STRIKE_TIMES, CONTACT.LIFTOFF_TIMES)
    )
    assert strikes.min() == 50.0 and liftoffs.max() == 90.0 and (liftoffs > strikes).all()


def test_a_foot_that_has_struck_but_is_not_flat_when_the_frames_end_misses_nothing(scene, tmp_path):
    report = animate(scene, tmp_path, frames=(330.0, 359.0))
    assert not told(errors_of(Usd.Stage.Open(str(report.crowd_file))))
    figures = {figure.name: figure.value for figure in validate(report.crowd_file).total.figures}
    assert figures["placement worst"] < 0.1 and figures["timing faults"] == 0


@pytest.mark.parametrize(
    "name", ["clips.usdc", "stepping_stones.usda", "obstacle_course.usda", "physics_bird_walk.usda", "crowd.usda"]
)
def test_scenes_that_are_not_animated_yet_pass(stages, name):
    assert not told(errors_of(Usd.Stage.Open(str(stages / name))))


def test_what_is_not_of_usdfoot_is_no_business_of_these():
    stage = Usd.Stage.CreateInMemory()
    UsdSkel.Root.Define(stage, "/Hero")
    animation = UsdSkel.Animation.Define(stage, "/Hero/Dance")
    animation.CreateJointsAttr(["a", "a"])
    animation.CreateRotationsAttr(Vt.QuatfArray([Gf.Quatf(3.0)]))
    UsdGeom.PointInstancer.Define(stage, "/Trees").CreateProtoIndicesAttr([7, 7])
    assert not told(errors_of(stage))
    animation.GetPrim().AddAppliedSchema(tokens.Schema.CLIP)
    assert set(told(errors_of(stage))) == {"MissingAttribute", "DuplicateJoints", "JointArrayLength"}


FAULTS = [
    (
        "JointArrayLength",
        f"{ANIMATION}.translations",
        lambda values, code: values[1:] if code == 7.0 else values,
        "at time code 7 for",
        "one a joint",
    ),
    ("MissingAttribute", f"{ANIMATION}.scales", lambda values, code: Sdf.ValueBlock(), "is not authored", "one entry"),
    (
        "DuplicateJoints",
        f"{ANIMATION}.joints",
        lambda values, code: put(values, 1, values[0]),
        "more than once",
        "once",
    ),
    (
        "RotationNotUnit",
        f"{ANIMATION}.rotations",
        lambda values, code: put(values, 3, values[3] * 1.5) if code == 9.0 else values,
        "at time code 9 has the length 1.5 (1 such",
        "unit quaternions",
    ),
    (
        "RotationSignChange",
        f"{ANIMATION}.rotations",
        lambda values, code: put(values, 3, -values[3]) if code >= 9.0 else values,
        "changes sign at time code 9 (1 such",
        "negate",
    ),
    (
        "ContactOutside",
        f"{ANIMATION}.{CONTACT.LIFTOFF_TIMES[1]}",
        lambda values, code: put(values, -1, Sdf.TimeCode(5000)),
        "of the right foot strikes at 357.8",
        "from 0 to 429",
    ),
    (
        "ContactOrder",
        f"{ANIMATION}.{CONTACT.FLAT_TIMES[0]}",
        lambda values, code: put(values, 2, Sdf.TimeCode(0)),
        "contact 2 of the left foot",
        "flat must follow strike",
    ),
    (
        "ContactArrayLength",
        f"{ANIMATION}.{CONTACT.POSITIONS[0]}",
        lambda values, code: values[1:],
        "11, 11, 11, 10",
        "one of each",
    ),
    (
        "FootstepOrder",
        f"{PLAN}.{tokens.Plan.STRIKE_TIMES}",
        lambda values, code: put(put(values, 4, values[5]), 5, values[4]),
        "footstep 5 strikes before footstep 4",
        "by strike time",
    ),
    (
        "PlanInconsistent",
        f"{PLAN}.{tokens.Plan.LIFTOFF_TIMES}",
        lambda values, code: values[1:],
        "liftoffTimes 20",
        "one entry a footstep in each",
    ),
    (
        "ResultLength",
        f"{PLAN}.{tokens.Result.SLIDE}",
        lambda values, code: values[1:],
        "has 20 entries",
        "21 would be right",
    ),
    (
        "FootOffFootstep",
        f"{PLAN}.positions",
        lambda values, code: put(values, 6, values[6] + Gf.Vec3f(0.0, 0.0, 0.02)),
        "footstep 6 (left) of /Crowd/Plans/Walker by 0.02 units, 20.0 mm",
        "animate the agent again",
    ),
    (
        "UnknownJoints",
        f"{ANIMATION}.joints",
        lambda values, code: put(values, len(values) - 1, "Tail"),
        "moves Tail, no joint of /Crowd/Agents/Walker",
        "as Skeleton.joints does",
    ),
]


@pytest.mark.parametrize(("name", "path", "edit", "what", "remedy"), FAULTS, ids=[fault[0] for fault in FAULTS])
def test_every_fault_is_found_once_and_named(crowd, name, path, edit, what, remedy):
    change(crowd, path, edit)
    found = told(errors_of(crowd))
    assert set(found) == {name}
    assert what in found[name] and remedy in found[name]
    prim = AGENT if name in ("FootOffFootstep", "UnknownJoints") else path.split(".")[0]
    assert found[name].startswith(prim)


def apply_fixers(stage, error):
    layer = stage.GetEditTarget()
    fixers = [fixer for fixer in error.GetFixersByErrorName() if fixer.CanApplyFix(error, layer)]
    return [fixer.name for fixer in fixers if fixer.ApplyFix(error, layer)]


MENDED = {
    "MissingAttribute": "AuthorScales",
    "RotationNotUnit": "NormaliseRotations",
    "RotationSignChange": "ContinueRotations",
}


@pytest.mark.parametrize("fault", [fault for fault in FAULTS if fault[0] in MENDED], ids=list(MENDED))
def test_a_fixer_mends_what_is_obvious(crowd, fault):
    name, path, edit, _, _ = fault
    change(crowd, path, edit)
    (error,) = [error for error in errors_of(crowd) if error.GetName() == name]
    assert apply_fixers(crowd, error) == [MENDED[name]]
    assert name not in told(errors_of(crowd))
    if name.startswith("Rotation"):
        assert not told(errors_of(crowd))
        right = Usd.Stage.Open(str(crowd.GetRootLayer().realPath))
        for code in (8.0, 10.0):
            mended, original = (np.array(s.GetAttributeAtPath(path).Get(code)) for s in (crowd, right))
            np.testing.assert_allclose(mended, original, atol=1e-6)


def test_footsteps_in_any_order_are_put_in_order_with_their_results(crowd):
    """All arrays shuffled together and mended are what they were."""
    prim = crowd.GetPrimAtPath(PLAN)
    order = np.random.default_rng(3).permutation(21)
    counts = list(prim.GetAttribute(tokens.Result.CLIP_COUNTS).Get())
    stops = np.cumsum(counts)
    rows = [row for step in order for row in range(stops[step] - counts[step], stops[step])]
    before = {}
    for name in prim.GetAuthoredPropertyNames():
        values = prim.GetAttribute(name).Get() if prim.GetAttribute(name) else None
        if hasattr(values, "__len__") and len(values) in (21, stops[-1]) and not isinstance(values, str):
            before[name] = list(values)
            picked = order if len(values) == 21 else rows
            prim.GetAttribute(name).Set(type(values)([values[int(i)] for i in picked]))
    assert len(before) > 10
    (error,) = [error for error in errors_of(crowd) if error.GetName() == "FootstepOrder"]
    assert apply_fixers(crowd, error) == ["OrderFootsteps"]
    assert not told(errors_of(crowd))
    assert {name: list(prim.GetAttribute(name).Get()) for name in before} == before


def test_late_liftoffs_are_mended_and_unequal_arrays_are_not(crowd):
    path = f"{PLAN}.{tokens.Plan.LIFTOFF_TIMES}"
    change(crowd, path, lambda values, code: put(values, 3, Sdf.TimeCode(0.0)))
    (error,) = [error for error in errors_of(crowd) if error.GetName() == "PlanInconsistent"]
    assert apply_fixers(crowd, error) == ["MendTimes"]
    assert "PlanInconsistent" not in told(errors_of(crowd))
    change(crowd, path, lambda values, code: values[1:])
    (error,) = [error for error in errors_of(crowd) if error.GetName() == "PlanInconsistent"]
    assert apply_fixers(crowd, error) == []


def test_a_fix_needs_a_layer_of_the_stage(crowd):
    change(crowd, f"{ANIMATION}.scales", lambda values, code: Sdf.ValueBlock())
    (error,) = errors_of(crowd)
    (fixer,) = error.GetFixersByErrorName()
    assert not fixer.CanApplyFix(error, Usd.EditTarget(Sdf.Layer.CreateAnonymous()))
    assert fixer.CanApplyFix(error, crowd.GetEditTarget())


def test_only_the_samples_of_the_time_range_are_looked_at(crowd):
    change(crowd, *FAULTS[3][1:3])
    context = UsdValidation.ValidationContext(validators())
    for interval, names in ((Gf.Interval(0.0, 8.0), set()), (Gf.Interval(9.0, 20.0), {"RotationNotUnit"})):
        errors = context.Validate(crowd, UsdValidation.ValidationTimeRange(interval))
        assert {error.GetName() for error in errors} == names


def test_without_its_footsteps_an_agent_promises_nothing(crowd):
    crowd.GetPrimAtPath(PLAN).SetActive(False)
    assert not told(errors_of(crowd))
