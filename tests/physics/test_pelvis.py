"""Where the pelvis hangs on the centre of mass."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.physics.builders import human, walk
from usdfoot.physics.biped import measure_biped
from usdfoot.physics.optimise import optimise_com
from usdfoot.physics.pelvis import hung_pelvises
from usdfoot.readers.scene import read_scene


def test_pelvises_of_people_sway_to_the_standing_leg_and_others_hang_still():
    plan, person = walk(), replace(human(), humanlike=True)
    strikes = plan.strike_times[2:10]
    times = np.linspace(strikes[0], strikes[-1], 400)
    agents = np.zeros(len(times), dtype=int)
    com = optimise_com([plan], person)
    swayed, hung = (
        hung_pelvises(motion, agents=agents, times=times, offsets=np.zeros(3))
        for motion in (com, replace(com, biped=human()))
    )
    assert_allclose(hung, com.evaluate(agents, times).positions + human().pelvis, atol=1e-9)
    across = swayed - hung
    assert_allclose(across[:, 1:], 0.0, atol=1e-9)
    assert 0.005 < across[:, 0].max() < 0.01
    assert_allclose(across[:, 0].max(), -across[:, 0].min(), rtol=0.05)
    feet = plan.positions[np.searchsorted(plan.strike_times, times, side="right") - 1, 0]
    moving = np.abs(across[:, 0]) > 0.002
    assert np.array_equal(across[moving, 0] > 0.0, feet[moving] > 0.0)


@pytest.mark.parametrize(("scene", "humanlike"), [("human_run", True), ("bird_walk", False), ("dinosaur_leaps", False)])
def test_who_is_built_like_people(stages, scene, humanlike):
    library = read_scene(stages / f"physics_{scene}.usda").crowd.libraries[0]
    assert measure_biped(library.skeleton, library.biped).humanlike == humanlike
