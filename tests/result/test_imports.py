"""Results are plain data: no file of theirs imports the engine."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import jtik.result

FILES = sorted(Path(jtik.result.__file__).parent.glob("*.py"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_file_imports_results_and_the_lowest_modules_only(path):
    imported = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0
            imported.add(node.module)
        elif isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
    of_jtik = {name for name in imported if name.split(".")[0] == "jtik"}
    lowest = ("jtik.arguments", "jtik.errors", "jtik.types")
    allowed = {name for name in of_jtik if name in lowest or name.startswith("jtik.result")}
    assert of_jtik == allowed
