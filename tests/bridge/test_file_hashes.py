"""Files that nobody changed are known without being read; any change of any of them is noticed."""

import os
import shutil

import pytest

from usdfoot.bridge import file_hashes
from usdfoot.bridge.file_hashes import intact_files, mark_unchanged


@pytest.fixture
def marked(tmp_path):
    """Three files, and one that tells of them, marked."""
    folder = tmp_path / "crowd"
    folder.mkdir()
    for name in "abc":
        (folder / name).write_text(f"of {name}")
    (folder / "report").write_text("tells of a, b and c")
    mark_unchanged([folder / name for name in "abc"], marked=folder / "report")
    return folder


@pytest.fixture
def read(monkeypatch):
    """Which files are read."""
    names = []
    hashed = file_hashes._sha256
    monkeypatch.setattr(file_hashes, "_sha256", lambda path: (names.append(path.name), hashed(path))[1])
    return names


def hashes_of(folder):
    return file_hashes.file_hashes({name: folder / name for name in "abc"})


def look(folder, hashes):
    return intact_files(hashes, folder, marked=folder / "report")


def test_what_nobody_changed_is_not_read(marked, read):
    hashes = hashes_of(marked)
    read.clear()
    assert look(marked, hashes) == hashes and read == []
    (marked / "b").unlink()
    assert set(look(marked, hashes)) == {"a", "c"}


def write_other(folder):
    (folder / "b").write_text("or b")


def write_other_of_the_same_time(folder):
    status = (folder / "b").stat()
    write_other(folder)
    os.utime(folder / "b", ns=(status.st_atime_ns, status.st_mtime_ns))


def put_other_of_an_older_time(folder):
    (folder / "new").write_text("or b")
    os.utime(folder / "new", ns=(0, 0))
    os.replace(folder / "new", folder / "b")


def write_into(folder):
    with (folder / "b").open("r+b") as stream:
        stream.write(b"or")


@pytest.mark.parametrize("change", [write_other, write_other_of_the_same_time, put_other_of_an_older_time, write_into])
@pytest.mark.parametrize("copied", [None, shutil.copy, shutil.copy2])
def test_a_change_is_noticed_at_once_and_in_copies(marked, change, copied):
    hashes = hashes_of(marked)
    change(marked)
    folder = marked
    if copied:
        folder = shutil.copytree(marked, marked.with_name("copy"), copy_function=copied)
    assert set(look(folder, hashes)) == {"a", "c"}


@pytest.mark.parametrize("copied", [shutil.copy, shutil.copy2])
def test_what_is_copied_is_read(marked, read, copied):
    hashes = hashes_of(marked)
    folder = shutil.copytree(marked, marked.with_name("copy"), copy_function=copied)
    read.clear()
    assert look(folder, hashes) == hashes and sorted(read) == ["a", "b", "c"]


def test_a_report_of_another_time_vouches_for_nothing(marked, read):
    hashes = hashes_of(marked)
    os.utime(marked / "report")
    read.clear()
    assert look(marked, hashes) == hashes and sorted(read) == ["a", "b", "c"]


def test_nothing_is_marked_where_the_clock_of_files_is_too_coarse(marked, monkeypatch, read):
    hashes = hashes_of(marked)
    monkeypatch.setattr(file_hashes, "_TICKS", 0)
    mark_unchanged([marked / name for name in "abc"], marked=marked / "report")
    read.clear()
    assert look(marked, hashes) == hashes and sorted(read) == ["a", "b", "c"]
