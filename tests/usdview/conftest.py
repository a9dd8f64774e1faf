"""A crowd of three, made once; each test that changes it has a copy beside a copy of its scene."""

import shutil

import pytest
from pxr import Usd

from tests.batch.conftest import write_crowd_scene
from usdfoot.pipeline.animate import animate


@pytest.fixture(scope="session")
def made(stages, tmp_path_factory):
    """Folder with scene/few_clips.usda and crowd/crowd.usd."""
    folder = tmp_path_factory.mktemp("usdview")
    scene = write_crowd_scene(stages, folder / "scene")
    animate(scene, folder / "crowd", chunk_size=1)
    return folder


@pytest.fixture(scope="module")
def stage(made):
    """The crowd, opened for tests that change its session layer only."""
    return Usd.Stage.Open(str(made / "crowd" / "crowd.usd"))


@pytest.fixture
def shot(made, tmp_path):
    """A copy of the folder."""
    return shutil.copytree(made, tmp_path / "shot")


@pytest.fixture
def opened(shot):
    """The copy's crowd."""
    return Usd.Stage.Open(str(shot / "crowd" / "crowd.usd"))
