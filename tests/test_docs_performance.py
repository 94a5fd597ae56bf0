"""The tables of docs/performance.md are those of the recorded runs, and growth is judged as its figures say."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def load(path: Path):
    if not path.is_file():
        pytest.skip("documents and benchmarks are not part of this copy")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def tables():
    return load(ROOT / "docs" / "performance_tables.py")


def test_the_page_has_the_tables_of_the_recorded_runs(tables):
    page = tables.PAGE.read_text(encoding="utf-8")
    assert tables.written(page) == page, "run: python docs/performance_tables.py"


def test_every_step_is_in_the_table(tables):
    rows = tables.steps()
    text = "\n".join(tables.table_of_steps())
    assert {(problem, caches) for problem, _, caches in rows} == {
        (problem, caches) for problem in tables.PROBLEMS for caches in ("hot", "cold")
    }
    for (_, name, _), row in rows.items():
        assert name in tables.LIBRARIES
        assert f"{tables.short(row['microseconds'][0])} µs" in text


def test_growth_is_judged_by_its_figures(tables):
    growth = load(ROOT / "benchmarks" / "growth.py")
    for row in tables.recorded("growth")["rows"]:
        assert len(row["sizes"]) >= 3
        for name, values in row["figures"].items():
            slope = growth.exponent(row["sizes"], values)
            assert row["exponents"][name] == pytest.approx(slope, abs=0.01)
            assert row["judged"][name] == (row["exponents"][name] <= row["bound"] + growth.TOLERANCE)


def test_an_exponent_is_that_of_a_power():
    growth = load(ROOT / "benchmarks" / "growth.py")
    assert growth.exponent([1, 4, 16, 64], [3.0 * k**2 for k in (1, 4, 16, 64)]) == pytest.approx(2.0)
    assert growth.exponent([0, 1, 2, 4, 8], [5.0, 7.0, 7.0, 7.0, 7.0]) == pytest.approx(0.0)
