"""Plans that name a style for each step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.engine.plans import crowd, way
from tests.engine.walkers import WALKS, library_of
from usdfoot.engine.animate import PreparedLibrary, animate_agents, prepare_library
from usdfoot.engine.options import EngineOptions
from usdfoot.errors import PlanError
from usdfoot.maths import quaternion
from usdfoot.model.clip import Clip
from usdfoot.model.motion import StepResults
from usdfoot.model.plan import FootstepPlan

ARM = 4
"""Joint of the walker's left arm."""


def posed(clip: Clip, name: str, style: str, angle: float) -> Clip:
    """The clip in another style, an arm held otherwise by an angle [rad]."""
    rotations = np.array(clip.rotations)
    raised = quaternion.from_axis_angle(np.array([1.0, 0.0, 0.0]), np.array(angle))
    rotations[:, ARM] = quaternion.compose(rotations[:, ARM], raised)
    return replace(clip, name=f"{clip.name}_{name}", style=style, rotations=rotations)


@pytest.fixture(scope="module")
def styled() -> PreparedLibrary:
    """Upright walks, and sad ones with the arm as it hangs upright or raised."""
    plain = library_of(WALKS)
    sad = [posed(clip, "hanging", "sad", 0.0) for clip in plain.clips]
    sad += [posed(clip, "raised", "sad", 1.5) for clip in plain.clips]
    raised = [posed(clip, "raised", "proud", 1.5) for clip in plain.clips]
    return prepare_library(replace(plain, clips=(*plain.clips, *sad, *raised)), EngineOptions())


def run(styled: PreparedLibrary, plan: FootstepPlan, **options: object) -> StepResults:
    scene = crowd(styled.source, [plan])
    return animate_agents(styled, scene.agents, scene, options=EngineOptions(**options))[0].results


def clips_of(results: StepResults, step: int) -> list[str]:
    ends = np.cumsum(results.clip_counts)
    return list(results.clips[ends[step] - results.clip_counts[step] : ends[step]])


@pytest.mark.parametrize(
    "options", [{}, {"root_weight": 0.5}, {"space": "delaunay"}, {"space": "3d"}, {"space": "3d", "root_weight": 0.5}]
)
def test_every_step_is_blended_from_clips_of_its_style(styled, options):
    styles = ("", "", "sad", "sad", "default", "proud", "proud", "")
    results = run(styled, replace(way(8), styles=styles), **options)
    whose = {clip.name: clip.style for clip in styled.source.clips}
    for step in range(1, 8):
        assert {whose[clip] for clip in clips_of(results, step)} == {styles[step] or "default"}
    assert results.slide.max() < 1e-3


def test_a_step_in_another_style_goes_on_from_the_pose_before_it(styled):
    for before, arm in (("default", "hanging"), ("proud", "raised")):
        results = run(styled, replace(way(8), styles=(before,) * 4 + ("sad",) * 4))
        assert all(clip.endswith(arm) for clip in clips_of(results, 4))
        assert results.blend_error[4] < 1e-3


def test_naming_the_librarys_own_style_changes_nothing(styled):
    plain, named = run(styled, way(6)), run(styled, replace(way(6), styles=("default",) * 6))
    assert_allclose(named.clip_weights, plain.clip_weights, atol=0.0)


def test_a_style_no_clip_has_is_refused_with_those_there_are(styled):
    plan = replace(way(6), styles=("", "", "drunk", "sad", "", ""))
    with pytest.raises(
        PlanError, match=r"no clip has: 'drunk' of footstep 2\. the styles of its clips are default, pr"
    ):
        run(styled, plan)
    with pytest.raises(PlanError, match=r"no clip has: 'drunk' of footstep 0 and 5 more\. the styles"):
        run(styled, replace(way(6), styles=("drunk",) * 6))


def test_there_is_one_style_a_footstep():
    with pytest.raises(PlanError, match=r"arrays differ in length .*styles 2"):
        replace(way(6), styles=("sad", "sad"))
