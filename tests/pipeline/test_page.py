"""The page of a written crowd shows what `validate` measures."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Sdf, Usd

from tests.writers.pages import taken_apart
from usdfoot.cli.main import main
from usdfoot.errors import OutputError, SceneError
from usdfoot.pipeline import shares
from usdfoot.pipeline.page import write_page
from usdfoot.pipeline.validate import validate
from usdfoot.readers.joint_tracks import read_joint_tracks
from usdfoot.readers.written import read_agent, read_written_crowd


@pytest.fixture(scope="module")
def page(stones, tmp_path_factory):
    return write_page(stones.crowd_file, tmp_path_factory.mktemp("page") / "report.html").file


@pytest.fixture(scope="module")
def parts(page):
    return taken_apart(page.read_text(encoding="utf-8"))


def test_figures_are_those_of_validate(stones, parts):
    header, arrays = parts
    validation = validate(stones.crowd_file)
    for row, figure in zip(header["total"], validation.total.figures, strict=True):
        assert row["name"] == figure.name and row["target"] == figure.target and row["passed"] == figure.passed
        assert row["value"] == pytest.approx(figure.value, nan_ok=True)
    measured = {figure.name: figure.value for figure in validation.total.figures}
    promised = arrays["promised"].astype(bool)
    for key, name in (("placement", "placement worst"), ("slide", "slide"), ("heelSlide", "heel slide")):
        assert np.nanmax(arrays[f"step:{key}"][promised]) == pytest.approx(measured[name], rel=1e-5)
    assert np.nanmin(arrays["step:clearance"][promised]) == pytest.approx(measured["clearance"], rel=1e-5)
    assert measured["lowest sole"] - 1e-3 <= np.nanmin(arrays["step:penetration"]) < 1.0
    assert arrays["agent:jerk"][0] == pytest.approx(measured["joint jerk / clips"], rel=1e-5)


def test_joints_and_footsteps_are_those_of_the_stage(stones, parts):
    header, arrays = parts
    crowd = read_written_crowd(stones.crowd_file)
    agent = read_agent(crowd, "Walker")
    tracks = read_joint_tracks(agent, crowd.units, agent.frame_codes)
    frames, joints = arrays["frameCounts"][0], len(header["stickFigures"][0]["parents"])
    roots = 0.001 * arrays["roots"].reshape(3, frames).T + header["origin"]
    shown = roots[:, None] + header["resolution"] * arrays["joints"].reshape(joints, 3, frames).transpose(2, 0, 1)
    assert_allclose(shown[:, 0], tracks.positions[:, agent.biped.pelvis], atol=0.0011)
    for ball in agent.biped.balls:
        assert np.abs(shown - tracks.positions[:, None, ball]).max(axis=(0, 2)).min() < 0.0011
    stood = arrays["stood"].reshape(-1, 3) + header["origin"]
    errors = np.hypot(*(stood - agent.plan.positions)[:, [0, 2]].T)
    assert_allclose(errors, 0.001 * arrays["step:placement"], atol=1e-5)
    walked = (tracks.times >= agent.plan.strike_times[2]) & (tracks.times <= agent.plan.strike_times[3])
    heights = shown[walked, 0, 1] - roots[walked, 1]
    assert arrays["step:excursion"][2] == pytest.approx(1e3 * np.ptp(heights), abs=2.1)
    assert len(arrays["groundTriangles"]) > 0 and header["facts"]["stage"].startswith("1 m a unit")


def test_same_crowd_same_bytes_and_the_crowd_untouched(stones, page, tmp_path):
    folder = stones.crowd_file.parent
    before = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    assert write_page(stones.crowd_file, tmp_path / "again.html").file.read_bytes() == page.read_bytes()
    assert {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before
    with pytest.raises(OutputError, match="name a page"):
        write_page(stones.crowd_file, stones.crowd_file)


def test_agents_are_chosen_by_name(stones, tmp_path):
    with pytest.raises(SceneError, match=r"has no agent to show that is named Runner\*"):
        write_page(stones.crowd_file, tmp_path / "nobody.html", agents="Runner*")


def layer_over(file, path):
    """A new layer over a file, in its units."""
    below = Usd.Stage.Open(str(file))
    layer = Sdf.Layer.CreateNew(str(path))
    layer.subLayerPaths.append(str(file))
    for key in ("metersPerUnit", "upAxis", "timeCodesPerSecond"):
        layer.pseudoRoot.SetInfo(key, below.GetMetadata(key))
    return layer


@pytest.fixture(scope="module")
def twins(stones, tmp_path_factory):
    """A shot over the crowd in which a second agent does what the first does."""
    layer = layer_over(stones.crowd_file, tmp_path_factory.mktemp("twins") / "shot.usda")
    stage = Usd.Stage.Open(layer)
    walker, twin = (stage.DefinePrim(f"/Crowd/Agents/{name}") for name in ("Walker", "Twin"))
    twin.GetReferences().AddInternalReference(walker.GetPath())
    for name in ("usdfoot:agent:plan", "skel:animationSource"):
        twin.CreateRelationship(name, custom=False).SetTargets(walker.GetRelationship(name).GetTargets())
    layer.Save()
    return layer.realPath


def test_as_many_workers_as_there_are_make_the_same_page(twins, tmp_path, monkeypatch):
    alone = write_page(twins, tmp_path / "alone.html")
    assert sorted(alone.agents) == ["Twin", "Walker"]
    monkeypatch.setattr(shares, "SHARE", 1)
    with ThreadPoolExecutor(2) as executor:
        shared = write_page(twins, tmp_path / "shared.html", executor=executor)
    assert shared.file.read_bytes() == alone.file.read_bytes()


def test_an_agent_that_cannot_be_shown_is_a_problem_on_the_page(twins, tmp_path, capsys):
    broken = layer_over(twins, tmp_path / "broken.usda")
    stage = Usd.Stage.Open(broken)
    stage.OverridePrim("/Crowd/Agents/Twin").GetRelationship("usdfoot:agent:plan").SetTargets([])
    broken.Save()
    assert main(["inspect", broken.realPath, "--html", str(tmp_path / "broken.html"), "--workers", "1"]) == 1
    assert "/Crowd/Agents/Twin: has no plan" in capsys.readouterr().err
    header, _ = taken_apart((tmp_path / "broken.html").read_text(encoding="utf-8"))
    assert header["names"] == ["Walker"] and any("Twin: has no plan" in problem for problem in header["problems"])


def test_the_command_line_writes_the_page(stones, tmp_path, capsys, page):
    assert main(["inspect", str(stones.crowd_file), "--html", str(tmp_path / "report.html"), "-q"]) == 0
    assert f"wrote {tmp_path / 'report.html'}" in capsys.readouterr().out
    assert (tmp_path / "report.html").read_bytes() == page.read_bytes()
