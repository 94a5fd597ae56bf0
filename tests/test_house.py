"""The rules of the source tree: which module may import which, how long a module may be, and what is at the top."""

from __future__ import annotations

import ast
import functools
import importlib
import statistics
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[1]
JTIK, FORMULATIONS = ROOT / "jtik", ROOT / "formulations" / "jtik_formulations"

LEVELS = (
    ("errors", "types", "arguments", "constructors"),
    ("symbolic",),
    ("geometry", "progress", "result", "factorization", "svd"),
    ("robot",),
    ("task", "criterion", "constraints"),
    ("strategy", "qp"),
    ("registry", "_step"),
    ("_loop",),
    ("solver",),
    ("study", "problems", "planner", "interop", "testing", "plotting", "viewer", "cli", "demo", "__main__", "__init__"),
)
"""Imports run downwards: a module imports those of its own level and of levels above it in this list."""

LEVEL = {subpackage: level for level, names in enumerate(LEVELS) for subpackage in names}

MEDIAN_LINES, MOST_LINES = 120, 350
MOST_AT_THE_TOP = 12

UPWARDS: set[str] = set()
"""Imports that do not run downwards yet. Nothing may be added."""

LOWEST: set[str] = set()
"""Imports of the lowest subpackages that are not removed yet. Nothing may be added."""

PRIVATE: set[str] = set()
"""Private names of jtik that formulations use yet. Nothing may be added."""

LONG: set[str] = set()
"""Modules that are too long yet. Nothing may be added."""


class Import(NamedTuple):
    """One import: the file it is in, the module it names, and the names it takes from it."""

    file: str
    module: str
    names: tuple[str, ...]


def modules(package: Path) -> list[Path]:
    return sorted(package.rglob("*.py"))


def imports(path: Path) -> Iterator[Import]:
    """Every import of a file, also those inside functions, but none that only a type checker sees."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    unseen = {
        node
        for branch in ast.walk(tree)
        if isinstance(branch, ast.If) and ast.unparse(branch.test) == "TYPE_CHECKING"
        for statement in branch.body
        for node in ast.walk(statement)
    }
    file = path.relative_to(ROOT).as_posix()
    for node in ast.walk(tree):
        if node in unseen:
            continue
        if isinstance(node, ast.Import):
            yield from (Import(file, alias.name, ()) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: imports are absolute"
            yield Import(file, node.module or "", tuple(alias.name for alias in node.names))


@functools.cache
def all_imports(package: Path) -> tuple[Import, ...]:
    return tuple(one for path in modules(package) for one in imports(path))


def lines(path: Path) -> int:
    return len(path.read_text(encoding="utf-8").splitlines())


def subpackages_of(one: Import) -> set[str]:
    """The folders or files at the top of ``jtik`` that an import of a jtik module names."""
    first, _, rest = one.module.partition(".")
    if first != "jtik":
        return set()
    if rest:
        return {rest.partition(".")[0]}
    return {name if name in LEVEL else "__init__" for name in one.names} or {"__init__"}


def subpackage(file: str) -> str:
    """The folder or file at the top of ``jtik`` that a file is in."""
    return Path(file).parts[1].removesuffix(".py")


def is_private(name: str) -> bool:
    """Whether a dotted name has a part that begins with one underscore."""
    return any(part.startswith("_") and not part.startswith("__") for part in name.split("."))


def test_every_subpackage_has_a_level() -> None:
    at_the_top = {path.name.removesuffix(".py") for path in JTIK.iterdir() if path.suffix == ".py" or path.is_dir()}
    assert at_the_top - {"__pycache__"} <= set(LEVEL)


def test_imports_run_downwards() -> None:
    upwards = {
        f"{one.file} -> {target}"
        for one in all_imports(JTIK)
        for target in subpackages_of(one)
        if LEVEL[target] > LEVEL[subpackage(one.file)]
    }
    assert upwards <= UPWARDS
    assert upwards >= UPWARDS, "remove from UPWARDS what is done"


@pytest.mark.parametrize(
    ("importer", "allowed"),
    [
        ("errors", {"types"}),
        ("symbolic", {"errors", "types", "arguments"}),
        ("result", {"errors", "types", "arguments"}),
    ],
)
def test_the_lowest_subpackages_import_little(importer: str, allowed: set[str]) -> None:
    found = {
        f"{one.file} -> {target}"
        for one in all_imports(JTIK)
        if subpackage(one.file) == importer
        for target in subpackages_of(one) - allowed - {importer}
    }
    assert found <= LOWEST


def test_casadi_is_imported_in_jtik_symbolic_only() -> None:
    importers = {subpackage(one.file) for one in all_imports(JTIK) if one.module.partition(".")[0] == "casadi"}
    assert importers == {"symbolic"}
    assert not [one for one in all_imports(FORMULATIONS) if one.module.partition(".")[0] == "casadi"]


def test_jtik_never_imports_a_formulation() -> None:
    assert [one for one in all_imports(JTIK) if one.module.partition(".")[0] == "jtik_formulations"] == []


def test_formulations_use_what_a_third_party_could_use() -> None:
    private = {
        f"{one.file} -> {one.module}"
        for one in all_imports(FORMULATIONS)
        if one.module.partition(".")[0] == "jtik" and any(is_private(name) for name in (one.module, *one.names))
    }
    assert private <= PRIVATE
    assert private >= PRIVATE, "remove from PRIVATE what is done"


@pytest.mark.parametrize("module", ["symbolic", "strategy", "qp", "robot", "task", "testing", "interop"])
def test_what_third_parties_import_still_imports(module: str) -> None:
    assert importlib.import_module(f"jtik.{module}").__doc__


def test_modules_are_short() -> None:
    sizes = {
        path.relative_to(ROOT).as_posix(): lines(path)
        for path in [*modules(JTIK), *modules(FORMULATIONS)]
        if lines(path)
    }
    assert statistics.median(sizes.values()) <= MEDIAN_LINES
    long = {file for file, size in sizes.items() if size > MOST_LINES}
    assert long <= LONG
    assert long >= LONG, "remove from LONG what is done"


def test_pictures_and_the_registry_alone_are_reached_from_below() -> None:
    reached = {
        (subpackage(path.relative_to(ROOT).as_posix()), str(ast.literal_eval(call.args[0])))
        for path in modules(JTIK)
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(call, ast.Call) and getattr(call.func, "attr", getattr(call.func, "id", "")) == "import_module"
        if isinstance(call.args[0], ast.Constant)
    }
    upwards = {
        (importer, name)
        for importer, name in reached
        if name.startswith("jtik.") and LEVEL[name.split(".")[1]] > LEVEL[importer]
    }
    assert upwards == {
        ("criterion", "jtik.registry"),
        ("strategy", "jtik.registry"),
        ("result", "jtik.plotting"),
        ("robot", "jtik.plotting"),
    }


def test_few_files_are_at_the_top() -> None:
    files = [path.name for path in JTIK.iterdir() if path.is_file()]
    assert len(files) <= MOST_AT_THE_TOP, files
