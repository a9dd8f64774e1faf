"""The gallery has the pictures its tool draws, all shown, and they are small."""

import re

import pytest
from gallery import SHEETS, SIZE, SPACE
from PIL import Image

MOST_BYTES = 1_500_000


@pytest.fixture
def pictures(stages):
    return {path.stem: path for path in (stages / "gallery").glob("*.png")}


def test_every_picture_is_drawn_by_the_tool_and_shown(stages, pictures):
    assert set(pictures) == {*SHEETS, SPACE}
    text = (stages / "gallery" / "README.md").read_text(encoding="utf-8")
    assert set(re.findall(r"\]\((\w+)\.png\)", text)) == set(pictures)
    assert all((stages / f"{sheet.scene}.usda").is_file() for sheet in SHEETS.values())


def test_pictures_are_pictures_and_small(pictures):
    assert sum(path.stat().st_size for path in pictures.values()) < MOST_BYTES
    for name, path in pictures.items():
        with Image.open(path) as picture:
            assert name == SPACE or picture.size == SIZE
            assert len(picture.convert("RGB").getcolors(1 << 16)) > 50
