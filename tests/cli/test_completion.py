"""The printed scripts complete verbs, flags, choices and files."""

import shutil
import subprocess

import pytest

from usdfoot.cli.completion import SHELLS
from usdfoot.cli.main import main

OFFERED = """
COMP_WORDS=({words}); COMP_CWORD={last}
$(complete -p usdfoot | sed 's/.*-F \\([^ ]*\\).*/\\1/') > /dev/null 2>&1
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


@pytest.fixture
def script(tmp_path, capsys):
    """A function that writes the script for a shell and gives back its path and the shell's; skips without a shell."""

    def write(shell):
        program = shutil.which(shell)
        if program is None:
            pytest.skip(f"no {shell} here")
        assert main(["completion", shell]) == 0
        path = tmp_path / f"usdfoot.{shell}"
        path.write_text(capsys.readouterr().out, encoding="utf-8")
        return path, program

    return write


@pytest.mark.parametrize("shell", SHELLS)
def test_the_shell_understands_its_script(script, shell):
    path, program = script(shell)
    done = subprocess.run([program, "-n", str(path)], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_bash_completes_verbs_flags_choices_and_files(script, tmp_path):
    path, program = script("bash")
    (tmp_path / "shot.usda").touch()

    def offered(*words):
        """What bash offers for the last word."""
        quoted = " ".join(f"'{word}'" for word in words)
        text = f"source {path}\n" + OFFERED.format(words=quoted, last=len(words) - 1)
        done = subprocess.run([program, "-c", text], cwd=tmp_path, capture_output=True, text=True)
        return set(done.stdout.split())

    assert offered("usdfoot", "an") == {"analyze", "animate"}
    assert {"path", "lint", "stones"} <= offered("usdfoot", "plan", "")
    assert offered("usdfoot", "animate", "--root-w") == {"--root-weight"}
    assert offered("usdfoot", "plan", "lint", "--f") == {"--fix"}
    assert offered("usdfoot", "animate", "--motion", "") == {"clips", "physics", "hybrid"}
    assert offered("usdfoot", "animate", "sh") == {"shot.usda"}


def test_fish_completes_verbs_and_flags(script, tmp_path):
    path, program = script("fish")
    for line, expected in (("usdfoot an", {"analyze", "animate"}), ("usdfoot animate --root-w", {"--root-weight"})):
        text = f"source {path}; complete -C '{line}'"
        done = subprocess.run([program, "-c", text], cwd=tmp_path, capture_output=True, text=True)
        assert {offer.split("\t")[0] for offer in done.stdout.splitlines()} == expected
