"""One crowd animated for all tests of the pipeline."""

import pytest

from tests.few_clips import write_few_clips_scene
from usdfoot.pipeline.animate import animate


@pytest.fixture(scope="session")
def scene(stages, tmp_path_factory):
    """The stepping stones with few clips."""
    return write_few_clips_scene(stages, tmp_path_factory.mktemp("scene"))


@pytest.fixture(scope="session")
def stones(scene, tmp_path_factory):
    """Report of the stepping stones, animated once."""
    return animate(scene, tmp_path_factory.mktemp("stones"))
