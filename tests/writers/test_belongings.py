"""A crowd replaces and removes what is a crowd's, and nothing else."""

import pytest

from tests.writers.test_crowd import write
from usdfoot.errors import OutputError
from usdfoot.writers.belongings import check_foreign

KEPT = ("notes.txt", ".123.profile", ".123-abc.crowd.usd", "anims.0001.usda")


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("name", ["crowd.usd", "report.json", "agents.usdc", "anims.0007.usdc"])
def test_files_of_others_are_not_replaced(tmp_path, name):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / name).write_text('{"versions": 3}')
    with pytest.raises(OutputError, match=rf"would replace and did not write: {name}\. name another folder, or move"):
        write(tmp_path)
    assert contents(tmp_path / "out") == {name: b'{"versions": 3}'}


def test_a_layer_that_usdfoot_did_not_write_is_not_replaced(tmp_path):
    (tmp_path / "crowd.usd").write_text('#usda 1.0\ndef "Mine" {}\n')
    with pytest.raises(OutputError, match=r"did not write: crowd\.usd"):
        check_foreign(tmp_path)


@pytest.mark.parametrize("whole", ["crowd.usd", "anims.0000.usdc"])
def test_a_crowd_of_which_little_is_whole_is_one(tmp_path, whole):
    crowd, _, _ = write(tmp_path)
    for path in crowd.parent.iterdir():
        path.write_bytes(path.read_bytes() if path.name == whole else b"damaged")
    check_foreign(crowd.parent)


def test_what_killed_runs_left_is_removed_and_nothing_else(tmp_path):
    crowd, _, _ = write(tmp_path)
    before = contents(crowd.parent)
    mark = "123-0123456789abcdef"
    left = (
        *(f".{mark}.{name}" for name in before),
        "anims.0007.usdc",
        f".{mark}.agents.0003.usdc",
        ".9.agents.0003.usdc",  # as they once were named
        f"characters/.{mark}.Hero.usdc",
    )
    (crowd.parent / "characters").mkdir()
    for name in (*left, *KEPT):
        (crowd.parent / name).write_text("")
    write(tmp_path)
    assert contents(crowd.parent).keys() == {*before, *KEPT}
