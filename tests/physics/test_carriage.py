"""How a person carries the pelvis: found again where it is known, and only in that person's walks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.engine.plans import crowd, way
from tests.engine.walkers import WALKS, library_of
from tests.physics.builders import human, walk
from usdfoot.maths import quaternion
from usdfoot.model.clip import ClipLibrary
from usdfoot.physics.animate import animate_all
from usdfoot.physics.biped import measure_biped
from usdfoot.physics.carriage import (
    VALUES,
    Carriage,
    CarriedClips,
    PelvisTrack,
    carried_offsets,
    find_carried,
    fit_carriage,
    lay_carriage,
    measure_carriage,
)
from usdfoot.physics.heading import heading_of
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.physics.optimise import ComMotion, optimise_com
from usdfoot.physics.pelvis import hung_pelvises
from usdfoot.physics.style import BodyStyle

KNOWN = np.array([0.01, -0.02, -0.06, 0.015, 0.04])
STOOP = Carriage(slowest=0.5, quickest=2.0, speed=1.0, values=KNOWN, slopes=np.zeros(VALUES))


def carried_track(com: ComMotion, values: np.ndarray) -> PelvisTrack:
    """The pelvis of the first agent as these values (VALUES,) carry it."""
    times = np.arange(com.contacts.starts[0], com.contacts.ends[0], 1.0 / 60.0)
    agents = np.zeros(len(times), dtype=int)
    rhythm = com.rhythm(agents, times, heading_of(com.evaluate(agents, times).orientations))
    offsets = carried_offsets(np.tile(values, (len(times), 1)), rhythm)
    return PelvisTrack(times=times, positions=hung_pelvises(com, agents=agents, times=times, offsets=offsets))


@pytest.mark.parametrize("turn", [0.0, 0.2])
def test_a_known_carriage_is_found(turn):
    com = optimise_com([walk(turn=turn)], human())
    found = find_carried(com, [carried_track(com, KNOWN)])
    assert found.walks.all()
    assert_allclose(found.values[0], KNOWN, rtol=0.05, atol=1e-4)


def test_steps_on_the_spot_say_nothing():
    com = optimise_com([walk(length=0.0)], human())
    found = find_carried(com, [carried_track(com, KNOWN)])
    assert not found.walks.any()
    assert np.abs(found.values).max() < 0.1


def test_a_clip_whose_footsteps_were_not_its_own_says_nothing():
    com = optimise_com([walk()], human())
    track = carried_track(com, KNOWN)
    assert not find_carried(com, [replace(track, positions=track.positions + [0.0, 0.0, 0.3])]).walks.any()


def test_runs_say_nothing_and_are_told_nothing():
    com = optimise_com([walk(8, length=1.6)], human())
    assert not find_carried(com, [carried_track(com, KNOWN)]).walks.any()
    middle = 0.5 * (com.contacts.starts + com.contacts.ends)
    assert_allclose(lay_carriage(com, STOOP).at(np.zeros(1, dtype=int), middle), 0.0, atol=1e-9)


def test_who_walks_steadily_is_carried_so_and_who_stands_as_at_rest():
    com = optimise_com([walk(length=0.7)], human())
    middle = 0.5 * (com.contacts.starts + com.contacts.ends)
    assert_allclose(lay_carriage(com, STOOP).at(np.zeros(1, dtype=int), middle), KNOWN[None], atol=1e-9)
    assert_allclose(STOOP.at(np.array([0.0])), 0.0)
    assert_allclose(STOOP.at(np.array([0.25])), 0.5 * KNOWN[None])


def test_a_line_over_the_speed_ends_with_the_clips():
    speeds = np.linspace(0.5, 2.0, 40)
    lines = np.outer(speeds - 1.0, KNOWN)
    clips = CarriedClips(speeds=np.append(speeds, 4.0), values=np.vstack([lines, np.ones(5)]), walks=np.arange(41) < 40)
    carriage = fit_carriage(clips)
    assert carriage is not None
    assert_allclose(carriage.at(np.array([1.5]))[0], 0.5 * KNOWN, rtol=0.05)
    assert_allclose(carriage.at(np.array([3.0])), carriage.at(np.array([2.0])))


def test_nothing_is_known_of_the_clip_left_out():
    rng = np.random.default_rng(4)
    clips = CarriedClips(speeds=rng.uniform(0.5, 2.0, 5), values=rng.normal(size=(5, VALUES)), walks=np.ones(5, bool))
    changed = replace(clips, values=clips.values + np.where(np.arange(5) == 2, 7.0, 0.0)[:, None])
    speeds = np.linspace(0.0, 2.0, 9)
    left, right = (fit_carriage(each, without=2) for each in (clips, changed))
    assert left is not None and right is not None
    assert_allclose(left.at(speeds), right.at(speeds))
    one = CarriedClips(speeds=np.ones(1), values=np.ones((1, VALUES)), walks=np.ones(1, bool))
    assert fit_carriage(one, without=0) is None
    few = fit_carriage(one)
    assert few is not None
    assert_allclose(few.at(np.ones(1)), 0.5)  # one clip may be chance


@pytest.fixture(scope="module")
def recorded() -> ClipLibrary:
    library = library_of(WALKS[3:], footsteps=6)
    return replace(library, clips=tuple(replace(clip, synthetic=False) for clip in library.clips))


def with_pelvis_behind(library: ClipLibrary, distance: float) -> ClipLibrary:
    """The same steps, the pelvis joint farther behind the legs by a distance [m] than it is at rest."""
    pelvis, shift = library.biped.pelvis, np.array([0.0, 0.0, distance])
    below = np.flatnonzero(library.skeleton.parents == pelvis)
    clips = []
    for clip in library.clips:
        translations = np.array(clip.translations)
        translations[:, pelvis] -= quaternion.rotate(clip.rotations[:, pelvis], shift)
        translations[:, below] += shift
        clips.append(replace(clip, translations=translations))
    return replace(library, clips=tuple(clips))


def test_what_is_measured_follows_the_clips(recorded):
    biped = measure_biped(recorded.skeleton, recorded.biped)
    before, after = (measure_carriage(each, biped) for each in (recorded, with_pelvis_behind(recorded, 0.05)))
    assert before is not None and after is not None
    count = len(recorded.clips)
    assert_allclose(after.values - before.values, [0, 0, -0.05 * count / (count + 1), 0, 0], atol=1e-4)
    made = replace(recorded, clips=tuple(replace(clip, synthetic=True) for clip in recorded.clips))
    assert measure_carriage(made, biped) is None
    assert measure_carriage(replace(recorded, clips=()), biped) is None


def test_bodies_carry_the_pelvis_as_their_clips_do_unless_told_otherwise(recorded):
    behind = with_pelvis_behind(recorded, 0.05)
    scene = crowd(behind, [way(10)])
    walker = replace(scene.agents[0], motion="physics")

    def pelvis(**style: bool) -> np.ndarray:
        options = MotionOptions(body=BodyStyle(**style))
        (motion,), problems = animate_all(replace(scene, agents=(walker,)), options=options)
        assert not problems and motion.results.placement_error.max() < 1e-4
        turns = quaternion.yaw_quaternion(motion.root_yaws)
        return motion.root_positions + quaternion.rotate(turns, motion.pelvis_positions.astype(float))

    measured = measure_carriage(behind, measure_biped(behind.skeleton, behind.biped))
    assert measured is not None
    apart = pelvis() - pelvis(carriage=False)
    middle = slice(len(apart) // 3, 2 * len(apart) // 3)
    assert_allclose(apart[middle, 1:].mean(axis=0), measured.values[1:3], atol=0.006)
