"""Far agents are sampled in turns, and their feet stand all the same."""

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdGeom

from tests.batch.conftest import AGENTS
from tests.digests import digests
from usdfoot.errors import SceneError, UsdfootError
from usdfoot.model.ground import Ground
from usdfoot.model.sampling import SamplingOptions
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.pipeline.animate import animate
from usdfoot.pipeline.measures import measure_agent
from usdfoot.pipeline.validate import validate
from usdfoot.readers.written import read_agent, read_written_crowd

NAMES = [f"Agent_{number}" for number in range(AGENTS)]
AWAY = 1e5
"""Where the camera stands beside the row of agents [m]."""


def every(count, **camera):
    return MotionOptions(sampling=SamplingOptions(every=count, **camera))


def layer_over(scene, path, rate):
    """A scene at another rate over the one given, with a camera far beside its agents."""
    layer = Sdf.Layer.CreateNew(str(path))
    layer.subLayerPaths = [str(scene)]
    source = Usd.Stage.Open(str(scene))
    stage = Usd.Stage.Open(layer)
    stage.SetTimeCodesPerSecond(rate)
    UsdGeom.SetStageMetersPerUnit(stage, UsdGeom.GetStageMetersPerUnit(source))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.GetStageUpAxis(source))
    camera = UsdGeom.Camera.Define(stage, "/World/Camera")
    camera.AddTranslateOp().Set((-AWAY, 0.0, 0.0))
    stage.Save()
    return path


def anim_text(folder, name):
    """Everything written of an agent's animation and of its prim."""
    stage = Usd.Stage.Open(str(folder / "crowd.usd"))
    layer = Sdf.Layer.CreateAnonymous(".usda")
    for number, scope in enumerate(("Anims", "Agents")):
        prim = stage.GetPrimAtPath(f"/Crowd/{scope}/{name}")
        source = next(spec for spec in prim.GetPrimStack() if spec.specifier == Sdf.SpecifierDef)
        Sdf.CopySpec(source.layer, source.path, layer, f"/Copy{number}")
    return layer.ExportToString()


def sample_codes(folder, name):
    """Time codes of an agent's joints; its root and extent have the same."""
    stage = Usd.Stage.Open(str(folder / "crowd.usd"))
    anim, agent = (stage.GetPrimAtPath(f"/Crowd/{scope}/{name}") for scope in ("Anims", "Agents"))
    codes = anim.GetAttribute("rotations").GetTimeSamples()
    assert anim.GetAttribute("translations").GetTimeSamples() == codes
    for attribute in ("xformOp:translate", "extent"):
        assert agent.GetAttribute(attribute).GetTimeSamples() == codes
    return np.array(codes)


def left_out(codes):
    """Whole codes without a sample."""
    return np.setdiff1d(np.arange(codes[0], codes[-1] + 1.0), codes)


@pytest.fixture(scope="module")
def far(crowd_scene, tmp_path_factory):
    """The crowd, all of it far, each agent a chunk."""
    return animate(crowd_scene, tmp_path_factory.mktemp("far") / "out", chunk_size=1, options=every(2))


def test_agents_take_turns(crowd, far):
    turns = []
    for name in NAMES:
        codes, full = (sample_codes(report.crowd_file.parent, name) for report in (far, crowd))
        gone = left_out(codes)
        assert len(gone) > 0.2 * len(full) and set(codes) <= set(full)
        assert (codes[0], codes[-1]) == (full[0], full[-1])
        turns.append(int(gone[0]) % 2)
        assert np.all(gone % 2 == turns[-1])
    assert set(turns) == {0, 1}


def test_there_are_samples_beside_all_events(far):
    stage = Usd.Stage.Open(str(far.crowd_file))
    for name in NAMES:
        anim = stage.GetPrimAtPath(f"/Crowd/Anims/{name}")
        codes = sample_codes(far.crowd_file.parent, name)
        for side in ("left", "right"):
            for event in ("strike", "flat", "liftoff"):
                times = np.array(
                    [float(code) for code in anim.GetAttribute(f"usdfoot:contact:{side}:{event}Times").Get()]
                )
                assert np.isin(np.concatenate([np.floor(times + 1e-6), np.ceil(times - 1e-6)]), codes).all()


def test_planted_feet_stand_at_all_frames_and_what_is_recorded_is_what_is_seen(crowd, far):
    figures = {figure.name: figure for figure in validate(far.crowd_file).total.figures}
    assert 0.1 < figures["slide"].value <= 1.0
    assert all(figure.passed for figure in figures.values())
    before, written = (read_written_crowd(report.crowd_file) for report in (crowd, far))
    for name in NAMES:
        full, seen = (
            measure_agent(read_agent(source, name), source.units, Ground(source.terrain))
            for source in (before, written)
        )
        np.testing.assert_allclose(far.results[name].slide, seen.slide, atol=2e-5)
        assert seen.knee_speed <= 1.001 * full.knee_speed and seen.joint_jerk <= 1.1 * full.joint_jerk


def test_another_process_makes_the_same_bytes(crowd_scene, far, worker, tmp_path):
    animate(crowd_scene, tmp_path / "out", chunk_size=1, options=every(2), executor=worker)
    assert digests(tmp_path / "out") == digests(far.crowd_file.parent)


def test_near_agents_are_as_before_whatever_the_chunk(crowd_scene, crowd, far, tmp_path):
    scene = layer_over(crowd_scene, tmp_path / "seen.usda", 30.0)
    stage = Usd.Stage.Open(str(scene))
    positions = stage.GetPrimAtPath("/World/Crowd/Plan_0").GetAttribute("positions").Get()
    near = AWAY + 0.25 + min(float(point[0]) for point in positions)
    whole = animate(scene, tmp_path / "out", options=every(2, near=near, camera="/World/Camera"))
    folders = [report.crowd_file.parent for report in (whole, crowd, far)]
    mixed, before, thinned = ([sample_codes(folder, name) for name in NAMES] for folder in folders)
    assert np.array_equal(mixed[0], before[0]) and np.array_equal(mixed[2], thinned[2])
    alone = animate(scene, tmp_path / "alone", chunk_size=1, options=every(2, near=near, camera="/World/Camera"))
    assert anim_text(alone.crowd_file.parent, NAMES[0]) == anim_text(folders[1], NAMES[0])


def test_at_high_rates_nearly_every_fourth_frame_is_left(crowd_scene, tmp_path):
    scene = layer_over(crowd_scene, tmp_path / "fine.usda", 240.0)
    report = animate(scene, tmp_path / "out", agents=NAMES[1], options=every(4))
    codes = sample_codes(report.crowd_file.parent, NAMES[1])
    assert 0.25 < len(codes) / (codes[-1] - codes[0] + 1.0) < 0.35
    assert max(report.results[NAMES[1]].slide) <= 1e-3


def test_what_cannot_be_meant_is_refused(crowd_scene, tmp_path):
    with pytest.raises(UsdfootError, match="every: is 0"):
        every(0)
    with pytest.raises(UsdfootError, match="both the distance and the camera"):
        every(2, near=3.0)
    scene = layer_over(crowd_scene, tmp_path / "seen.usda", 30.0)
    for path in ("/World/Nobody", "no path"):
        with pytest.raises(SceneError, match=f"{path}: .*cameras are: /World/Camera"):
            animate(scene, tmp_path / "out", options=every(2, near=3.0, camera=path))
