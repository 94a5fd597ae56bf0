"""Two browsers operate the same planner for a while; ten minutes of it are measured by hand."""

from __future__ import annotations

import re
import shutil

import pytest

from .operation import CHROMIUM, operate

pytestmark = [pytest.mark.browser, pytest.mark.slow, pytest.mark.xdist_group("browser")]

BROKEN = re.compile(r"failed|could not|\w+Error\b|Exception")
"""What no edit is told that merely comes too late, because of what the other operator has done."""

LEVEL = 600.0
"""Memory of the planner's process [MiB] that is no leak: that of solvers built again and again levels off at 350."""


def test_two_operators_at_the_same_planner():
    pytest.importorskip("playwright.sync_api")
    if not any(map(shutil.which, CHROMIUM)):
        pytest.skip("Chromium is not installed")
    found = operate(30.0)
    assert found["printed as an error"] == ""
    assert found["complaints of the pages"] == []
    assert [text for text in found["errors told"] if BROKEN.search(text)] == []
    assert found["changes"] > 10
    assert found["answers"] > 100
    assert found["periods"] > 600
    _, last = found["memory, first and last tenth [MiB]"]
    assert last < LEVEL
