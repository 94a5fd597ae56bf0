"""Every example runs, names a package that is missing, and is listed in examples/README.md with its picture."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
PICTURES = ROOT / "examples" / "pictures"
INSTALLED = {"jtik", "jtik_formulations", "numpy", "casadi", "mink", "mujoco"} | sys.stdlib_module_names
"""Modules that an installation without extras has."""

WITHOUT = """
import runpy, sys
from importlib import metadata

def distribution(name):
    raise metadata.PackageNotFoundError(name)

name, path = sys.argv[1:]
if name == "importlib":
    metadata.distribution = distribution
else:
    sys.modules[name] = None
runpy.run_path(path, run_name="__main__")
"""
"""Runs a script as if a module were not installed; "importlib" stands for distributions."""


def modules(statement: ast.stmt) -> list[str]:
    """The modules that a statement imports, those inside it among them."""
    found = []
    for node in ast.walk(statement):
        if isinstance(node, ast.Import):
            found += [alias.name.partition(".")[0] for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            found.append(str(node.module).partition(".")[0])
    return found


def optional(path: Path) -> list[ast.Try]:
    """The statements that import a package which may be missing."""
    body = ast.parse(path.read_text(encoding="utf-8")).body
    return [one for one in body if isinstance(one, ast.Try) and "ImportError" in ast.unparse(one)]


BLOCKS = [
    pytest.param(path, block, id=f"{path.stem}-{i}") for path in EXAMPLES for i, block in enumerate(optional(path))
]


def run(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    roots = os.pathsep.join([str(ROOT), str(ROOT / "formulations"), os.environ.get("PYTHONPATH", "")])
    return subprocess.run(
        [sys.executable, "-W", "error::UserWarning", *arguments],
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": roots, "MPLBACKEND": "agg"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


def test_all_are_listed() -> None:
    text = (ROOT / "examples" / "README.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^\| \[(\w+\.py)\]", text, flags=re.MULTILINE)) == [path.name for path in EXAMPLES]


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_it_is_short(path: Path) -> None:
    lines = path.read_text(encoding="utf-8").splitlines()
    assert len(lines) < 60
    assert lines[0].startswith('"""')


def test_pictures_are_of_the_examples_that_draw() -> None:
    draw = {path.stem for path in EXAMPLES if "savefig" in path.read_text(encoding="utf-8")}
    text = (ROOT / "examples" / "README.md").read_text(encoding="utf-8")
    assert {path.stem for path in PICTURES.iterdir()} == draw
    assert set(re.findall(r"\(pictures/(\w+)\.png\)", text)) == draw


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_a_package_that_may_be_missing_is_imported_where_that_is_reported(path: Path) -> None:
    excused = optional(path)
    for statement in ast.parse(path.read_text(encoding="utf-8")).body:
        if ast.unparse(statement) not in map(ast.unparse, excused):
            assert set(modules(statement)) <= INSTALLED


@pytest.mark.parametrize(("path", "block"), BLOCKS)
def test_a_missing_package_is_reported_in_one_line(path: Path, block: ast.Try, tmp_path: Path) -> None:
    ended = run("-c", WITHOUT, modules(block)[0], str(path), cwd=tmp_path)
    assert ended.returncode == 1
    assert ended.stdout == ""
    assert re.fullmatch(r"This example needs [\w-]+: python -m pip install \S+\n", ended.stderr)


@pytest.mark.slow
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_it_runs(path: Path, tmp_path: Path) -> None:
    ended = run(str(path), cwd=tmp_path)
    if ended.stderr.startswith("This example needs "):
        pytest.skip(ended.stderr)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout
