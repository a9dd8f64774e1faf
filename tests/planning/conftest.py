"""The analytic walker's steps, cut once for the tests of planning."""

import pytest

from tests.engine.walkers import OTHERS, WALKS, library_of
from usdfoot.engine.animate import PreparedLibrary, prepare_library
from usdfoot.engine.options import EngineOptions


@pytest.fixture(scope="session")
def walkers() -> PreparedLibrary:
    """Walks of many lengths and widths, in place, backward and sideways, turns and runs: 0 to 3.1 m/s forward."""
    return prepare_library(library_of([*WALKS, *OTHERS]), EngineOptions())
