"""The flags of physics say the same as the library does without them."""

import argparse

from usdfoot.cli.physics_flags import add_physics_flags, body_style, physics_options
from usdfoot.physics.options import PhysicsOptions
from usdfoot.physics.style import BodyStyle


def test_defaults_are_the_librarys():
    parser = argparse.ArgumentParser()
    add_physics_flags(parser)
    arguments = parser.parse_args([])
    assert physics_options(arguments) == PhysicsOptions()
    assert body_style(arguments) == BodyStyle()
