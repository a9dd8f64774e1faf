"""The house keeps its shape: rooms, sizes, documentation (style.md)."""

import ast
import functools
import importlib
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from usdfoot import errors

REPOSITORY = Path(__file__).resolve().parents[1]
PACKAGE = REPOSITORY / "usdfoot"
SOURCES = sorted(PACKAGE.rglob("*.py"))
SCRIPTS = sorted((REPOSITORY / "tools").rglob("*.py"))
ROOMS_WITH_USD = {"bridge", "readers", "writers", "usdview", "validators"}
EXTRAS = {"jupedsim", "shapely", "pxr.Usdviewq"}
LONGEST_FILE = 400
LONGEST_FUNCTION = 80
MOST_POSITIONAL = 3
MACHINE_PATHS = re.compile(r"(?<![\w.}/)-])/(?:home|root|work|tmp|Users|opt|mnt|usr/local)/\w")
DOCUMENTS = ("README.md", "GUIDE.md", "BENCHMARKS.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md")
TEXT_SUFFIXES = {".py", ".md", ".toml", ".usda", ".json", ".yaml", ".yml", ".cfg", ""}


def label(path: Path) -> str:
    return path.relative_to(REPOSITORY).as_posix()


def functions(tree: ast.AST) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))


def imported_modules(tree: ast.AST) -> set[str]:
    """First names of everything a file imports, wherever in it."""
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names.update(alias.name.split(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names.add(node.module.split(".")[0])
    return names


def parse(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


@functools.cache
def names_of(path: Path) -> tuple[frozenset[str], frozenset[str] | None]:
    """Names that a file defines, and its `__all__`, if it has one."""
    own, listed = set(), None
    for node in parse(path).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            own.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            own.update(name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name))
            if "__all__" in {ast.unparse(target) for target in targets}:
                listed = frozenset(ast.literal_eval(node.value))
    return frozenset(own), listed


def all_lists() -> list[str]:
    """Dotted names of the modules that have an `__all__`."""
    parts = [path.relative_to(REPOSITORY).with_suffix("").parts for path in SOURCES if names_of(path)[1] is not None]
    return [".".join(names[:-1] if names[-1] == "__init__" else names) for names in parts]


@pytest.mark.parametrize("path", SOURCES, ids=label)
def test_only_the_rooms_at_the_edge_import_usd(path):
    room = path.relative_to(PACKAGE).parts[0]
    if room not in ROOMS_WITH_USD:
        assert "pxr" not in imported_modules(parse(path))


@pytest.mark.parametrize("path", SOURCES + SCRIPTS, ids=label)
def test_files_and_functions_are_short(path):
    lines = path.read_text(encoding="utf-8").count("\n")
    assert lines <= LONGEST_FILE, f"{lines} lines"
    long = {
        function.name: size
        for function in functions(parse(path))
        if (size := (function.end_lineno or function.lineno) - function.lineno + 1) > LONGEST_FUNCTION
    }
    assert not long


@pytest.mark.parametrize("path", SOURCES, ids=label)
def test_public_functions_take_few_arguments_by_position(path):
    """Warp's functions aside: it knows no others."""
    tree = parse(path)
    scopes = [tree, *(node for node in ast.walk(tree) if isinstance(node, ast.ClassDef))]
    for function in (node for scope in scopes for node in scope.body if isinstance(node, ast.FunctionDef)):
        is_warp = any(ast.unparse(decorator).startswith("wp.") for decorator in function.decorator_list)
        given = [argument.arg for argument in function.args.args if argument.arg not in ("self", "cls")]
        assert function.name.startswith("_") or is_warp or len(given) <= MOST_POSITIONAL, f"{function.name}: {given}"


@pytest.mark.parametrize("path", SOURCES, ids=label)
def test_every_file_says_what_it_is(path):
    assert ast.get_docstring(parse(path))


@pytest.mark.parametrize("path", SOURCES, ids=label)
def test_names_come_from_where_they_are_defined(path):
    """One import path a name: what a file imports from a room's file is in that one's `__all__`, and at home there."""
    for node in ast.walk(parse(path)):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("usdfoot."):
            source = REPOSITORY.joinpath(*node.module.split(".")).with_suffix(".py")
            if not source.exists():
                continue  # a module of a package
            own, listed = names_of(source)
            names = {alias.name for alias in node.names}
            assert names <= own, f"{node.module} has {names - own} from elsewhere"
            assert listed is None or names <= listed, f"not in the __all__ of {node.module}: {names - listed}"


@pytest.mark.parametrize("module", all_lists())
def test_public_names_exist_once_and_are_documented(module):
    try:
        namespace = importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name not in EXTRAS:
            raise
        pytest.skip(f"needs {error.name}, which comes with an extra or with usdview")
    names = namespace.__all__
    assert len(names) == len(set(names))
    missing = [name for name in names if not hasattr(namespace, name)]
    assert not missing
    undocumented = [name for name in names if callable(value := getattr(namespace, name)) and not value.__doc__]
    assert not [name for name in undocumented if not getattr(namespace, name).__module__.startswith("warp.")]


@pytest.mark.parametrize("path", SOURCES + SCRIPTS, ids=label)
def test_nothing_is_left_as_a_stub_or_swallowed(path):
    for node in ast.walk(parse(path)):
        assert not (isinstance(node, ast.ExceptHandler) and node.type is None), f"bare except in line {node.lineno}"
        if isinstance(node, ast.Raise) and node.exc is not None:
            assert "NotImplementedError" not in ast.dump(node.exc), f"stub in line {node.lineno}"


@pytest.mark.parametrize("path", SOURCES, ids=label)
def test_errors_say_what_would_be_right_or_list_the_reasons(path):
    kinds = {name for name in errors.__all__ if name.endswith("Error")}
    for node in ast.walk(parse(path)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in kinds:
            told = len(node.args) > 2 or {keyword.arg for keyword in node.keywords} & {"remedy", "names"}
            passed_on = any(isinstance(argument, ast.Starred) for argument in node.args)
            assert told or passed_on, f"line {node.lineno}"


def committed_texts() -> list[Path]:
    """Text files of the source tree, without what make and the tools leave behind."""
    places = ["usdfoot", "tests", "tools", "schemas", "stages", ".ci"]
    files = [path for place in places for path in (REPOSITORY / place).rglob("*") if path.suffix in TEXT_SUFFIXES]
    files += [path for path in REPOSITORY.iterdir() if path.suffix in TEXT_SUFFIXES - {""}]
    files.append(REPOSITORY / "Makefile")
    return sorted(path for path in files if path.is_file() and "__pycache__" not in path.parts)


def test_no_text_names_a_place_on_somebodys_machine():
    found = {
        label(path): match.group()
        for path in committed_texts()
        if path != Path(__file__).resolve() and (match := MACHINE_PATHS.search(path.read_text(encoding="utf-8")))
    }
    assert not found


def test_the_search_for_machine_paths_finds_one():
    assert MACHINE_PATHS.search('open("' + "/home" + '/someone/clip.usd")')
    assert not MACHINE_PATHS.search("</World/Plans/Walker> ../shared/data https://example.org/tmp/x")


def test_the_schemas_room_is_data_only(repository):
    names = {path.name for path in (repository / "schemas").iterdir()}
    assert names == {"schema.usda", "generatedSchema.usda", "plugInfo.json"}


@pytest.mark.parametrize("name", DOCUMENTS)
def test_documents_name_only_files_that_exist(repository, name):
    text = (repository / name).read_text(encoding="utf-8")
    named = set(re.findall(r"`((?:usdfoot|schemas|tests|tools|stages)/[\w./]*)`", text))
    named |= set(re.findall(r"\]\((?!http)([\w./]+)\)", text))
    # stages/ itself is made by a tool and may be named before it is there
    assert named
    assert [path for path in sorted(named - {"stages/"}) if not (repository / path).exists()] == []


def test_the_architecture_names_functions_and_classes_where_they_are(repository):
    text = (repository / "ARCHITECTURE.md").read_text(encoding="utf-8")
    named = re.findall(r"`(\w+)`\s+in\s+`(usdfoot/[\w/]+\.py)`", text)
    assert len(named) > 4
    assert [(name, path) for name, path in named if name not in names_of(repository / path)[0]] == []
