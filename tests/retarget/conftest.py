"""Clips of the project's own person, read once."""

import pytest

from usdfoot.readers.libraries import read_libraries
from usdfoot.retarget.rig import build_rig

KEPT = ("walk_110", "run_320", "side_left_035", "turn_left_200")


@pytest.fixture(scope="session")
def person(stages):
    """The rig of stages/clips.usdc and four of its clips."""
    found = read_libraries(stages / "clips.usdc")
    character, library = found.characters[0], found.libraries[0]
    clips = [clip for clip in library.clips if clip.name.rsplit("/", 1)[-1] in KEPT]
    return build_rig(character.skeleton, character.biped, character.bind_pose), clips
