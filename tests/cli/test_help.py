"""Every verb explains itself: its examples parse, its Python twin exists, its exit codes are told."""

import argparse
import ast
import builtins
import importlib
import shlex
import subprocess
import sys

import pytest

from usdfoot.cli.completion import FILES, FOLDERS
from usdfoot.cli.main import build_parser, main


def verbs(parser, names=()):
    """Names and parser of every verb, ways of making plans included."""
    below = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    if names:
        yield names, parser
    for action in below:
        for name, verb in action.choices.items():
            yield from verbs(verb, (*names, name))


VERBS = dict(verbs(build_parser()))
WORKERS = {names: verb for names, verb in VERBS.items() if names != ("plan",)}


def example_lines(epilog):
    """Lines of the example that call usdfoot, as arguments; what follows >, | or # is the shell's."""
    block = epilog.split("example:\n")[1].split("\n\n")[0]
    for line in block.splitlines():
        words = shlex.split(line, comments=True)
        ends = [place for place, word in enumerate(words) if word in (">", "|", "&&")]
        if words[:1] == ["usdfoot"]:
            yield words[1 : min(ends, default=len(words))]


def test_there_are_verbs():
    assert {("animate",), ("plan", "path"), ("doctor",), ("completion",)} <= set(VERBS)


@pytest.mark.parametrize("names", VERBS, ids=" ".join)
def test_the_examples_of_help_parse(names, capsys):
    assert main([*names, "--help"]) == 0
    lines = list(example_lines(capsys.readouterr().out))
    assert lines and any(line[: len(names)] == list(names) for line in lines)
    for line in lines:
        build_parser().parse_args(line)


@pytest.mark.parametrize("names", WORKERS, ids=" ".join)
def test_the_python_twin_of_help_exists_and_exit_codes_are_told(names):
    epilog = WORKERS[names].epilog
    assert "exit codes: 0 " in epilog
    twin = epilog.split("in Python:\n")[1]
    code = "\n".join(line[2:] for line in twin.splitlines() if line.startswith("  "))
    imports = [node for node in ast.parse(code).body if isinstance(node, ast.ImportFrom)]
    assert imports
    for node in imports:
        module = importlib.import_module(node.module)
        assert all(hasattr(module, alias.name) for alias in node.names)
    used = [node for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Name)]
    known = {alias.name for node in imports for alias in node.names} | set(dir(builtins))
    known |= {node.id for node in used if isinstance(node.ctx, ast.Store)}
    assert {node.id for node in used} <= known


@pytest.mark.parametrize("names", WORKERS, ids=" ".join)
def test_every_argument_is_explained_and_files_are_known_to_be_files(names):
    for action in WORKERS[names]._actions:
        assert action.help, action.dest
        if not action.option_strings and action.choices is None:
            assert action.metavar in FILES | FOLDERS, f"{action.metavar}: a new file? add it in cli/completion.py"


def test_nothing_heavy_is_loaded_to_parse():
    code = "import sys, usdfoot.cli.main; print(*{name.split('.')[0] for name in sys.modules})"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"numpy", "pxr", "rich", "scipy", "warp"} & set(ran.stdout.split())


def test_neither_kernels_nor_scipy_are_loaded_to_find_that_nothing_is_to_be_made():
    code = "import sys, usdfoot.pipeline.animate; print(*{name.split('.')[0] for name in sys.modules})"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"scipy", "warp"} & set(ran.stdout.split())
