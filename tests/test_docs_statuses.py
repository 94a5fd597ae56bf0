"""docs/start/statuses.md: every status is in its table, and every example ends with the status that is its title."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import jtik

TEXT = (Path(__file__).parents[1] / "docs" / "start" / "statuses.md").read_text(encoding="utf-8")
EXAMPLES = dict(re.findall(r"### `(\w+)`\n.*?```python\n(.*?)```", TEXT, flags=re.DOTALL))
NAMES = [status.name for status in jtik.Status]


def test_the_table_has_every_status_once():
    assert re.findall(r"^\| \[`(\w+)`\]\(#(\w+)\) \|", TEXT, flags=re.MULTILINE) == [(n, n.lower()) for n in NAMES]


def test_every_status_has_an_example():
    assert list(EXAMPLES) == NAMES


@pytest.mark.quick(5)
@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_ends_so(name):
    namespace = {"__name__": "example"}
    exec(compile(EXAMPLES[name], f"docs/start/statuses.md: {name}", "exec"), namespace)
    solution = namespace["solution"]
    assert solution.status.name == name
    assert bool(solution) == (name in ("CONVERGED", "REACHED", "SADDLE"))
    assert (jtik.result.solution.TRY in repr(solution)) == (name in ("LOCAL_MINIMUM", "LIMITS", "SINGULAR", "STALLED"))
