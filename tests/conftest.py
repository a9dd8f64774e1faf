"""What all tests share: where the data is, quiet Warp, reproducible random numbers."""

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from tests.few_clips import write_few_clips_scene
from usdfoot.model.device import start_warp
from usdfoot.pipeline.animate import AnimateReport, animate

REPOSITORY = Path(__file__).resolve().parents[1]

settings.register_profile(
    "usdfoot",
    derandomize=True,
    database=None,
    deadline=None,
    max_examples=50,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("usdfoot")


@pytest.fixture(scope="session", autouse=True)
def quiet_warp() -> None:
    """Warp started as usdfoot starts it, before a test that launches kernels itself does."""
    start_warp()


@pytest.fixture(scope="session")
def repository() -> Path:
    """Root of the source tree."""
    return REPOSITORY


@pytest.fixture(scope="session")
def stages() -> Path:
    """Folder of the stages usdfoot made itself."""
    return REPOSITORY / "stages"


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of real clips, characters, terrains and scenes; third-party data, so not in the repository.

    `USDFOOT_SHARED_DATA` names it; otherwise it is `../shared/data` beside the repository.
    """
    folder = Path(os.environ.get("USDFOOT_SHARED_DATA") or REPOSITORY.parent / "shared" / "data").resolve()
    if not (folder / "README.md").is_file():
        pytest.skip(f"no real data in {folder}: set USDFOOT_SHARED_DATA to its folder")
    return folder


@pytest.fixture
def generator() -> np.random.Generator:
    """A random generator with the same numbers in every run."""
    return np.random.default_rng(20150615)


@pytest.fixture(scope="session")
def scene(stages, tmp_path_factory) -> Path:
    """The stepping stones with few clips."""
    return write_few_clips_scene(stages, tmp_path_factory.mktemp("scene"))


@pytest.fixture(scope="session")
def stones(scene, tmp_path_factory) -> AnimateReport:
    """Report of the stepping stones, animated once for all tests that look at a written crowd."""
    return animate(scene, tmp_path_factory.mktemp("stones"))
