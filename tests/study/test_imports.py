"""Studies and problems import optional packages only when they are used."""

from __future__ import annotations

import subprocess
import sys

import pytest

OPTIONAL = (
    "pandas",
    "matplotlib",
    "distributed",
    "mink",
    "pink",
    "pinocchio",
    "placo",
    "mujoco",
    "rich",
    "cloudpickle",
)


@pytest.mark.slow
def test_optional_packages_are_not_imported():
    code = (
        f"import sys; sys.path[:0] = {sys.path!r};"
        "import jtik.study, jtik.problems, jtik.study.peers, jtik.study.html, jtik.study.figures.profile;"
        f"print([name for name in {OPTIONAL!r} if name in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
