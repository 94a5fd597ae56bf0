"""The script of papers/das1988 on a tenth of its problems: what it states must hold there too."""

import importlib.util
import math
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import jtik

COUNT = 20
SCRIPT = Path(__file__).parents[2] / "papers" / "das1988" / "five_families.py"


@pytest.fixture(scope="module")
def paper():
    spec = importlib.util.spec_from_file_location("das1988_five_families", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    yield module
    del sys.modules[spec.name]


@pytest.fixture(scope="module")
def rows(paper):
    return paper.table(COUNT)


@pytest.fixture(scope="module")
def at(rows):
    return {(row.family, row.method): row for row in rows}


def test_every_method_meets_every_family_once(paper, rows):
    assert len(rows) == len(paper.FAMILIES) * len(paper.METHODS)
    assert {(row.family, row.method) for row in rows} == {(f, m) for f in paper.FAMILIES for m in paper.METHODS}


def test_the_statements_of_the_readme_hold(paper, rows):
    assert paper.broken(rows) == []


def test_hybrid_reaches_every_reachable_target_and_never_raises_the_error(paper, at):
    for family in paper.REACHABLE:
        assert at[family, "hybrid"].success == 100
        assert at[family, "hybrid"].rises == 0


@pytest.mark.parametrize("family", ["generic", "far"])
def test_the_targets_drawn_from_configurations_are_the_robots_own_tip(paper, family):
    q0, target = next(paper.problems(family, 1))
    assert q0.shape == (10,)
    assert paper.tip(q0) == pytest.approx(jtik.Robot.planar(10).position(q0, "tip"), abs=1e-12)
    assert math.hypot(*target) <= 10


def test_problems_do_not_depend_on_how_many_are_asked_for(paper):
    few, many = list(paper.problems("far", 2)), list(paper.problems("far", 5))
    for (q, target), (same_q, same_target) in zip(few, many, strict=False):
        assert (q == same_q).all()
        assert (target == same_target).all()


def test_the_printed_S_changes_nothing_on_a_revolute_arm(at):
    # alpha undoes S up to rounding, which a chaotic run may amplify by a few iterations
    for family in ("generic", "far", "near-straight 1e-3"):
        printed, plain = at[family, "transpose, S as printed"], at[family, "transpose, alpha only"]
        assert printed.iterations == pytest.approx(plain.iterations, rel=0.05)
        assert printed.success == plain.success


def test_a_difference_beyond_the_tolerance_is_found_and_named(paper, rows):
    assert paper.differing(rows, rows) == []
    worse = [replace(rows[0], success=rows[0].success - 5), *rows[1:]]
    (line,) = paper.differing(worse, rows)
    assert rows[0].method in line
    assert "success" in line


def test_rows_survive_the_csv_file(paper, rows, tmp_path):
    path = tmp_path / "results" / "rows.csv"
    paper.write(path, rows)
    assert paper.differing(rows, paper.read(path)) == []


def test_there_is_an_expected_row_for_every_row(paper):
    expected = {(row.family, row.method) for row in paper.read(SCRIPT.parent / "expected" / "five_families.csv")}
    assert expected == {(family, method) for family in paper.FAMILIES for method in paper.METHODS}
