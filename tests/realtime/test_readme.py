"""The README's example runs and does what it says."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.testing import assert_allclose

ROOT = Path(__file__).resolve().parents[2]


def test_the_example_walks(capsys):
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    [example] = [code for code in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if "Controller(" in code]
    scope: dict[str, object] = {}
    exec(example.replace('"stages/', f'"{ROOT.as_posix()}/stages/'), scope)
    assert capsys.readouterr().out == ""
    pose = scope["pose"]
    assert pose.root_positions[0, 2] > 1.5
    assert_allclose(pose.root_positions[1, [0, 2]], [2.0, 0.65], atol=0.01)
    assert pose.translations.shape == (2, 24, 3)
    assert_allclose(np.linalg.norm(pose.rotations, axis=-1), 1.0, atol=1e-5)
    assert pose.halted.tolist() == [False, True]
