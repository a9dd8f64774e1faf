"""The flags of physics say the same as the library does without them."""

import argparse

import pytest

from usdfoot.cli.physics_flags import add_physics_flags, body_tuning, physics_options
from usdfoot.errors import UsdfootError
from usdfoot.model.tuning import BodyTuning
from usdfoot.physics.options import PhysicsOptions


def test_defaults_are_the_librarys():
    parser = argparse.ArgumentParser()
    add_physics_flags(parser)
    arguments = parser.parse_args([])
    assert physics_options(arguments) == PhysicsOptions()
    assert body_tuning(arguments) == BodyTuning()


def test_what_is_given_is_the_tuning_of_all_agents():
    parser = argparse.ArgumentParser()
    add_physics_flags(parser)
    flags = ["--crouch=0.1", "--hip-spacing=1.2", "--com-shift", "0", "0.1", "-0.05", "--gravity=1.62"]
    arguments = parser.parse_args(flags)
    assert body_tuning(arguments).given == {
        "crouch": 0.1,
        "hip_spacing": 1.2,
        "com_left": 0.0,
        "com_up": 0.1,
        "com_ahead": -0.05,
        "gravity": 1.62,
    }


@pytest.mark.parametrize("spacing", [0.0, 0.05, -1.0])
def test_hips_in_one_place_are_refused(spacing):
    with pytest.raises(UsdfootError, match=r"hip_spacing: is .* 0\.1 to 10 is possible"):
        BodyTuning(hip_spacing=spacing)
