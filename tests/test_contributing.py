"""The recipes of CONTRIBUTING.md, copied word for word into an empty file, run and pass the contract harness."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

TEXT = (Path(__file__).parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")
RECIPES = dict(re.findall(r"<!-- recipe: (.+?) -->\n```python\n(.*?)```", TEXT, flags=re.DOTALL))

CHECKS = {
    "own criterion": """
from jtik.testing import check_criterion
check_criterion(elbow_height, jtik.Robot.planar(5), samples=3)
""",
    "criterion": """
import jtik
from jtik.testing import check_criterion
check_criterion(Compactness(), jtik.Robot.planar(5), samples=3)
assert jtik.criteria["compactness"] is Compactness
""",
    "composition": """
from jtik.testing import check_strategy
check_strategy("my_damped", samples=1)
""",
    "programmed": """
from jtik.testing import check_strategy
check_strategy("my_qp", samples=1)
""",
}
"""What is run after each recipe."""


def test_every_recipe_is_checked():
    assert RECIPES.keys() == CHECKS.keys()


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", CHECKS)
def test_a_recipe(name, tmp_path):
    file = tmp_path / "recipe.py"
    file.write_text(RECIPES[name] + CHECKS[name], encoding="utf-8")
    paths = [path for path in sys.path if path]
    run = subprocess.run(
        [
            sys.executable,
            "-W",
            "error",
            "-c",
            f"import sys, runpy; sys.path[:0] = {paths!r}; runpy.run_path({str(file)!r})",
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
