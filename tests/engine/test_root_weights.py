"""Steps that follow the root's velocity as well as their footsteps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from tests.engine.plans import crowd, mirrored, way
from tests.engine.synthesis import synthesise
from tests.engine.walkers import in_world
from usdfoot.engine.animate import PreparedLibraries, animate_agents, animate_crowd, prepare_library, prepare_steps
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import UsdfootError
from usdfoot.model.plan import FootstepPlan
from usdfoot.planning.followers import plan_followers
from usdfoot.readers.scene import read_scene

WEIGHTS = (0.0, 0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)
GRID = np.linspace(0.02, 1.0, 50)
both = pytest.mark.parametrize("beyond", ["segment", "closest"])


def uneven(count: int = 9) -> FootstepPlan:
    """A turning walk whose footsteps lie some centimetres off even ones."""
    plan = way(count, length=0.55, width=0.16, turn=0.04)
    noise = np.random.default_rng(3).uniform(-0.05, 0.05, (count, 3)) * [1.0, 0.0, 1.0]
    return replace(plan, positions=plan.positions + noise)


def weighted(plan: FootstepPlan, weights: float | np.ndarray) -> FootstepPlan:
    return replace(plan, root_weights=np.broadcast_to(np.asarray(weights, dtype=float), (len(plan),)).copy())


def assert_same(first, second) -> None:
    """Two motions with the same bytes."""
    for name in ("root_positions", "root_yaws", "pelvis_positions", "pelvis_rotations", "rotations"):
        assert getattr(first, name).tobytes() == getattr(second, name).tobytes()
    for name, values in vars(first.results).items():
        assert_array_equal(values, getattr(second.results, name))


def test_without_root_weight_nothing_changes_even_beside_agents_with_one(animate):
    plans = [uneven(), way(7, length=1.6)]
    before = animate(plans)
    beside = animate([*plans, weighted(uneven(), 0.6)])
    for first, second in zip(before, beside[:2], strict=True):
        assert_same(first, second)
    for first, second in zip(before, animate(plans, options=EngineOptions(root_weight=0.0)), strict=True):
        assert_same(first, second)
    assert not before[0].results.root_weight.any() and not before[0].results.beta.any()


@both
def test_the_error_grows_with_the_root_weight_and_contacts_never_slide(animate, beyond):
    motions = animate([weighted(uneven(), weight) for weight in WEIGHTS], options=EngineOptions(beyond_beta=beyond))
    results = [motion.results for motion in motions]
    for weight, own in zip(WEIGHTS, results, strict=True):
        assert own.slide.max() < 1e-3
        assert_allclose(own.root_weight, [0.0, *[weight] * 8])
    means = np.array([own.blend_error.mean() for own in results])
    assert np.all(np.diff(means) > -1e-4)
    assert means[-1] > 0.01 + means[0]


@both
@pytest.mark.parametrize("step", [1, 4, 7])
def test_the_error_of_a_step_never_falls_as_its_root_weight_rises(walker_library, beyond, step):
    """With the steps before it as they are, since a step starts where the last one landed."""
    weights = np.linspace(0.0, 1.0, 21)
    plans = [weighted(uneven(), np.where(np.arange(9) == step, weight, 0.0)) for weight in weights]
    steps = synthesise(walker_library, plans, options=EngineOptions(beyond_beta=beyond))
    segments, contacts = steps.setup.segments, steps.setup.contacts
    rows = np.flatnonzero(~segments.stands & (contacts.steps[segments.supports + 1] == step))
    errors = steps.landings.blend_error[rows]
    assert np.diff(errors).min() > -2.0 * EngineOptions().landing_tolerance
    assert errors[-1] > 0.01 + errors[0]


@both
def test_the_error_is_predicted(walker_library, beyond):
    plans = [weighted(plan, weight) for weight in WEIGHTS for plan in (uneven(), way(6, turn=0.3))]
    rooted = synthesise(walker_library, plans, options=EngineOptions(beyond_beta=beyond)).landings.rooted
    assert_allclose(rooted.predicted_errors, rooted.blend_errors, atol=1e-3)


def test_up_to_beta_the_footstep_is_kept_and_beyond_the_landing_becomes_the_contact(animate):
    motion = animate([uneven()], options=EngineOptions(root_weight=0.6), rate=60.0)[0]
    results = motion.results
    beyond = results.root_weight > results.beta + 1e-3
    assert 2 <= beyond.sum() <= 7
    assert {status for status, lost in zip(results.status, beyond, strict=True) if lost} == {"rootWeighted"}
    assert {status for status, lost in zip(results.status, beyond, strict=True) if not lost} <= {"ok", "outsideHull"}
    assert results.placement_error[~beyond].max() < 1e-3
    beyond &= results.hull_distance < 1e-6
    assert_allclose(results.placement_error[beyond], results.blend_error[beyond], atol=1e-3)


def test_at_one_only_the_root_examples_are_blended(walker_library):
    steps = synthesise(walker_library, [uneven()], options=EngineOptions(root_weight=1.0))
    rows = np.flatnonzero(~steps.setup.segments.stands)
    rooted = steps.landings.rooted
    assert_allclose(rooted.root_weights[rows], 1.0)
    assert steps.landings.velocity_error[rows].max() < 0.1
    lengths = steps.blend.weights[rows]
    assert lengths.min() >= 0.0 and (lengths > 0.0).sum(axis=1).max() <= 5
    assert_allclose(lengths.sum(axis=1), 1.0, atol=1e-12)


def test_an_even_walk_of_a_clip_keeps_its_footsteps_at_any_root_weight(animate):
    """Its root velocity is that of the clip, of which the step that lands where the plan has it is taken."""
    plan = way(8, length=0.55, width=0.18, step_time=0.5)
    for weight in (0.3, 1.0):
        results = animate([weighted(plan, weight)])[0].results
        assert results.blend_error[2:].max() < 0.03


def test_plans_weigh_steps_agents_the_others_and_options_all(walker_library):
    weights = np.linspace(0.0, 0.8, 9)
    scene = crowd(walker_library.source, [weighted(uneven(), weights), uneven()])
    agents = tuple(replace(agent, root_weight=0.4) for agent in scene.agents)
    first, second = animate_agents(walker_library, agents, scene, options=EngineOptions())
    assert_allclose(first.results.root_weight[1:], weights[1:])
    assert_allclose(second.results.root_weight[1:], 0.4)
    options = EngineOptions(root_weight=0.7)
    assert_allclose(animate_agents(walker_library, agents, scene, options=options)[0].results.root_weight[1:], 0.7)


@both
def test_the_largest_root_weight_within_a_tolerance_is_found(animate, beyond):
    last = np.zeros(9)
    for tolerance in (0.0, 0.01, 0.03):
        options = EngineOptions(root_weight_within=tolerance, beyond_beta=beyond)
        results = animate([uneven()], options=options, rate=60.0)[0].results
        assert results.placement_error.max() <= tolerance + 1e-4
        assert results.root_weight[1] > last[1] and results.root_weight.mean() > last.mean()
        last = results.root_weight
    capped = animate([uneven()], options=EngineOptions(root_weight_within=0.03, root_weight=0.2))[0].results
    assert capped.root_weight.max() == pytest.approx(0.2)


def test_near_corners_are_replaced_by_root_examples_that_still_reach_the_footstep(walker_library):
    scene = crowd(walker_library.source, [uneven()])
    agents = tuple(replace(agent, replace_distance=0.15) for agent in scene.agents)
    plain = animate_agents(walker_library, scene.agents, scene, options=EngineOptions())[0].results
    results = animate_agents(walker_library, agents, scene, options=EngineOptions())[0].results
    assert results.clips != plain.clips
    assert results.blend_error.mean() < 1e-3 and results.placement_error.max() < 1e-3


def test_the_mirrored_plan_gives_the_mirrored_motion(animate):
    plan = weighted(uneven(), 0.6)
    first, second = animate([plan])[0], animate([mirrored(plan)])[0]
    assert_allclose(second.results.blend_error, first.results.blend_error, atol=1e-4)
    assert_allclose(second.root_positions, first.root_positions * [-1.0, 1.0, 1.0], atol=1e-4)


def test_outside_the_hull_ik_pulls_less_the_more_the_root_weighs(animate):
    far = way(6, length=1.6)
    errors = [animate([weighted(far, weight)], reach=0.5)[0].results.placement_error[2] for weight in (1e-9, 0.5, 1.0)]
    assert errors[0] < errors[1] < errors[2]


def test_steps_of_more_than_four_examples_do_not_jump(animate, walker_library):
    """It moves on smoothly where more than four examples have weight."""
    steps = synthesise(walker_library, [uneven()], options=EngineOptions(root_weight=0.5))
    assert steps.blend.examples.shape[1] == 8
    assert (steps.blend.weights[:, 4] > 0.0).any()
    motion = animate([weighted(uneven(), 0.5)], rate=60.0)[0]
    world = in_world(walker_library.source, motion)
    assert np.abs(np.diff(world.pelvis, axis=0)).max() < 0.06


@pytest.mark.parametrize("scene", ["walk_flat.usda", "stepping_stones.usda"])
def test_real_steps_are_predicted_and_do_not_slide(shared_data, scene):
    crowd_ = read_scene(shared_data / "scenes" / scene).crowd
    means = []
    for weight in (0.0, 0.3, 0.6, 1.0):
        motions, _ = animate_crowd(crowd_, options=EngineOptions(root_weight=weight))
        assert motions[0].results.slide.max() < 1e-3
        means.append(motions[0].results.blend_error.mean())
    assert np.all(np.diff(means) > 0.0)


def rooted_everywhere(path, options: EngineOptions):
    """The root weights of a scene's first five agents at every 0.02 in one go, and which segments are steps."""
    crowd_, libraries = read_scene(path).crowd, PreparedLibraries(options)
    crowd_ = plan_followers(crowd_, options=options, libraries=libraries)[0]
    agents = [replace(agent, plan=weighted(agent.plan, weight)) for weight in GRID for agent in crowd_.agents[:5]]
    steps = prepare_steps(libraries.prepared(crowd_, 0), agents, crowd_, options=options)
    return steps.landings.rooted, np.flatnonzero(~steps.setup.segments.stands)


@pytest.mark.parametrize("scene", ["walk_flat.usda", "stepping_stones.usda", "crowd_zara.usda"])
def test_the_mean_error_of_real_scenes_never_falls_and_kept_footsteps_are_met(shared_data, scene):
    options = EngineOptions()
    rooted, rows = rooted_everywhere(shared_data / "scenes" / scene, options)
    errors, missed = rooted.blend_errors[rows], rooted.blend_errors[rows] - rooted.predicted_errors[rows]
    assert np.diff(errors.reshape(len(GRID), -1).mean(axis=1)).min() > -options.landing_tolerance
    assert np.abs(missed).max() < 1e-3
    kept = ~rooted.given_up[rows] & (rooted.hull_distances[rows] == 0.0)
    assert kept.any() and np.mean(errors[kept] > 1e-3) < 2e-3


def test_in_the_space_of_landing_and_root_speed_what_is_given_up_grows_whatever_was_missed_before(stages):
    """At high root weights the feet of this walk leave the stones, and footsteps the hull around the examples."""
    options = EngineOptions(space="3d")
    rooted, rows = rooted_everywhere(stages / "stepping_stones.usda", options)
    errors = rooted.blend_errors[rows].reshape(len(GRID), -1).mean(axis=1)
    assert np.diff(errors).min() > -options.landing_tolerance and errors[-1] > 0.1
    assert np.diff(rooted.betas[rows].reshape(len(GRID), -1), axis=0).max() < 1e-9


@pytest.mark.parametrize(("space", "agent"), [("3d", 12), ("delaunay", 1)])
def test_the_error_is_predicted_where_landings_turn_sharply(shared_data, space, agent):
    """A step of each of these walks lies where examples that land close together blend to land far apart."""
    options, grid = EngineOptions(space=space), np.linspace(0.02, 1.0, 50)
    crowd_ = read_scene(shared_data / "scenes" / "crowd_zara.usda").crowd
    libraries = PreparedLibraries(options)
    crowd_ = plan_followers(crowd_, options=options, libraries=libraries)[0]
    walker = crowd_.agents[agent]
    agents = [replace(walker, plan=weighted(walker.plan, weight)) for weight in grid]
    rooted = prepare_steps(libraries.prepared(crowd_, 0), agents, crowd_, options=options).landings.rooted
    assert_allclose(rooted.predicted_errors, rooted.blend_errors, atol=1e-3)


@pytest.mark.parametrize(
    ("about", "message"),
    [
        ({"root_weight": 1.5}, "root_weight: is 1.5. must be a number between 0 and 1"),
        ({"root_weight_within": -0.1}, "root_weight_within: is -0.1. must be 0 m or more"),
        ({"band": "round"}, "band: 'round' is not known. choose one of polar, cartesian"),
        ({"beyond_beta": "nearest"}, "beyond_beta: 'nearest' is not known. choose one of segment, closest"),
    ],
)
def test_options_out_of_range_are_refused(about, message):
    with pytest.raises(UsdfootError, match=message):
        EngineOptions(**about)


def test_the_space_of_landing_and_root_speed_keeps_footsteps_and_is_nearer_to_their_speed(walker_library):
    plans = [uneven(), way(8, length=0.6, step_time=0.42), way(8, length=0.45, step_time=0.6)]
    plain, solid = (
        synthesise(walker_library, plans, options=EngineOptions(space=space)).landings for space in ("delaunay", "3d")
    )
    assert solid.blend_error.mean() < 1e-3
    assert solid.velocity_error.mean() < plain.velocity_error.mean()


@both
def test_the_space_of_landing_and_root_speed_weighs_roots_too(animate, walker_library, beyond):
    """Footsteps are kept up to beta, the root velocity at 1; errors grow, are foreseen, and nothing slides."""
    weights = (0.0, 0.3, 0.6, 0.8, 0.9, 1.0)
    options = EngineOptions(space="3d", beyond_beta=beyond)
    plans = [weighted(uneven(), weight) for weight in weights]
    steps = synthesise(walker_library, plans, options=options)
    rooted, rows = steps.landings.rooted, ~steps.setup.segments.stands
    assert_allclose(rooted.predicted_errors[rows], rooted.blend_errors[rows], atol=1e-3)
    inside = rows & (rooted.root_weights <= rooted.betas) & (rooted.hull_distances == 0.0)
    assert inside.sum() > 10 and rooted.blend_errors[inside].max() < 1e-3
    assert steps.landings.velocity_error[rooted.root_weights == 1.0].max() < 0.1
    lengths = steps.blend.weights[rows]
    assert lengths.min() >= 0.0
    assert_allclose(lengths.sum(axis=1), 1.0, atol=1e-12)
    results = [motion.results for motion in animate(plans, options=options)]
    assert max(own.slide.max() for own in results) < 1e-3
    means = np.array([own.blend_error.mean() for own in results])
    assert np.all(np.diff(means) > -1e-3) and means[-1] > 0.01 + means[0]
    assert "rootWeighted" not in results[1].status and "rootWeighted" in results[-1].status


def test_in_the_space_of_landing_and_root_speed_agents_are_weighed_alike_alone_and_together(walker_library):
    options, plans = EngineOptions(space="3d"), [weighted(uneven(), 0.6), weighted(way(8, length=0.6), 0.3)]
    together = synthesise(walker_library, plans, options=options)
    for agent, plan in enumerate(plans):
        alone, rows = synthesise(walker_library, [plan], options=options), together.setup.segments.agents == agent
        assert_array_equal(together.blend.weights[rows], alone.blend.weights)
        assert_array_equal(together.landings.blend_error[rows], alone.landings.blend_error)


def test_in_the_space_of_landing_and_root_speed_the_largest_root_weight_keeps_the_tolerance(animate):
    options = EngineOptions(space="3d", root_weight_within=0.02)
    results = animate([uneven()], options=options, rate=60.0)[0].results
    assert results.placement_error.max() <= 0.02 + 1e-3
    assert results.root_weight.mean() > 0.3


def test_cartesian_bands_keep_root_velocities_in_their_own_way(walker_library):
    options = EngineOptions(band="cartesian")
    plan = weighted(uneven(), 1.0)
    polar = synthesise(walker_library, [plan]).landings
    cartesian = synthesise(prepare_library(walker_library.source, options), [plan], options=options).landings
    assert cartesian.velocity_error.max() < 0.1
    assert not np.allclose(cartesian.velocity_error, polar.velocity_error, atol=1e-6)
