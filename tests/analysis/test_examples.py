"""Examples against the analytic walker's footsteps, and rules they must keep."""

from dataclasses import fields, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.builders import Gait, build_walker, with_clip
from usdfoot.analysis.examples import build_examples
from usdfoot.analysis.mirror import mirror_map, mirrored_rotations
from usdfoot.analysis.motion import moved
from usdfoot.analysis.steps import StepLimits
from usdfoot.maths import planar, quaternion
from usdfoot.model.clip import ClipLibrary
from usdfoot.model.examples import Examples
from usdfoot.model.skeleton import forward_kinematics


def assert_same_examples(first: Examples, second: Examples, *, atol: float, but: tuple[str, ...] = ()) -> None:
    for field in fields(Examples):
        values = getattr(first, field.name)
        if isinstance(values, np.ndarray) and field.name not in but:
            assert_allclose(values, getattr(second, field.name), atol=atol, err_msg=field.name)


@pytest.mark.parametrize(
    "gait",
    [Gait(), Gait(step_length=-0.4, heel_strike=False), Gait(sideways=0.15), Gait(step_time=0.35, duty=0.32)],
    ids=["walk", "backward", "diagonal", "run"],
)
def test_steps_land_where_the_walker_put_its_feet(gait: Gait) -> None:
    walker = build_walker(gait, rate=60.0)
    examples, _ = build_examples(walker.library, mirror=False)
    assert len(examples) >= 5
    towards = np.where(examples.swing_sides == 0, 1.0, -1.0) * gait.step_width
    expected = np.stack([gait.sideways + towards, np.full(len(examples), gait.step_length)], axis=1)
    assert_allclose(examples.landings, expected, atol=4e-3)
    assert_allclose(examples.departures, expected * [1.0, -1.0] - [2.0 * gait.sideways, 0.0], atol=4e-3)
    assert_allclose(examples.durations, gait.step_time, atol=0.5 / 60.0)
    duration = 2.0 * gait.duty * gait.step_time
    assert_allclose(examples.support_liftoffs[:-1], duration, atol=0.75 / 60.0)
    assert_allclose(examples.swing_liftoffs[1:], duration - gait.step_time, atol=0.75 / 60.0)
    assert_allclose(examples.landing_heights, 0.0, atol=2e-3)
    assert_allclose(examples.turns, 0.0, atol=2e-3)


def with_thigh_twist(library: ClipLibrary) -> ClipLibrary:
    """The library with a joint in the middle of each thigh, which turns about the bone."""
    skeleton, biped, clip = library.skeleton, library.biped, library.clips[0]
    rows = list(range(len(skeleton.joints)))
    for knee in sorted(biped.knees, reverse=True):
        rows.insert(knee, knee)
    new = {old: rows.index(old) + (1 if old in biped.knees else 0) for old in range(len(skeleton.joints))}
    twists = [new[knee] - 1 for knee in biped.knees]
    parents = np.array([-1 if skeleton.parents[old] < 0 else new[int(skeleton.parents[old])] for old in rows])
    for twist, hip in zip(twists, biped.hips, strict=True):
        parents[twist], parents[twist + 1] = new[hip], twist
    names = [f"twist{i}" if i in twists else skeleton.joints[old] for i, old in enumerate(rows)]

    def split(translations: np.ndarray) -> np.ndarray:
        longer = translations[..., rows, :].copy()
        longer[..., twists, :] *= 0.5
        longer[..., [new[knee] for knee in biped.knees], :] *= 0.5
        return longer

    def straight(rotations: np.ndarray) -> np.ndarray:
        longer = rotations[..., rows, :].copy()
        longer[..., twists, :] = [0.0, 0.0, 0.0, 1.0]
        return longer

    roles = {role: tuple(new[joint] for joint in getattr(biped, role)) for role in ("hips", "knees", "ankles", "balls")}
    return ClipLibrary(
        skeleton=replace(
            skeleton,
            joints=tuple(names),
            parents=parents,
            rest_translations=split(skeleton.rest_translations),
            rest_rotations=straight(skeleton.rest_rotations),
        ),
        biped=replace(biped, pelvis=new[biped.pelvis], **roles),
        clips=(replace(clip, translations=split(clip.translations), rotations=straight(clip.rotations)),),
    )


def test_twist_joints_in_the_thighs_change_nothing() -> None:
    library = build_walker(Gait(), rate=60.0).library
    plain, _ = build_examples(library, mirror=False)
    twisted, _ = build_examples(with_thigh_twist(library), mirror=False)
    for name in ("landings", "departures", "durations", "landing_heights", "support_balls", "swing_balls"):
        assert_allclose(getattr(twisted, name), getattr(plain, name), atol=1e-5, err_msg=name)


def test_an_authored_leg_length_scales_no_clip() -> None:
    library = build_walker(Gait(), rate=60.0).library
    plain, _ = build_examples(library, mirror=False)
    biped = replace(library.biped, maximal_leg_length=1.1 * library.biped.maximal_leg_length)
    longer, _ = build_examples(replace(library, biped=biped), mirror=False)
    assert_allclose(longer.landings, plain.landings, atol=1e-6)
    assert_allclose(longer.pelvis_positions, plain.pelvis_positions, atol=1e-5)


def test_turns_and_stairs() -> None:
    walker = build_walker(Gait(turn=0.25, rise=0.15, step_time=0.6, clearance=0.2), rate=60.0)
    examples, _ = build_examples(walker.library, mirror=False)
    assert_allclose(examples.turns, 0.25, atol=0.01)
    assert_allclose(examples.landing_heights, 0.15, atol=2e-3)
    assert_allclose(examples.landing_yaws - examples.support_yaws, 0.25, atol=0.01)
    # The ground line rises by one step from phase 0 to 1, so the planted ball sinks against it, through its height.
    expected = 0.04 + 0.15 * (0.5 - np.linspace(0.0, 1.0, 64))[20:50]
    assert_allclose(examples.support_balls[:, 20:50, 1], np.broadcast_to(expected, (len(examples), 30)), atol=2e-3)


def test_support_ball_stands_at_the_origin() -> None:
    walker = build_walker(Gait(turn=0.1))
    examples, _ = build_examples(walker.library)
    planted = examples.support_balls[:, 20:50]
    assert_allclose(planted[..., [0, 2]], 0.0, atol=2e-3)
    assert_allclose(planted[..., 1], walker.library.biped.ball_heights[0], atol=2e-3)
    assert_allclose(examples.swing_balls[:, -1, [0, 2]], examples.landings, atol=0.08)


def test_balls_are_the_characters_forward_kinematics() -> None:
    walker = build_walker(Gait(), twisted=True)
    skeleton, biped = walker.library.skeleton, walker.library.biped
    examples, _ = build_examples(walker.library)
    for i in range(len(examples)):
        translations = np.repeat(skeleton.rest_translations[None], 64, axis=0)
        translations[:, biped.pelvis] = examples.pelvis_positions[i]
        parents = skeleton.parents.copy()
        parents[biped.pelvis] = -1
        positions, _ = forward_kinematics(parents, translations, examples.rotations[i].astype(float))
        support = biped.balls[1 - examples.swing_sides[i]]
        assert_allclose(positions[:, support], examples.support_balls[i], atol=1e-5)


@pytest.mark.parametrize("twisted", [False, True])
def test_mirrored_examples_are_exact_mirrors(twisted: bool) -> None:
    walker = build_walker(Gait(turn=0.2, sideways=0.1), twisted=twisted)
    examples, _ = build_examples(walker.library)
    plain, image = np.flatnonzero(~examples.mirrored), np.flatnonzero(examples.mirrored)
    assert len(plain) == len(image) > 0
    assert (examples.swing_sides[plain] == 1 - examples.swing_sides[image]).all()
    for name in ("durations", "flat_times", "swing_liftoffs", "support_liftoffs", "landing_heights"):
        assert_allclose(getattr(examples, name)[plain], getattr(examples, name)[image], atol=1e-9)
    for name in ("landings", "departures"):
        assert_allclose(getattr(examples, name)[plain], getattr(examples, name)[image] * [-1.0, 1.0], atol=1e-7)
    for name in ("landing_yaws", "support_yaws", "departure_yaws", "turns"):
        assert_allclose(getattr(examples, name)[plain], -getattr(examples, name)[image], atol=1e-7)
    for name in ("pelvis_positions", "support_balls", "swing_balls"):
        assert_allclose(
            getattr(examples, name)[plain], getattr(examples, name)[image] * np.float32([-1, 1, 1]), atol=1e-6
        )
    mirror = mirror_map(walker.library.skeleton, walker.library.biped)
    pelvis = walker.library.biped.pelvis
    expected = mirrored_rotations(examples.rotations[plain].astype(float), mirror)
    expected[..., pelvis, :] = quaternion.compose(
        quaternion.mirror_x(examples.rotations[plain][..., pelvis, :].astype(float)), mirror.relations[pelvis]
    )
    below = [j for j in range(len(walker.library.skeleton.joints)) if j >= pelvis]
    alike = np.abs(np.sum(expected * examples.rotations[image], axis=-1))[..., below]
    assert_allclose(alike, 1.0, atol=1e-6)


def test_moved_clip_gives_the_same_examples() -> None:
    walker = build_walker(Gait(turn=0.1))
    clip = moved(walker.clip, walker.library.skeleton, positions=np.array([5.0, -3.0]), yaws=np.array(2.5))
    before, _ = build_examples(walker.library, mirror=False)
    after, _ = build_examples(replace(walker.library, clips=(clip,)), mirror=False)
    assert_same_examples(before, after, atol=1e-6, but=("rotations",))
    assert_allclose(np.abs(np.sum(before.rotations * after.rotations, axis=-1)), 1.0, atol=1e-5)


def test_rotations_keep_their_sign_and_length() -> None:
    walker = build_walker(Gait(turn=0.4), twisted=True)
    examples, _ = build_examples(walker.library)
    assert_allclose(np.linalg.norm(examples.rotations, axis=-1), 1.0, atol=1e-6)
    assert (np.sum(examples.rotations[:, 1:] * examples.rotations[:, :-1], axis=-1) > 0.9).all()


def test_clip_of_other_proportions_is_scaled_by_its_legs() -> None:
    small, large = build_walker(size=0.5), build_walker()
    library = replace(large.library, clips=(small.clip,))
    scaled, _ = build_examples(library, mirror=False)
    expected, _ = build_examples(large.library, mirror=False)
    assert_same_examples(scaled, expected, atol=2e-3)


def test_resampled_clip_gives_the_same_steps() -> None:
    coarse, _ = build_examples(build_walker(rate=30.0).library, mirror=False)
    fine, _ = build_examples(build_walker(rate=120.0).library, mirror=False)
    assert_allclose(coarse.landings, fine.landings, atol=3e-3)
    assert_allclose(coarse.durations, fine.durations, atol=0.01)
    assert_allclose(coarse.pelvis_positions, fine.pelvis_positions, atol=0.01)


@pytest.mark.parametrize("in_place", [False, True])
def test_single_loop_gives_its_two_steps(in_place: bool) -> None:
    walker = build_walker(Gait(), loop=True, in_place=in_place, rate=60.0)
    examples, problems = build_examples(walker.library, mirror=False)
    assert not problems
    assert sorted(examples.swing_sides.tolist()) == [0, 1]
    width = np.where(examples.swing_sides == 0, 0.16, -0.16)
    assert_allclose(examples.landings, np.stack([width, [0.6, 0.6]], axis=1), atol=0.01)
    assert_allclose(examples.durations, 0.5, atol=0.01)


@pytest.mark.parametrize("phase", np.linspace(0.0, 0.9, 7))
def test_range_of_one_stride_gives_two_steps(phase: float) -> None:
    walker = build_walker(footsteps=10, rate=60.0)
    start = 1.3 + phase
    library = with_clip(walker, range_start=start, range_end=start + 1.0)
    examples, _ = build_examples(library, mirror=False)
    assert len(examples) == 2


def test_long_steps_jumps_and_hops_are_dropped_with_a_reason() -> None:
    walker = build_walker(Gait(), rate=60.0)
    examples, problems = build_examples(walker.library, mirror=False, limits=StepLimits(longest=0.4))
    assert len(examples) == 0
    assert "a stand of 0.5 s" in problems[0].message
    assert "no usable step in its range: author usdfoot:clip:start" in problems[-1].message
    examples, problems = build_examples(walker.library, mirror=False, limits=StepLimits(reach=0.5))
    assert len(examples) == 0
    assert "lands 0.62 m away, " in problems[0].message and " times the legs' length, " in problems[0].message


def test_what_the_body_flies_is_no_reach_of_its_legs() -> None:
    """A cartoon's run: steps of three legs, of which the body flies more than half."""
    walker = build_walker(Gait(step_time=0.4, step_length=2.6, duty=0.2), rate=60.0)
    examples, problems = build_examples(walker.library, mirror=False)
    assert len(examples) == 6 and len(problems) == 1  # the first step's foot comes from nowhere
    assert np.linalg.norm(examples.landings, axis=1).min() > 2.5
    examples, problems = build_examples(walker.library, mirror=False, limits=StepLimits(rise=0.01))
    assert len(examples) == 0  # nobody flies so long without rising: contacts were not found
    assert "lands 2.60 m away, 3.2 times the legs' length, 2.2 at most" in problems[1].message


def test_clip_that_asks_for_no_mirror_image_gets_none() -> None:
    walker = build_walker()
    examples, _ = build_examples(with_clip(walker, mirror=False))
    assert len(examples) > 0
    assert not examples.mirrored.any()


def test_styles_and_names_follow_their_clips() -> None:
    walker = build_walker()
    clips = (replace(walker.clip, name="/A", style="old"), replace(walker.clip, name="/B"))
    library = ClipLibrary(skeleton=walker.library.skeleton, biped=walker.library.biped, clips=clips)
    examples, _ = build_examples(library)
    assert examples.clip_names == ("/A", "/B")
    assert {examples.styles[i] for i in np.flatnonzero(examples.clip_indices == 0)} == {"old"}
    assert {examples.styles[i] for i in np.flatnonzero(examples.clip_indices == 1)} == {"default"}


def test_clips_analysed_together_give_the_examples_of_each_alone() -> None:
    walkers = [build_walker(gait, rate=rate) for gait, rate in ((Gait(), 30.0), (Gait(step_length=-0.4), 120.0))]
    short = replace(
        walkers[0].clip, **{name: getattr(walkers[0].clip, name)[:3] for name in ("translations", "rotations")}
    )
    in_place = replace(walkers[0].clip, root_motion="inPlace")
    clips = tuple(
        replace(clip, name=f"/Clip_{number}", mirror=number != 1)
        for number, clip in enumerate((walkers[0].clip, walkers[1].clip, short, in_place))
    )
    library = replace(walkers[0].library, clips=clips)
    together, problems = build_examples(library)
    alone = [build_examples(replace(library, clips=(clip,))) for clip in clips]
    assert problems == [problem for _, faults in alone for problem in faults]
    assert list(together.clip_indices) == [index for index, (part, _) in enumerate(alone) for _ in range(len(part))]
    assert list(together.mirrored) == [flag for part, _ in alone for flag in part.mirrored]
    for name in ("start_times", "landings", "rotations", "pelvis_positions", "swing_balls"):
        assert_allclose(getattr(together, name), np.concatenate([getattr(part, name) for part, _ in alone]), atol=1e-6)


def test_no_clips_give_no_examples() -> None:
    walker = build_walker()
    examples, problems = build_examples(replace(walker.library, clips=()))
    assert len(examples) == 0
    assert not problems
    assert examples.rotations.shape == (0, 64, len(walker.library.skeleton.joints), 4)


def test_heading_is_the_mean_of_both_feet() -> None:
    walker = build_walker(Gait(turn=0.3))
    examples, _ = build_examples(walker.library)
    middle = planar.circular_mean(np.stack([examples.support_yaws, examples.departure_yaws], axis=1))
    assert_allclose(middle, 0.0, atol=1e-9)


def test_clip_that_only_stands_is_no_fault_but_one_that_ends_in_a_swing_is() -> None:
    walker = build_walker(rate=60.0)
    both = int(60.0 * walker.contacts.left.strike_times[2]) + 4  # after this strike the other foot stands for a while
    still = replace(
        walker.clip,
        name="still",
        translations=np.repeat(walker.clip.translations[both : both + 1], 60, axis=0),
        rotations=np.repeat(walker.clip.rotations[both : both + 1], 60, axis=0),
    )
    cut = replace(
        walker.clip, name="cut", translations=walker.clip.translations[:40], rotations=walker.clip.rotations[:40]
    )
    library = replace(walker.library, clips=(walker.clip, still, cut))
    _, problems = build_examples(library)
    assert [problem.where for problem in problems if "no usable step" in problem.message] == ["cut"]
