"""The scripts of papers/das1988: the quick run of each, and the tables of the README."""

import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import jtik

from ..conftest import slow

FOLDER = Path(__file__).parents[2] / "papers" / "das1988"
TIMED = "time of a step"
"""Beginning of the numbers that only a full run computes."""
HELPERS = {"claim", "claims"}
NAMES = sorted(path.stem for path in FOLDER.glob("*.py") if path.stem not in HELPERS)
LONG = ("figure_2_2", "five_families", "lyapunov", "near_singular", "out_of_singular")
"""Scripts that solve hundreds of problems even in a quick run."""


@pytest.fixture(scope="session")
def claims(script):
    return script("claims")


@pytest.mark.quick(2)
@pytest.mark.parametrize("name", [*(name for name in NAMES if name not in LONG), *slow(*LONG)])
def test_every_statement_holds_and_every_number_is_as_expected_in_a_quick_run(name, claims):
    report = claims.SCRIPTS[name].run(quick=True)
    assert report.trouble == []
    listed = claims.listed()
    for row in [row for row in listed["claim"] + listed["remark"] if row["script"] == f"{name}.py"]:
        assert row["checks"], row["number"]
        # only full runs have statements about times
        timed = row["number"].startswith(TIMED)
        assert timed or set(row["checks"]) <= set(report.statements), row["number"]


def test_every_claim_names_an_existing_script_and_every_script_has_a_claim(claims):
    named = {row["script"] for row in claims.listed()["claim"]}
    assert all((FOLDER / script).is_file() for script in named)
    assert named | {"five_families.py"} == {f"{name}.py" for name in NAMES}


def test_claims_about_times_are_statements_of_the_full_run(claims):
    script = claims.SCRIPTS["twice_slower"]
    statements = script.statements(script.read_expected())
    (row,) = (row for row in claims.listed()["claim"] if row["number"].startswith(TIMED))
    assert set(row["checks"]) <= set(statements)
    assert all(statements.values())


@pytest.mark.parametrize("name", NAMES)
def test_the_statements_hold_for_the_expected_numbers_of_the_full_run(name, claims):
    script = claims.SCRIPTS[name]
    statements = script.statements(script.read_expected())
    assert [statement for statement, holds in statements.items() if not holds] == []


def test_the_tables_of_the_readme_are_those_of_claims_and_expected_numbers(claims):
    assert claims.main(["--check"]) == 0


def test_a_readme_with_an_outdated_number_is_detected_and_updated(claims, tmp_path):
    changed = tmp_path / "README.md"
    changed.write_text((FOLDER / "README.md").read_text(encoding="utf-8").replace("123.5 (82.5)", "122.5 (82.5)"))
    assert claims.main(["--check"], path=changed) == 1
    assert claims.main([], path=changed) == 0
    assert claims.main(["--check"], path=changed) == 0


def test_verdicts_are_from_a_fixed_list(claims):
    allowed = {
        "holds",
        "holds more generally",
        "holds under the condition",
        "holds as an order, not as a bound",
        "holds, without an advantage",
        "does not hold: a design flaw",
        "does not hold as printed",
        "misprint",
    }
    assert {row["verdict"] for row in claims.listed()["claim"]} <= allowed


@pytest.mark.slow
def test_the_figure_is_drawn(script, tmp_path, monkeypatch):
    figure = script("figure_2_2")
    monkeypatch.setattr(figure, "TARGETS", figure.FEW)
    figure.draw(tmp_path, [])
    assert (tmp_path / "figure_2_2.png").stat().st_size > 10_000


class TestComparison:
    """Reports of numbers that differ from the expected ones."""

    @pytest.fixture
    def example(self, script):
        claim = script("claim")
        return claim, claim.Script(
            name="example",
            keys=("case",),
            tolerances={"share": claim.Within(absolute=3.0), "steps": claim.Within(relative=0.1)},
            compute=lambda quick: [],
            statements=lambda rows: {},
        )

    ROWS = ({"case": "a", "share": 50.0, "steps": 20.0}, {"case": "b", "steps": math.inf})

    def test_rows_differ_beyond_the_tolerance_and_not_within(self, example):
        _, script = example
        assert script.differing(self.ROWS, self.ROWS) == []
        assert script.differing([{**self.ROWS[0], "share": 53.0}, self.ROWS[1]], self.ROWS) == []
        assert script.differing([{**self.ROWS[0], "share": 53.1}, self.ROWS[1]], self.ROWS) == [
            "a: share is 53.1, expected 50"
        ]
        assert script.differing([{**self.ROWS[0], "share": 58.0}, self.ROWS[1]], self.ROWS, slack=3.0) == []

    def test_a_failure_differs_from_a_large_number(self, example):
        _, script = example
        found = script.differing([self.ROWS[0], {"case": "b", "steps": 1e6}], self.ROWS)
        assert found == ["b: steps is 1000000, expected inf"]

    def test_missing_rows_and_cells_are_named(self, example):
        _, script = example
        assert script.differing(self.ROWS[:1], self.ROWS) == ["b: expected, but missing"]
        assert script.differing(self.ROWS, self.ROWS[:1]) == ["b: not expected"]
        assert script.differing([self.ROWS[0], {"case": "b"}], self.ROWS) == ["b: steps is in only one of both"]

    def test_rows_are_restored_from_csv(self, example, tmp_path):
        claim, _ = example
        claim.write(tmp_path / "deep" / "rows.csv", self.ROWS)
        assert claim.read(tmp_path / "deep" / "rows.csv", ("case",)) == list(self.ROWS)

    def test_a_false_statement_gives_exit_status_1(self, example, tmp_path, capsys, monkeypatch):
        claim, script = example
        monkeypatch.setattr(claim, "HERE", tmp_path)
        wrong = replace(script, compute=lambda quick: list(self.ROWS), statements=lambda rows: {"pigs fly": False})
        assert wrong.main("An example.", ["--accept", "--out", str(tmp_path / "out")]) == 1
        output = capsys.readouterr()
        assert "pigs fly" in output.err
        assert "now run" in output.out
        fine = replace(wrong, statements=lambda rows: {"pigs walk": True})
        assert fine.main("An example.", ["--out", str(tmp_path / "out")]) == 0
        off = replace(fine, compute=lambda quick: [{**self.ROWS[0], "share": 60.0}, self.ROWS[1]])
        assert off.main("An example.", ["--out", str(tmp_path / "out")]) == 1
        assert "share is 60, expected 50" in capsys.readouterr().err


@pytest.mark.slow
def test_a_script_runs_from_the_command_line(tmp_path):
    command = [sys.executable, str(FOLDER / "curvature.py"), "--quick", "--out", str(tmp_path)]
    run = subprocess.run(command, capture_output=True, text=True, check=False, cwd=FOLDER.parents[1])
    if "No module named 'jtik'" in run.stderr:
        pytest.skip("jtik is on the path of the tests and not installed")
    assert run.returncode == 0, run.stderr
    assert "as expected" in run.stdout
    assert (tmp_path / "curvature.csv").is_file()


class TestFamilies:
    """The problems of most scripts."""

    @pytest.fixture
    def families(self, script):
        return script("five_families")

    @pytest.mark.parametrize("family", ["generic", "far"])
    def test_targets_drawn_from_configurations_are_end_effector_positions_of_the_robot(self, families, family):
        q0, target = next(families.problems(family, 1))
        assert q0.shape == (10,)
        assert families.tip(q0) == pytest.approx(jtik.Robot.planar(10).position(q0, "tip"), abs=1e-12)
        assert math.hypot(*target) <= 10

    def test_problems_do_not_depend_on_their_number(self, families):
        few, many = list(families.problems("far", 2)), list(families.problems("far", 5))
        for (q, target), (same_q, same_target) in zip(few, many, strict=False):
            assert (q == same_q).all()
            assert (target == same_target).all()

    def test_there_is_an_expected_row_for_every_row(self, families, claims):
        expected = {(row["family"], row["method"]) for row in families.SCRIPT.read_expected()}
        assert expected == {(family, method) for family in families.FAMILIES for method in families.METHODS}
