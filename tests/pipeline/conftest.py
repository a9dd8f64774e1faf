"""One crowd animated for all tests of the pipeline."""

import pytest

from usdfoot.pipeline.animate import animate


@pytest.fixture(scope="session")
def stones(stages, tmp_path_factory):
    """Report of the project's stepping stones, animated once."""
    scene = stages / "stepping_stones.usda"
    if not scene.is_file():
        pytest.skip("stages/ has not been made: run make stages")
    return animate(scene, tmp_path_factory.mktemp("stones"))
