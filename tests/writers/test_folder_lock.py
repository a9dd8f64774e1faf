"""One run at a time writes into a folder, and nothing is left of who looked in vain."""

import subprocess
import sys

import pytest

from usdfoot.errors import OutputError
from usdfoot.writers.folder_lock import lock_folder


def assert_kept_out(folder, *, is_shared):
    with pytest.raises(OutputError, match="another run is writing into it"), lock_folder(folder, is_shared=is_shared):
        pass


def test_a_second_run_is_kept_out_and_the_next_one_let_in(tmp_path):
    folder = tmp_path / "shots" / "one"
    with lock_folder(folder), lock_folder(tmp_path / "two"):
        (folder / "crowd.usd").touch()
        with pytest.raises(OutputError, match="another run is writing into it"), lock_folder(folder):
            pass
    with lock_folder(folder):
        assert folder.exists()
    assert [path.name for path in tmp_path.rglob("*")] == ["shots", "one", "crowd.usd"]


def test_tasks_share_the_folder_and_keep_runs_out(tmp_path):
    with lock_folder(tmp_path, is_shared=True), lock_folder(tmp_path, is_shared=True):
        assert_kept_out(tmp_path, is_shared=False)
    with lock_folder(tmp_path):
        assert_kept_out(tmp_path, is_shared=True)


def test_who_was_killed_keeps_nobody_out(tmp_path):
    code = "import os, pathlib, sys\nfrom usdfoot.writers.folder_lock import lock_folder\n"
    code += "with lock_folder(pathlib.Path(sys.argv[1])):\n    os._exit(9)\n"
    assert subprocess.run([sys.executable, "-c", code, str(tmp_path)], check=False).returncode == 9
    with lock_folder(tmp_path):
        pass


def test_folders_that_cannot_be_made_keep_nobody_out(tmp_path):
    (tmp_path / "file").touch()
    for folder in (tmp_path / "file" / "below", tmp_path / ("x" * 300)):
        with lock_folder(folder):
            pass
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
