"""What a written crowd records of its agents is what the engine found."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pxr import Sdf, Usd, UsdGeom

from usdfoot.readers.executed import read_root_positions, read_step_results
from usdfoot.readers.written import read_agent, read_written_crowd


@pytest.fixture(scope="module")
def crowd(stones):
    return read_written_crowd(stones.crowd_file)


@pytest.fixture(scope="module")
def agent(crowd):
    return read_agent(crowd, "Walker")


def test_results_are_read_as_they_were_written(stones, crowd, agent):
    results, expected = read_step_results(agent, crowd.units), stones.results["Walker"]
    for name in ("blend_error", "placement_error", "slide", "yaw_error", "hull_distance", "time_warp", "root_weight"):
        assert_allclose(getattr(results, name), getattr(expected, name), rtol=1e-6, atol=1e-12)
    assert_allclose(results.root_velocity_error, expected.root_velocity_error, rtol=1e-6)
    assert results.status == expected.status and results.forces is None
    for step, (blended, wanted) in enumerate(zip(weights_of(results), weights_of(expected), strict=True)):
        assert blended == pytest.approx(wanted, rel=1e-6), step


def weights_of(results):
    """Weight of each clip, step by step."""
    ends = np.cumsum(results.clip_counts)
    pairs = list(zip(results.clips, results.clip_weights.tolist(), strict=True))
    return [dict(pairs[end - count : end]) for end, count in zip(ends, results.clip_counts, strict=True)]


def test_what_is_not_recorded_is_not_known(stones):
    stage = Usd.Stage.Open(str(stones.crowd_file))
    session = stage.GetSessionLayer()
    with Usd.EditContext(stage, session):
        plan = stage.GetPrimAtPath("/Crowd/Plans/Walker")
        plan.GetAttribute("usdfoot:result:slide").Set([1.0])
        plan.GetAttribute("usdfoot:result:timeWarp").Block()
        plan.GetAttribute("usdfoot:result:clips").Set(["/one"])
    crowd = read_written_crowd(stage)
    results = read_step_results(read_agent(crowd, "Walker"), crowd.units)
    assert np.isnan(results.slide).all() and np.isnan(results.time_warp).all()
    assert np.isfinite(results.placement_error).all()
    assert results.clips == () and not results.clip_counts.any()


def test_roots_are_where_the_agent_prim_is_in_the_world(crowd, agent):
    codes = agent.frame_codes[::7]
    prim = crowd.stage.GetPrimAtPath("/Crowd/Agents/Walker")
    places = [UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(code).ExtractTranslation() for code in codes]
    assert_allclose(
        read_root_positions(agent, crowd.units, codes), crowd.units.points_to_canonical(np.array(places)), atol=1e-9
    )
    assert Sdf.Path("/Crowd/Agents/Walker") == prim.GetPath()
