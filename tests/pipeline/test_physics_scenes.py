"""The results of van de Panne 1997 in `stages/`, animated without clips and measured on what is written."""

from __future__ import annotations

import json

import numpy as np
import pytest
from pxr import Sdf, Usd

from usdfoot.bridge.tokens import Agent as Token
from usdfoot.maths import quaternion
from usdfoot.model.tuning import BodyTuning
from usdfoot.physics.animate import plan_bodies, prepare_body
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.validate import validate
from usdfoot.readers.joint_tracks import read_joint_tracks
from usdfoot.readers.scene import read_scene
from usdfoot.readers.written import read_agent, read_written_crowd

SCENES = ("bird_walk", "dinosaur_stairs", "dinosaur_leaps", "human_run", "bird_tracks")
RATE = 240.0


@pytest.fixture(scope="module")
def written(stages, tmp_path_factory):
    folder = tmp_path_factory.mktemp("physics")
    for name in SCENES:
        assert not animate(stages / f"physics_{name}.usda", folder / name).skipped
    return folder


class Body:
    """One scene's agent: its plan, what carries it, and its optimised centre of mass."""

    def __init__(self, stages, name, options=None):
        options = options or MotionOptions()
        crowd = read_scene(stages / f"physics_{name}.usda", tuning=options.tuning).crowd
        self.plan, tuning = crowd.agents[0].plan, crowd.agents[0].tuning
        options = options.tuned(tuning)
        body = prepare_body(crowd.libraries[0], options, tuning)
        self.planting, self.com = plan_bodies(body, crowd.agents, crowd, options=options)
        self.times = np.arange(self.plan.strike_times[0], self.plan.liftoff_times.max(), 1.0 / RATE)

    def sample(self, times):
        return self.com.evaluate(np.zeros(len(times), dtype=int), times)

    def flights(self):
        """Begin and end of every flight between two footsteps [s], shape (K, 2)."""
        gaps = np.stack([self.plan.liftoff_times[:-1], self.plan.strike_times[1:]], axis=1)
        return gaps[gaps[:, 1] - gaps[:, 0] > 0.02]


@pytest.mark.parametrize("name", SCENES)
def test_every_figure_is_within_its_target(written, name):
    validation = validate(written / name / "crowd.usd")
    failed = [(figure.name, figure.value) for figure in validation.total.figures if not figure.passed]
    assert not failed and validation.passed


def test_reports_carry_what_physics_asks(written):
    steps = json.loads((written / "dinosaur_leaps" / "report.json").read_text())["agents"][0]["steps"]
    assert len(steps["forceImbalance"]) == len(steps["clampTime"]) == len(steps["jumpHeight"]) == len(steps["status"])
    plan = read_agent(read_written_crowd(written / "dinosaur_leaps" / "crowd.usd"), "Walker")
    assert len(plan.status) == len(steps["status"])


@pytest.mark.parametrize("name", ["bird_walk", "dinosaur_leaps"])
def test_knees_bend_as_the_rest_pose_bends_them(written, name):
    agent = read_agent(read_written_crowd(written / name / "crowd.usd"), "Walker")
    crowd = read_written_crowd(written / name / "crowd.usd")
    tracks = read_joint_tracks(agent, crowd.units, agent.frame_codes)
    hips, knees, ankles = (
        tracks.positions[:, list(j)] for j in (agent.biped.hips, agent.biped.knees, agent.biped.ankles)
    )
    ahead = tracks.positions[:, list(agent.biped.balls)].mean(axis=1) - ankles.mean(axis=1)
    bend = np.einsum("fsi,fi->fs", knees - 0.5 * (hips + ankles), ahead)
    assert (bend < 0.0).all() if name == "bird_walk" else (bend > 0.0).all()


def test_flights_are_parabolas_with_an_anticipation_before_them(stages, written):
    body = Body(stages, "dinosaur_leaps")
    flights = body.flights()
    assert len(flights) == 2
    heights = []
    for begin, end in flights:
        inside = np.linspace(begin, end, 50)[1:-1]
        np.testing.assert_allclose(body.sample(inside).accelerations, [[0.0, -9.81, 0.0]] * 48, atol=0.0981)
        before = body.sample(np.linspace(begin - 0.75, begin, 200)).positions[:, 1]
        lowest = before.argmin()
        assert before[:lowest].max() - before[lowest] > 0.02  # the body sinks,
        assert before[-1] - before[lowest] > 0.1  # then pushes off
        jump = body.sample(inside).positions[:, 1].max() - body.sample(np.array([begin])).positions[0, 1]
        heights.append(jump)
        assert jump == pytest.approx(9.81 * (end - begin) ** 2 / 8.0, rel=0.25)
    assert heights[0] > 2.0 * heights[1]


def test_the_written_body_falls_freely_too(stages, written):
    """The centre of mass carried by the pelvis joint of the file, in the middle of the flights."""
    crowd = read_written_crowd(written / "dinosaur_leaps" / "crowd.usd")
    agent = read_agent(crowd, "Walker")
    com = Body(stages, "dinosaur_leaps").com
    begin, end = Body(stages, "dinosaur_leaps").flights()[0]
    frames = agent.frame_codes[(agent.frame_codes > 30.0 * begin + 2.0) & (agent.frame_codes < 30.0 * end - 2.0)]
    tracks = read_joint_tracks(agent, crowd.units, frames)
    turns = quaternion.compose(tracks.turns([agent.biped.pelvis])[:, 0], quaternion.inverse(com.biped.pelvis_rotation))
    places = tracks.positions[:, agent.biped.pelvis] - quaternion.rotate(turns, com.biped.pelvis)
    fall = 2.0 * np.polyfit(frames / 30.0, places[:, 1], 2)[0]
    assert fall == pytest.approx(-9.81, rel=0.01)


def test_the_dinosaur_climbs_turning_about_the_stairs(stages, written):
    body = Body(stages, "dinosaur_stairs")
    places = body.sample(body.times).positions
    assert np.ptp(places[:, 1]) == pytest.approx(18 * 0.18, abs=0.15)
    radii = np.hypot(places[:, 0] - 3.0, places[:, 2])[len(places) // 5 : -len(places) // 5]
    assert np.abs(radii - 3.0).max() < 0.3
    climb = places[len(places) // 5 : -len(places) // 5, 1]
    assert np.diff(climb).min() > -0.002  # never down by much


def test_flights_of_the_run_are_short_and_flat(stages, written):
    body = Body(stages, "human_run")
    flights = body.flights()
    assert len(flights) >= 10
    assert np.ptp(body.plan.positions[:, 1]) > 0.2
    report = json.loads((written / "human_run" / "report.json").read_text())
    assert max(report["agents"][0]["steps"]["jumpHeight"]) < 0.06


def test_timing_alone_gives_two_small_leaps(stages, written):
    body = Body(stages, "bird_tracks")
    lengths = np.linalg.norm(np.diff(body.plan.positions, axis=0), axis=1)
    leaps = body.plan.liftoff_times[:-1] < body.plan.strike_times[1:]
    assert leaps.sum() == 2
    assert lengths[leaps].min() > 1.5 * lengths[~leaps].max()


def test_agents_are_tuned_in_the_scene(stages, written, tmp_path):
    layer = Sdf.Layer.CreateNew(str(tmp_path / "tuned.usda"))
    layer.subLayerPaths = [str(stages / "physics_bird_walk.usda")]
    stage = Usd.Stage.Open(layer)
    for copy in ("metersPerUnit", "upAxis", "timeCodesPerSecond"):
        stage.SetMetadata(copy, Sdf.Layer.FindOrOpen(layer.subLayerPaths[0]).pseudoRoot.GetInfo(copy))
    prim = stage.OverridePrim("/World/Walker")
    for name, value in ((Token.HIP_SPACING, 1.6), (Token.CROUCH, 0.12)):
        prim.CreateAttribute(name, Sdf.ValueTypeNames.Float, False).Set(value)
    layer.Save()
    report = animate(layer.realPath, tmp_path / "run")
    assert not report.skipped and report.results["Walker"].placement_error.max() < 1e-3
    apart, heights = [], []
    for crowd_file in (written / "bird_walk" / "crowd.usd", tmp_path / "run" / "crowd.usd"):
        crowd = read_written_crowd(crowd_file)
        agent = read_agent(crowd, "Walker")
        places = read_joint_tracks(agent, crowd.units, agent.frame_codes).positions
        hips = places[:, list(agent.biped.hips)]
        apart.append(np.linalg.norm(hips[:, 0] - hips[:, 1], axis=1))
        heights.append(hips[..., 1].mean())
    np.testing.assert_allclose(apart[1], 1.6 * apart[0][0], rtol=1e-4)
    assert heights[0] - heights[1] > 0.04
    assert validate(tmp_path / "run" / "crowd.usd").passed


def test_less_gravity_a_crouch_and_wider_hips_show(stages):
    usual = Body(stages, "bird_walk")
    height = usual.sample(usual.times).positions[:, 1].mean()
    crouched = MotionOptions(tuning=BodyTuning(crouch=0.12))
    low = Body(stages, "bird_walk", crouched)
    assert height - low.sample(low.times).positions[:, 1].mean() > 0.04
