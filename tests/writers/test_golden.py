"""The written layers as text against goldens; numbers within a tolerance.

After a wanted change: USDFOOT_WRITE_GOLDENS=1 python -m pytest tests/writers/test_golden.py, and read the diff.
"""

import os
import re
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf

from tests.writers.test_crowd import write

GOLDEN = Path(__file__).parent / "golden"
NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    crowd, _, _ = write(tmp_path_factory.mktemp("golden"), agents=1, frames=2)
    return crowd.parent


@pytest.mark.parametrize(
    "name",
    [
        "crowd.usd",
        "overrides.usda",
        "agents.usdc",
        "footsteps.usdc",
        "anims.usda",
        "anims.0000.usdc",
        "crowd.expanded.usda",
    ],
)
def test_layer_is_as_it_was(folder, name):
    text = Sdf.Layer.FindOrOpen(str(folder / name)).ExportToString()
    golden = GOLDEN / f"{name}.usda"
    if os.environ.get("USDFOOT_WRITE_GOLDENS"):
        golden.write_text(text, encoding="utf-8", newline="\n")
    expected = golden.read_text(encoding="utf-8")
    assert NUMBER.split(text) == NUMBER.split(expected)
    numbers, wanted = (np.array(NUMBER.findall(part), dtype=float) for part in (text, expected))
    np.testing.assert_allclose(numbers, wanted, rtol=1e-4, atol=1e-5)
